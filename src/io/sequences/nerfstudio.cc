// Reads folders of nerfstudio: transforms.json has the camera and the files of each frame
// (docs.nerf.studio, "Data conventions"). Intrinsics are at the top, or in each frame. Poses have
// the camera axes of OpenGL. They come from structure from motion or from a phone, so they are no
// ground truth.
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/files.h"
#include "io/images/image_files.h"
#include "io/phones/json_fields.h"
#include "io/phones/phone_recording.h"
#include "io/sequences/confidence.h"
#include "io/sequences/folder.h"
#include "io/sequences/recording.h"
#include "io/stamps/image_names.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

using NerfJson = nlohmann::json;

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
  SetJsonSize(json, "w", "h", path, &camera);
  camera.fx = JsonNumber(json, "fl_x", path);
  camera.fy = json.value("fl_y", camera.fx);
  camera.cx = JsonNumber(json, "cx", path);
  camera.cy = JsonNumber(json, "cy", path);
  camera.distortion = {Coefficient(json, "k1"), Coefficient(json, "k2"), Coefficient(json, "p1"),
                       Coefficient(json, "p2"), Coefficient(json, "k3")};
  camera.Validate(path);
  return camera;
}

// Fields of the camera of a frame. Values of the frame take precedence over values at the top.
NerfJson CameraFields(const NerfJson& json, const NerfJson& frame) {
  NerfJson fields = NerfJson::object();
  for (const char* key :
       {"camera_model", "w", "h", "fl_x", "fl_y", "cx", "cy", "k1", "k2", "k3", "k4", "p1", "p2"}) {
    for (const NerfJson* source : {&frame, &json}) {
      if (fields.contains(key) || !source->contains(key)) continue;
      fields[key] = source->at(key);
    }
  }
  return fields;
}

// Camera at the top, otherwise that of the first frame.
PinholeCamera FirstLens(const NerfJson& json, const std::string& path) {
  const NerfJson none = NerfJson::object();
  return NerfCamera(CameraFields(json, json.contains("fl_x") ? none : json.at("frames").at(0)),
                    path);
}

// Camera of a frame, with the distortion of the first frame.
PinholeCamera LensOfFrame(const NerfJson& json, const NerfJson& frame, const PinholeCamera& first,
                          const std::string& path) {
  if (!frame.contains("fl_x")) return first;
  PinholeCamera camera = NerfCamera(CameraFields(json, frame), path);
  camera.distortion = first.distortion;
  return camera;
}

std::size_t CountOtherDistortion(const NerfJson& frames, const PinholeCamera& first) {
  const std::array keys = {"k1", "k2", "p1", "p2", "k3"};
  std::size_t others = 0;
  for (const NerfJson& frame : frames) {
    bool differs = false;
    for (std::size_t i = 0; i < keys.size(); ++i)
      differs = differs ||
                (frame.contains(keys[i]) && Coefficient(frame, keys[i]) != first.distortion[i]);
    others += differs;
  }
  return others;
}

ParsedRigid NerfPose(const NerfJson& frame, double scale, const std::string& place) {
  const NerfJson& matrix = frame.at("transform_matrix");
  ThrowIf(!matrix.is_array() || matrix.size() < 3, place, " must have 4 rows of 4 numbers");
  std::array<double, 12> rows;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::vector<double> row = JsonNumbers(matrix[i], 4, place);
    std::copy(row.begin(), row.end(), &rows[4 * i]);
    rows[4 * i + 3] /= scale;
  }
  return RigidFromRows(rows, place);
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
  return WithJsonFile(path, [&](const NerfJson& json) {
    RgbdCamera camera;
    const double unit_m = json.value("depth_unit_scale_factor", 0.001);
    ThrowIf(!(unit_m > 0) || !std::isfinite(unit_m), path, ": depth_unit_scale_factor is ", unit_m,
            ", must be positive");
    camera.depth_units_per_metre = 1 / unit_m;
    camera.color = FirstLens(json, path);
    const std::string depth = FirstDepth(json, folder);
    camera.depth = depth.empty() ? camera.color
                                 : ResizedCamera(camera.color, SizeInHeader(ReadFile(depth), depth),
                                                 depth, path);
    camera.color_is_registered = camera.depth.width == camera.color.width;
    camera.Validate(path);
    return SourceCamera{camera, path, false, json.contains("depth_unit_scale_factor")};
  });
}

namespace {

struct NerfFrame {
  FrameFiles files;
  const NerfJson* json = nullptr;  // null: the image is not in transforms.json
};

// Frames with a depth image, by number.
std::vector<NerfFrame> ListNerfFrames(const NerfJson& json, const std::string& folder,
                                      double frames_per_second, PhoneFiles* phone) {
  const std::string path = folder + "/transforms.json";
  std::map<std::string, NerfFrame> by_name;
  std::map<std::string, const NerfJson*> by_color;
  std::vector<std::string> names;
  std::size_t without_depth = 0;
  for (const NerfJson& frame : json.at("frames")) {
    NerfFrame listed;
    listed.json = &frame;
    listed.files.depth_path = ListedFile(frame, "depth_file_path", folder);
    listed.files.color_path = ListedFile(frame, "file_path", folder);
    if (!listed.files.color_path.empty()) by_color[FileNameOf(listed.files.color_path)] = &frame;
    without_depth += listed.files.depth_path.empty();
    if (listed.files.depth_path.empty()) continue;
    const std::string name = FileNameOf(listed.files.depth_path);
    ThrowIf(!by_name.emplace(name, listed).second, path, ": two frames have the depth image ", name,
            ", must be one");
    names.push_back(name);
  }
  std::vector<NerfFrame> frames;
  if (names.empty()) {
    SequenceFiles files = ListRedwoodSequence(folder, frames_per_second);
    phone->has_clock = files.has_clock;
    phone->warnings = std::move(files.warnings);
    phone->unpaired_images = files.unpaired_images;
    for (FrameFiles& frame : files.frames) {
      const auto found = by_color.find(FileNameOf(frame.color_path));
      frames.push_back({std::move(frame), found == by_color.end() ? nullptr : found->second});
    }
    return frames;
  }
  WarnOfCount(without_depth, path, "frames have no depth_file_path and are left out",
              &phone->warnings);
  const std::vector<NamedImage> numbered = NumberImages(names);
  ThrowIf(numbered.size() != names.size(), path, ": ", names.size() - numbered.size(),
          " depth images have no number in their names");
  std::map<long, NerfFrame> by_number;
  for (const NamedImage& image : numbered) {
    ThrowIf(!by_number.emplace(image.number, by_name.at(image.name)).second, path,
            ": two depth images have the number ", image.number);
  }
  for (auto& [number, frame] : by_number) {
    const double stamp_s =
        static_cast<double>(number - by_number.begin()->first) / frames_per_second;
    frame.files.stamps = {stamp_s, stamp_s};
    frames.push_back(std::move(frame));
  }
  return frames;
}

}  // namespace

PhoneFiles ListNerfstudio(const std::string& folder, double frames_per_second, bool has_camera,
                          bool confidence) {
  const std::string path = folder + "/transforms.json";
  return WithJsonFile(path, [&](const NerfJson& json) {
    PhoneFiles files;
    files.has_clock = false;
    files.camera_from = path;
    files.scale_is_given = json.contains("depth_unit_scale_factor");
    PinholeCamera first;
    try {
      const SourceCamera source = ReadNerfstudioCamera(folder);
      first = source.camera.color;
      files.depth_units_per_metre = source.camera.depth_units_per_metre;
    } catch (const InputError&) {
      if (!has_camera) throw;
    }
    const double scale = json.value("applied_scale", 1.);
    ThrowIf(!(scale > 0) || !std::isfinite(scale), path, ": applied_scale is ", scale,
            ", must be positive");
    for (NerfFrame& listed : ListNerfFrames(json, folder, frames_per_second, &files)) {
      PhoneFrame frame;
      frame.files = std::move(listed.files);
      frame.color_camera = first;
      frame.camera_place = path;
      if (listed.json != nullptr && first.width > 0)
        frame.color_camera = LensOfFrame(json, *listed.json, first, path);
      if (listed.json != nullptr && listed.json->contains("transform_matrix"))
        files.poses.AddOpenGl(frame.files.stamps.depth_s,
                              NerfPose(*listed.json, scale, path + ": transform_matrix"));
      files.frames.push_back(std::move(frame));
    }
    WarnOfCount(CountOtherDistortion(json.at("frames"), first), path,
                "frames have another distortion than the first frame, which is used for all",
                &files.warnings);
    if (confidence) {
      std::vector<FrameFiles> frames;
      for (const PhoneFrame& frame : files.frames) frames.push_back(frame.files);
      AddConfidence(folder, files.has_clock, &frames, &files.warnings);
      for (std::size_t i = 0; i < frames.size(); ++i) files.frames[i].files = frames[i];
    }
    return files;
  });
}

}  // namespace surfit
