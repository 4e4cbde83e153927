// Reads raw recordings of Polycam (the description of the format in its project polyform). The
// folder keyframes/ has files with one name per frame, its time in us:
//   images/*.jpg, cameras/*.json    colour with its intrinsics and pose
//   corrected_images/, corrected_cameras/  undistorted colour, optimised pose; not always present
//   depth/*.png                     16-bit counts of mm
//   confidence/*.png                0 (low), 127, 255 (high)
// Poses have the camera axes of ARKit: x right, y up, z backward.
#include <map>

#include "io/phones/json_fields.h"
#include "io/phones/phone_recording.h"
#include "io/sequences/folder.h"

namespace surfit {
namespace {

std::string StemOfName(const std::string& name) { return name.substr(0, name.rfind('.')); }

// Paths of a folder by the stems of their names.
std::map<std::string, std::string> PathsByStem(const std::string& folder,
                                               bool (*wanted)(const std::string&)) {
  std::map<std::string, std::string> paths;
  for (const std::string& name : NamesIn(folder))
    if (wanted(name)) paths.emplace(StemOfName(name), Concat(folder, "/", name));
  return paths;
}

bool IsJsonName(const std::string& name) { return EndsWith(name, ".json"); }

// Time in the camera file, otherwise in its name.
double PolycamStamp(const nlohmann::json& json, const std::string& path, const std::string& stem) {
  constexpr double kPerSecond = 1e6;
  if (json.contains("timestamp")) return JsonNumber(json, "timestamp", path) / kPerSecond;
  ThrowIf(stem.empty() || stem.find_first_not_of("0123456789") != stem.npos, path,
          ": timestamp is missing, and the name is no time in us");
  return FiniteNumber(stem) / kPerSecond;
}

ParsedRigid PolycamPose(const nlohmann::json& json, const std::string& path) {
  std::array<double, 12> rows;
  for (int i = 0; i < 12; ++i) rows[i] = JsonNumber(json, Concat("t_", i / 4, i % 4), path);
  return RigidFromRows(rows, path);
}

PinholeCamera PolycamLens(const nlohmann::json& json, const std::string& path) {
  PinholeCamera camera;
  SetJsonSize(json, "width", "height", path, &camera);
  return LensOf({camera.width, camera.height},
                {JsonNumber(json, "fx", path), JsonNumber(json, "fy", path),
                 JsonNumber(json, "cx", path), JsonNumber(json, "cy", path)},
                path);
}

}  // namespace

PhoneFiles ListPolycam(const std::string& folder, bool confidence) {
  const std::string root = IsFolder(folder + "/keyframes") ? folder + "/keyframes" : folder;
  const auto list = [&](const char* name, bool (*wanted)(const std::string&)) {
    return PathsByStem(Concat(root, "/", name), wanted);
  };
  const auto depth = list("depth", IsImageName), images = list("images", IsImageName),
             corrected = list("corrected_images", IsImageName);
  const auto cameras = list("cameras", IsJsonName),
             corrected_cameras = list("corrected_cameras", IsJsonName);
  PhoneFiles files;
  files.camera_from = root + (corrected_cameras.empty() ? "/cameras" : "/corrected_cameras");
  std::map<double, PhoneFrame> frames;
  std::size_t without_camera = 0, without_color = 0, uncorrected = 0;
  for (const auto& [stem, depth_path] : depth) {
    const bool is_corrected = corrected.count(stem) > 0 && corrected_cameras.count(stem) > 0;
    const auto& of_lens = is_corrected ? corrected_cameras : cameras;
    const auto lens = of_lens.find(stem);
    if (lens == of_lens.end()) {
      ++without_camera;
      continue;
    }
    uncorrected += !is_corrected;
    PhoneFrame frame;
    frame.files.depth_path = depth_path;
    const auto& of_color = is_corrected ? corrected : images;
    const auto color = of_color.find(stem);
    if (color != of_color.end()) frame.files.color_path = color->second;
    without_color += color == of_color.end();
    const std::string& name = stem;
    const std::string& path = lens->second;
    frame.camera_place = path;
    const double stamp_s = WithJsonFile(path, [&](const nlohmann::json& json) {
      frame.color_camera = PolycamLens(json, path);
      const double at_s = PolycamStamp(json, path, name);
      files.poses.AddOpenGl(at_s, PolycamPose(json, path));
      return at_s;
    });
    frame.files.stamps = {stamp_s, stamp_s};
    ThrowIf(!frames.emplace(stamp_s, frame).second, path,
            ": its timestamp is that of another frame, must be one frame per time");
  }
  for (auto& [stamp_s, frame] : frames) files.frames.push_back(std::move(frame));
  ThrowIf(files.frames.empty(), root, ": no image in depth/ has a file in cameras/");
  const std::size_t used = frames.size();
  const auto cameras_only = static_cast<std::size_t>(
      std::count_if(cameras.begin(), cameras.end(),
                    [&](const auto& camera) { return depth.count(camera.first) == 0; }));
  files.unpaired_images = static_cast<int>(without_camera + without_color);
  WarnOfCount(without_camera, root + "/depth", "images have no file in cameras/ and are left out",
              &files.warnings);
  WarnOfCount(without_color, root + "/depth", "images have no image in images/", &files.warnings);
  WarnOfCount(cameras_only, root + "/cameras", "files have no image in depth/ and are left out",
              &files.warnings);
  if (uncorrected < used)
    WarnOfCount(uncorrected, root + "/corrected_cameras",
                "frames are missing: images/ and cameras/ are used for them", &files.warnings);
  if (confidence) {
    AddPhoneConfidence(root + "/confidence", &files);
    // The first images can have low values only.
    for (PhoneFrame& frame : files.frames) frame.files.confidence_range = 255;
  }
  return files;
}

}  // namespace surfit
