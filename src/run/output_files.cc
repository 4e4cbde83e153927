#include "run/output_files.h"

#include <filesystem>

#include "surfit/core/atomic_file.h"
#include "surfit/core/error.h"

namespace surfit {

void PrepareOutputFolder(const std::string& folder, const std::vector<std::string>& former_files) {
  namespace fs = std::filesystem;
  std::error_code error;
  fs::create_directories(folder, error);
  if (error || !fs::is_directory(folder)) {
    throw InputError(Concat(folder, ": cannot make the output folder: ", error.message()));
  }
  for (const std::string& name : former_files) {
    fs::remove(fs::path(folder) / name, error);
    if (error) {
      throw InputError(Concat(folder, "/", name, ": cannot be replaced: ", error.message()));
    }
  }
}

void WriteJson(const Json& json, const std::string& path, int indent) {
  WriteFileAtomically(path, [&](std::ostream& file) {
    file << json.dump(indent, ' ', false, Json::error_handler_t::replace) << '\n';
  });
}

Json CameraToJson(const PinholeCamera& camera) {
  return {{"width", camera.width}, {"height", camera.height}, {"fx", camera.fx},
          {"fy", camera.fy},       {"cx", camera.cx},         {"cy", camera.cy}};
}

PinholeCamera CameraFromJson(const Json& json) {
  PinholeCamera camera;
  camera.width = json.at("width");
  camera.height = json.at("height");
  camera.fx = json.at("fx");
  camera.fy = json.at("fy");
  camera.cx = json.at("cx");
  camera.cy = json.at("cy");
  camera.Validate("camera");
  return camera;
}

}  // namespace surfit
