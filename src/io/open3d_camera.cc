#include "io/open3d_camera.h"

#include <nlohmann/json.hpp>

#include "core/read_file.h"
#include "surfit/core/error.h"

namespace surfit {

PinholeCamera ReadOpen3dCamera(const std::string& path) {
  PinholeCamera camera;
  try {
    const auto json = nlohmann::json::parse(ReadFile(path));
    const auto matrix = json.at("intrinsic_matrix").get<std::vector<double>>();
    camera.width = json.at("width").get<int>();
    camera.height = json.at("height").get<int>();
    camera.fx = matrix.at(0);
    camera.fy = matrix.at(4);
    camera.cx = matrix.at(6);
    camera.cy = matrix.at(7);
  } catch (const nlohmann::json::exception& error) {
    throw InputError(Concat(path, ": ", error.what()));
  } catch (const std::out_of_range&) {
    throw InputError(path + ": intrinsic_matrix must have 9 numbers");
  }
  camera.Validate(path);
  return camera;
}

}  // namespace surfit
