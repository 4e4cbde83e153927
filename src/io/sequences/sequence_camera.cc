#include "io/sequences/sequence_camera.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/files.h"
#include "io/files/text.h"
#include "io/sequences/folder.h"
#include "io/sequences/recording.h"
#include "surfit/core/error.h"
#include "surfit/io/camera_files.h"

namespace surfit {
namespace {

// Reads a camera of Open3D: JSON with width, height and the column-major 3 x 3 intrinsic_matrix.
// Throws InputError with the path and the reason.
PinholeCamera ReadOpen3dCamera(const std::string& path) {
  PinholeCamera camera;
  try {
    const auto json = nlohmann::json::parse(ReadJsonText(path));
    const auto matrix = json.at("intrinsic_matrix").get<std::vector<double>>();
    camera.width = json.at("width").get<int>();
    camera.height = json.at("height").get<int>();
    camera.fx = matrix.at(0);
    camera.fy = matrix.at(4);
    camera.cx = matrix.at(6);
    camera.cy = matrix.at(7);
  } catch (const nlohmann::json::exception& error) {
    throw InputError(path, ": ", error.what());
  } catch (const std::out_of_range&) {
    throw InputError(path, ": intrinsic_matrix must have 9 numbers");
  }
  camera.Validate(path);
  return camera;
}

// Kinect with the default intrinsics of the ROS driver and the depth scale of TUM.
RgbdCamera RosDefault() {
  RgbdCamera camera = CameraPreset("redwood");
  camera.depth_units_per_metre = 5000;
  return camera;
}

SourceCamera Preset(const std::string& name, const std::string& why = "") {
  return {CameraPreset(name), "the preset " + name + why};
}

SourceCamera Guessed(const RgbdCamera& camera) { return {camera, "GUESSED", true}; }

SourceCamera RedwoodCamera(const std::string& folder) {
  RgbdCamera camera = CameraPreset("redwood");
  for (const char* name : {"/camera_intrinsic.json", "/intrinsic.json"}) {
    if (!HasFile(folder + name)) continue;
    camera.depth = ReadOpen3dCamera(folder + name);
    return {camera, folder + name + " (with the depth scale of Redwood)"};
  }
  if (HasFile(folder + "/transforms.json")) return ReadNerfstudioCamera(folder);
  return Guessed(camera);
}

RgbdCamera ReadCamParams(const std::string& path) {
  RgbdCamera camera;
  try {
    const auto json = nlohmann::json::parse(ReadJsonText(path)).at("camera");
    camera.depth.width = json.at("w").get<int>();
    camera.depth.height = json.at("h").get<int>();
    camera.depth.fx = json.at("fx").get<double>();
    camera.depth.fy = json.at("fy").get<double>();
    camera.depth.cx = json.at("cx").get<double>();
    camera.depth.cy = json.at("cy").get<double>();
    camera.depth_units_per_metre = json.at("scale").get<double>();
  } catch (const nlohmann::json::exception& error) {
    throw InputError(path, ": ", error.what());
  }
  camera.Validate(path);
  return camera;
}

// Reads cam_params.json in the folder or in its parent folder (as in the NICE-SLAM download).
// Without this file: the preset `replica`. Throws InputError with the path if the file is
// malformed.
SourceCamera ReplicaCamera(const std::string& folder) {
  for (const char* name : {"/cam_params.json", "/../cam_params.json"}) {
    if (HasFile(folder + name)) return {ReadCamParams(folder + name), folder + name, false, true};
  }
  return Preset("replica");
}

// Reads the camera of _info.txt, which is beside the frames of recordings in the layout of
// 7-Scenes: lines "m_depthWidth = 640", and 4 x 4 matrices as "m_calibrationDepthIntrinsic = 525 0
// ...". Throws InputError with the path and the key.
RgbdCamera ReadInfoText(const std::string& path) {
  std::map<std::string, std::vector<std::string>> values;
  for (const TextRow& row : ReadTextRows(path)) {
    if (row.columns.size() > 2 && row.columns[1] == "=")
      values[row.columns[0]].assign(row.columns.begin() + 2, row.columns.end());
  }
  const auto numbers = [&](const std::string& key, std::size_t count) {
    const std::vector<std::string>& words = values[key];
    ThrowIf(words.size() < count, path, ": ", key, " has ", words.size(), " numbers, must have ",
            count);
    std::vector<double> parsed;
    for (const std::string& word : words) parsed.push_back(ParseNumber(word, path + ": " + key));
    return parsed;
  };
  const auto pinhole = [&](const std::string& name) {
    const std::vector<double> matrix = numbers("m_calibration" + name + "Intrinsic", 16);
    const std::string stem = name == "Depth" ? "m_depth" : "m_color";
    PinholeCamera camera;
    camera.width = static_cast<int>(numbers(stem + "Width", 1)[0]);
    camera.height = static_cast<int>(numbers(stem + "Height", 1)[0]);
    camera.fx = matrix[0];
    camera.cx = matrix[2];
    camera.fy = matrix[5];
    camera.cy = matrix[6];
    return camera;
  };
  RgbdCamera camera;
  camera.depth = pinhole("Depth");
  if (values.count("m_calibrationColorIntrinsic") > 0) camera.color = pinhole("Color");
  camera.color_is_registered =
      camera.color.width == 0 || HaveEqualIntrinsics(camera.color, camera.depth);
  camera.depth_units_per_metre = numbers("m_depthShift", 1)[0];
  camera.Validate(path);
  return camera;
}

// Other cameras use the layout of 7-Scenes too, so the preset is a guess unless the format is set.
SourceCamera SevenScenesCamera(const SequenceOptions& options) {
  const std::string info = options.path + "/_info.txt";
  if (HasFile(info)) return {ReadInfoText(info), info, false, true};
  if (options.format != "auto") return Preset("seven_scenes");
  return Guessed(CameraPreset("seven_scenes"));
}

// The preset is certain only with a file *.gt.freiburg, because many recordings have numbered
// frames.
SourceCamera IclNuimCamera(const SequenceOptions& options) {
  const auto names = NamesIn(options.path);
  const bool is_named = std::any_of(names.begin(), names.end(), [](const std::string& name) {
    return EndsWith(name, ".gt.freiburg");
  });
  if (is_named || options.format != "auto") return Preset("icl_nuim");
  return Guessed(CameraPreset("icl_nuim"));
}

// Camera preset of the recording name in the header of an image list, for example in TUM datasets:
//   # file: 'rgbd_dataset_freiburg1_desk.bag'
// Returns "" without a recording name.
std::string PresetInHead(const std::string& list) {
  constexpr std::string_view kName = "freiburg";
  std::istringstream lines(ReadFile(list));
  for (std::string line; std::getline(lines, line) && !line.empty() && line[0] == '#';) {
    const std::size_t name = line.find(kName);
    if (name == line.npos || line.find("file:") == line.npos) continue;
    const std::string number = line.substr(name + kName.size(), 1);
    if (number == "1" || number == "2" || number == "3") return "tum_fr" + number;
  }
  return "";
}

// Camera preset for the recording name in rgb.txt or depth.txt; std::nullopt without such a name.
std::optional<SourceCamera> TumCamera(const std::string& folder) {
  for (const char* name : {"/rgb.txt", "/depth.txt"}) {
    const std::string list = folder + name;
    const std::string preset = HasFile(list) ? PresetInHead(list) : "";
    if (preset.empty()) continue;
    return Preset(preset, ", by the recording name in " + list);
  }
  return std::nullopt;
}

std::string GuessWarning(const std::string& path, const RgbdCamera& camera) {
  std::string text =
      Concat(path, " does not specify its camera, which is GUESSED: ", FormatDepthCamera(camera),
             ". A wrong camera distorts poses and map. ");
  if (camera.depth.fy < 0) text += "The guess is ICL-NUIM, whose images are mirrored. ";
  return text +
         "Set the camera with a camera.yaml (surfit_convert --to=camera_yaml writes a template), "
         "with intrinsics and depth_scale, or with a preset as camera";
}

SourceCamera BaseCamera(const SequenceOptions& options, const std::string& format,
                        const CameraReader& tell) {
  const std::string yaml = CameraFile(options, format);
  if (!yaml.empty()) return {ReadCameraYaml(yaml), yaml, false, true};
  if (!options.camera.empty()) return Preset(options.camera);
  if (tell) return tell();
  if (format == "sens") return {ReadSensCamera(options.path), "the file header", false, true};
  if (format == "redwood" || format == "watch") return RedwoodCamera(options.path);
  if (format == "replica") return ReplicaCamera(options.path);
  if (format == "nerfstudio") return ReadNerfstudioCamera(options.path);
  if (format == "seven_scenes") return SevenScenesCamera(options);
  if (format == "icl_nuim") return IclNuimCamera(options);
  if (format == "klg") return Guessed(CameraPreset("klg"));
  if (format != "tum") return Preset(format);
  const auto camera = TumCamera(options.path);
  return camera ? *camera : Guessed(RosDefault());
}

void SetIntrinsics(const std::array<double, 4>& values, PinholeCamera* camera) {
  camera->width = camera->height = 0;
  camera->fx = values[0];
  camera->fy = values[1];
  camera->cx = values[2];
  camera->cy = values[3];
}

void OverrideColor(const SequenceOptions& options, RgbdCamera* camera) {
  if (options.color_intrinsics) {
    if (camera->color_is_registered) camera->color = {};
    camera->color_is_registered = false;
    SetIntrinsics(*options.color_intrinsics, &camera->color);
  }
  ThrowIf(camera->color_is_registered && (options.color_distortion || options.color_from_depth),
          "color_distortion and color_from_depth need a separate colour camera: set "
          "color_intrinsics too");
  if (options.color_distortion) camera->color.distortion = *options.color_distortion;
  if (options.color_from_depth) camera->color_from_depth = *options.color_from_depth;
}

// Unknown image sizes (0 x 0) are accepted.
void ValidateFigures(RgbdCamera camera) {
  for (PinholeCamera* c : {&camera.depth, &camera.color}) {
    if (c->width == 0 && c->height == 0) c->width = c->height = 1;
  }
  camera.Validate("camera");
  ThrowIf(!camera.color_is_registered && (camera.color.fy < 0) != (camera.depth.fy < 0),
          "camera: fy is ", camera.depth.fy, " for depth and ", camera.color.fy,
          " for colour, must have the same sign");
}

// Path of the camera file: camera.yaml in a folder, F.klg.yaml for a file F.klg, "" for a live
// camera.
std::string OwnCameraFile(const SequenceOptions& options, const std::string& format) {
  if (format == "openni2") return "";
  const bool is_file = MayBeFile(format) && !IsFolder(options.path);
  return options.path + (is_file ? ".yaml" : "/camera.yaml");
}

// Values of the options take precedence over `base`.
std::string OriginWithFigures(const SequenceOptions& options, const SourceCamera& base) {
  const bool scale = options.depth_units_per_metre.has_value();
  if (options.intrinsics && scale) return "the options";
  if (options.intrinsics) return "the options, depth scale: " + base.from;
  return base.from + (scale ? ", depth scale: the options" : "");
}

// Adds a warning if the camera file of the sequence contains a different camera or is invalid.
// `own`: path of this file.
void AddOverrideWarning(const SequenceOptions& options, const std::string& own,
                        const RgbdCamera& camera, std::vector<std::string>* warnings) {
  std::string told;
  try {
    if (!own.empty() && HasFile(own)) told = FormatDepthCamera(ReadCameraYaml(own));
  } catch (const InputError& error) {
    told = error.what();
  }
  const std::string taken = FormatDepthCamera(camera);
  if (told.empty() || told == taken) return;
  const bool is_named = !options.camera.empty() && !options.intrinsics;
  warnings->push_back(Concat("the depth camera is ", taken, ", from ",
                             is_named ? options.camera + " (camera)" : "the options",
                             "; ignored: ", own, ": ", told));
}

}  // namespace

std::string FormatDepthCamera(const RgbdCamera& camera) {
  const PinholeCamera& c = camera.depth;
  std::string text = Concat(c.fx, " ", c.fy, " ", c.cx, " ", c.cy, " px");
  if (c.HasDistortion()) {
    text += ", distortion";
    for (const double number : c.distortion) text += Concat(" ", number);
  }
  if (!camera.disparity.IsGiven())
    return Concat(text, ", ", camera.depth_units_per_metre, " depth units per metre");
  const Disparity& d = camera.disparity;
  return Concat(text, ", disparity with ", d.counts_per_px, " units per px, ", d.count_at_infinity,
                " units at infinity, baseline ", d.baseline_m, " m, focal length ", d.focal_px,
                " px");
}

bool HaveEqualIntrinsics(const PinholeCamera& a, const PinholeCamera& b) {
  return a.width == b.width && a.height == b.height && a.fx == b.fx && a.fy == b.fy &&
         a.cx == b.cx && a.cy == b.cy && a.distortion == b.distortion;
}

std::string PresetsOfSize(int width, int height) {
  std::string text;
  for (const std::string& name : CameraPresetNames()) {
    const PinholeCamera camera = CameraPreset(name).depth;
    if (camera.width != width || camera.height != height) continue;
    text += (text.empty() ? "" : ", ") + name;
  }
  return text;
}

bool ResolveCamera(const SequenceOptions& options, const CameraReader& tell, SequenceInfo* info) {
  const SourceCamera base = BaseCamera(options, info->format, tell);
  RgbdCamera camera = base.camera;
  if (options.intrinsics) SetIntrinsics(*options.intrinsics, &camera.depth);
  if (options.distortion) camera.depth.distortion = *options.distortion;
  if (options.depth_units_per_metre) {
    camera.depth_units_per_metre = *options.depth_units_per_metre;
    camera.disparity = {};
  }
  if (options.inverse_depth_sigma) camera.noise.inverse_depth_sigma = *options.inverse_depth_sigma;
  if (options.frames_per_second) camera.frames_per_second = *options.frames_per_second;
  if (options.latency_s) camera.latency_s = *options.latency_s;
  if (options.color_latency_s) camera.color_latency_s = *options.color_latency_s;
  if (options.readout_s) camera.readout_s = *options.readout_s;
  OverrideColor(options, &camera);
  ValidateFigures(camera);
  info->camera = camera;
  info->camera_from = OriginWithFigures(options, base);
  info->camera_is_guessed = base.is_guessed && !options.intrinsics;
  if (info->camera_is_guessed) info->warnings.push_back(GuessWarning(options.path, camera));
  AddOverrideWarning(options, OwnCameraFile(options, info->format), camera, &info->warnings);
  return base.scale_is_given || options.depth_units_per_metre.has_value();
}

void DropLatency(const SequenceOptions& options, RgbdCamera* camera) {
  if (options.latency_s && *options.latency_s != 0) {
    throw InputError("latency_s is ", *options.latency_s,
                     ", must be 0 or absent: the timestamps of ", options.path,
                     " are not from a clock");
  }
  camera->latency_s = 0;
}

std::string CameraFile(const SequenceOptions& options, const std::string& format) {
  if (std::filesystem::path(options.camera).extension() == ".yaml") return options.camera;
  if (!options.camera.empty()) return "";
  const std::string yaml = OwnCameraFile(options, format);
  return !yaml.empty() && HasFile(yaml) ? yaml : "";
}

std::string NameOfCamera(const SequenceOptions& options) {
  return options.camera.empty() ? "the sequence's own camera" : "the camera " + options.camera;
}

InverseDepthField ReadDepthField(const SequenceOptions& options, const std::string& format) {
  const std::string yaml = CameraFile(options, format);
  if (yaml.empty()) return {};
  const InverseDepthField field = ReadInverseDepthField(yaml);
  return ReadCameraYaml(yaml).depth.fy < 0 ? Mirrored(field) : field;
}

}  // namespace surfit
