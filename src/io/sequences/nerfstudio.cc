// Reads folders of nerfstudio: transforms.json has the camera and the files of each frame
// (docs.nerf.studio, "Data conventions"). Its poses come from structure from motion or from a
// phone. They are no ground truth, and are not read.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/files.h"
#include "io/images/image_files.h"
#include "io/sequences/folder.h"
#include "io/sequences/recording.h"
#include "io/stamps/image_names.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

using NerfJson = nlohmann::json;

// Parses the file with `read(json)`. JSON errors become InputErrors with the path.
template <typename Read>
auto WithNerfJson(const std::string& path, const Read& read) {
  try {
    return read(NerfJson::parse(ReadJsonText(path)));
  } catch (const NerfJson::exception& error) {
    throw InputError(path, ": ", error.what());
  }
}

std::string ListedFile(const NerfJson& frame, const char* key, const std::string& folder) {
  const auto name = frame.value(key, std::string());
  const std::filesystem::path normal = std::filesystem::path(name).lexically_normal();
  ThrowIf(!name.empty() && (normal.is_absolute() || *normal.begin() == ".."), folder,
          "/transforms.json: '", name, "' is outside the folder of the sequence");
  return name.empty() ? "" : Concat(folder, "/", normal.string());
}

double Coefficient(const NerfJson& camera, const char* key) { return camera.value(key, 0.); }

PinholeCamera NerfCamera(const NerfJson& json, const std::string& path) {
  const auto model = json.value("camera_model", std::string("OPENCV"));
  ThrowIf(model != "OPENCV" && model != "PINHOLE" && model != "SIMPLE_PINHOLE", path,
          ": camera_model is '", model, "', must be OPENCV or PINHOLE");
  ThrowIf(Coefficient(json, "k4") != 0, path, ": k4 is ", Coefficient(json, "k4"), ", must be 0");
  PinholeCamera camera;
  camera.width = static_cast<int>(json.at("w").get<double>());
  camera.height = static_cast<int>(json.at("h").get<double>());
  camera.fx = json.at("fl_x").get<double>();
  camera.fy = json.value("fl_y", camera.fx);
  camera.cx = json.at("cx").get<double>();
  camera.cy = json.at("cy").get<double>();
  camera.distortion = {Coefficient(json, "k1"), Coefficient(json, "k2"), Coefficient(json, "p1"),
                       Coefficient(json, "p2"), Coefficient(json, "k3")};
  camera.Validate(path);
  return camera;
}

// Camera of the same lens for images of another size.
PinholeCamera Resized(const PinholeCamera& camera, ImageSize size, const std::string& depth_path) {
  if (size.width == camera.width && size.height == camera.height) return camera;
  const double x = static_cast<double>(size.width) / camera.width;
  const double y = static_cast<double>(size.height) / camera.height;
  ThrowIf(std::abs(x / y - 1) > 0.02, depth_path, " is ", size.width, " x ", size.height,
          " pixels, must have the aspect ratio of the ", camera.width, " x ", camera.height,
          " camera of transforms.json");
  PinholeCamera resized = camera;
  resized.width = size.width;
  resized.height = size.height;
  resized.fx *= x;
  resized.fy *= y;
  resized.cx = (camera.cx + 0.5) * x - 0.5;
  resized.cy = (camera.cy + 0.5) * y - 0.5;
  return resized;
}

// Intrinsics are at the top, or in each frame.
const NerfJson& WithIntrinsics(const NerfJson& json) {
  return json.contains("fl_x") ? json : json.at("frames").at(0);
}

// Adds a warning if the focal length changes between frames, for example by the autofocus of a
// phone.
void WarnOfOtherLenses(const NerfJson& json, const std::string& path,
                       std::vector<std::string>* warnings) {
  constexpr double kMaxRatio = 0.002;
  const double first = WithIntrinsics(json).at("fl_x").get<double>();
  int others = 0;
  double largest = 0;
  for (const NerfJson& frame : json.at("frames")) {
    const double difference = std::abs(frame.value("fl_x", first) / first - 1);
    others += difference > kMaxRatio;
    largest = std::max(largest, difference);
  }
  if (others == 0) return;
  warnings->push_back(Concat(path, ": ", others, " frames have another fl_x than the first frame, ",
                             "by up to ", 0.1 * std::round(1000 * largest),
                             " %: the intrinsics of the first frame are used for all"));
}

std::string FileNameOf(const std::string& path) { return path.substr(path.rfind('/') + 1); }

// First depth image of the folder; "" if no frame has one.
std::string FirstDepth(const NerfJson& json, const std::string& folder) {
  for (const NerfJson& frame : json.at("frames")) {
    std::string depth = ListedFile(frame, "depth_file_path", folder);
    if (!depth.empty()) return depth;
  }
  const std::vector<std::string> names = NamesIn(folder + "/depth");
  const auto image = std::find_if(names.begin(), names.end(), IsImageName);
  return image == names.end() ? "" : Concat(folder, "/depth/", *image);
}

}  // namespace

SourceCamera ReadNerfstudioCamera(const std::string& folder) {
  const std::string path = folder + "/transforms.json";
  return WithNerfJson(path, [&](const NerfJson& json) {
    RgbdCamera camera;
    const double unit_m = json.value("depth_unit_scale_factor", 0.001);
    ThrowIf(!(unit_m > 0) || !std::isfinite(unit_m), path, ": depth_unit_scale_factor is ", unit_m,
            ", must be positive");
    camera.depth_units_per_metre = 1 / unit_m;
    camera.color = NerfCamera(WithIntrinsics(json), path);
    const std::string depth = FirstDepth(json, folder);
    camera.depth = depth.empty()
                       ? camera.color
                       : Resized(camera.color, SizeInHeader(ReadFile(depth), depth), depth);
    camera.color_is_registered = camera.depth.width == camera.color.width;
    camera.Validate(path);
    return SourceCamera{camera, path, false, json.contains("depth_unit_scale_factor")};
  });
}

SequenceFiles ListNerfstudioSequence(const std::string& folder, double frames_per_second) {
  const std::string path = folder + "/transforms.json";
  return WithNerfJson(path, [&](const NerfJson& json) {
    SequenceFiles files;
    std::map<std::string, FrameFiles> by_name;
    std::vector<std::string> names;
    int without_depth = 0;
    for (const NerfJson& frame : json.at("frames")) {
      FrameFiles of_frame;
      of_frame.depth_path = ListedFile(frame, "depth_file_path", folder);
      of_frame.color_path = ListedFile(frame, "file_path", folder);
      without_depth += of_frame.depth_path.empty();
      if (of_frame.depth_path.empty()) continue;
      const std::string name = FileNameOf(of_frame.depth_path);
      ThrowIf(!by_name.emplace(name, of_frame).second, path, ": two frames have the depth image ",
              name, ", must be one");
      names.push_back(name);
    }
    if (names.empty()) {
      files = ListRedwoodSequence(folder, frames_per_second);
    } else if (without_depth > 0) {
      files.warnings.push_back(
          Concat(path, ": ", without_depth, " frames have no depth_file_path and are left out"));
    }
    const std::vector<NamedImage> numbered = NumberImages(names);
    ThrowIf(numbered.size() != names.size(), path, ": ", names.size() - numbered.size(),
            " depth images have no number in their names");
    std::map<long, FrameFiles> by_number;
    for (const NamedImage& image : numbered) {
      ThrowIf(!by_number.emplace(image.number, by_name.at(image.name)).second, path,
              ": two depth images have the number ", image.number);
    }
    for (auto& [number, frame] : by_number) {
      const double stamp_s =
          static_cast<double>(number - by_number.begin()->first) / frames_per_second;
      frame.stamps = {stamp_s, stamp_s};
      files.frames.push_back(std::move(frame));
    }
    WarnOfOtherLenses(json, path, &files.warnings);
    return files;
  });
}

}  // namespace surfit
