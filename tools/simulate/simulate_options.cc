#include "simulate/simulate_options.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <set>

#include "common/settings_text.h"
#include "core/shared_options.h"
#include "simulate/simulated_sensor.h"
#include "surfit/core/error.h"
#include "surfit/simulation/scene.h"

namespace surfit::tools {
namespace {

void CheckDepthError(const std::vector<double>& distortion) {
  constexpr double kLargest = 0.1;
  const auto is_valid = [](double coefficient) { return std::abs(coefficient) <= kLargest; };
  if (distortion.empty()) return;
  ThrowIf(distortion.size() + 1 != InverseDepthField::kSize ||
              !std::all_of(distortion.begin(), distortion.end(), is_valid),
          "inverse_depth_distortion is ", OptionToText(distortion), ", must be five numbers from ",
          -kLargest, " to ", kLargest);
}

void CheckTimes(const std::vector<std::string>& times) {
  std::set<std::string> unused = {"latency_s", "color_latency_s", "readout_s"};
  for (const std::string& name : times) {
    ThrowIf(unused.erase(name) == 0, "camera_yaml_times contains '", name,
            "', must be latency_s, color_latency_s or readout_s, each once");
  }
}

void CheckMount(const std::vector<double>& mount) {
  const double norm = mount.size() == 7 ? Eigen::Vector4d(mount.data() + 3).norm() : 0;
  ThrowIf(!mount.empty() && !(std::abs(norm - 1) < 0.01), "camera_from_imu is ",
          OptionToText(mount), ", must be seven numbers with a quaternion of norm 1");
}

// Size of the images as WIDTHxHEIGHT, or empty for the size of the sensor.
class SizeText final : public OptionText {
 public:
  explicit SizeText(SimulateOptions* options) : options_(options) {}
  std::string Get() const override {
    if (options_->width == 0) return "";
    return Concat(options_->width, "x", options_->height);
  }
  void Set(const std::string& text) override {
    options_->width = options_->height = 0;
    if (text.empty()) return;
    const std::string kRule = "WIDTHxHEIGHT with two numbers from 1 to 16384";
    int read = 0;
    const bool is_size =
        std::sscanf(text.c_str(), "%5dx%5d%n", &options_->width, &options_->height, &read) == 2 &&
        read == static_cast<int>(text.size());
    ThrowIf(!is_size || std::min(options_->width, options_->height) < 1 ||
                std::max(options_->width, options_->height) > 16384,
            kRule);
  }
  const std::type_info& type() const override { return typeid(SizeText); }
  void* field() override { return options_; }

 private:
  SimulateOptions* options_;
};

// Bounds of the translation between frames as MIN,MAX.
class StepText final : public OptionText {
 public:
  explicit StepText(PathOptions* path) : path_(path) {}
  std::string Get() const override {
    return OptionToText(std::vector<double>{path_->min_step_m, path_->max_step_m});
  }
  void Set(const std::string& text) override {
    const std::vector<double> steps = NumbersFromText(text, 2);
    ThrowIf(!(steps[0] > 0 && steps[1] >= steps[0] && std::isfinite(steps[1])),
            "MIN,MAX with positive MIN and MAX at least MIN");
    path_->min_step_m = steps[0];
    path_->max_step_m = steps[1];
  }
  const std::type_info& type() const override { return typeid(StepText); }
  void* field() override { return path_; }

 private:
  PathOptions* path_;
};

// Part I of N as I/N, or join/N to join all parts.
class PartText final : public OptionText {
 public:
  explicit PartText(SimulateOptions* options) : options_(options) {}
  std::string Get() const override {
    if (options_->part == 0 && !options_->join) return "";
    return Concat(options_->join ? "join" : std::to_string(options_->part), "/", options_->parts);
  }
  void Set(const std::string& text) override {
    options_->parts = 1;
    options_->part = 0;
    options_->join = false;
    if (text.empty()) return;
    const std::string kRule = "I/N with I from 1 to N, or join/N";
    const std::size_t slash = text.find('/');
    ThrowIf(slash == std::string::npos, kRule);
    options_->join = text.substr(0, slash) == "join";
    const std::string first = options_->join ? "1" : text.substr(0, slash);
    const std::vector<double> numbers = NumbersFromText(first + "," + text.substr(slash + 1), 2);
    ThrowIf(!(numbers[0] >= 1 && numbers[0] <= numbers[1] && numbers[1] <= 1e6 &&
              numbers[0] == std::floor(numbers[0]) && numbers[1] == std::floor(numbers[1])),
            kRule);
    options_->parts = static_cast<int>(numbers[1]);
    options_->part = options_->join ? 0 : static_cast<int>(numbers[0]);
  }
  const std::type_info& type() const override { return typeid(PartText); }
  void* field() override { return options_; }

 private:
  SimulateOptions* options_;
};

// The field of view stays. Sizes of 0 stay.
PinholeCamera Resized(PinholeCamera camera, int width, int height) {
  if (width > 0) {
    const double scale = static_cast<double>(width) / camera.width;
    camera.fx *= scale;
    camera.cx = (camera.cx + 0.5) * scale - 0.5;
    camera.width = width;
  }
  if (height > 0) {
    const double scale = static_cast<double>(height) / camera.height;
    camera.fy *= scale;
    camera.cy = (camera.cy + 0.5) * scale - 0.5;
    camera.height = height;
  }
  return camera;
}

}  // namespace

void SensorSettings::Visit(OptionVisitor& v) {
  v.Add(inverse_depth_offset, "inverse_depth_offset",
        "offset of 1 / z that camera.yaml does not contain; 0.00667 shortens 3 m by 2 %",
        Between(-0.1, 0.1), InUnit("1/m"), AsFlag());
  v.Add(inverse_depth_distortion, "inverse_depth_distortion",
        "c1,c2,c3,c4,c5: error of 1 / z that camera.yaml does not contain: c1 x + c2 y + c3 x^2 + "
        "c4 x y + c5 y^2 at the ray (x, y, 1)",
        InUnit("1/m"), AsFlag());
  v.Add(latency_s, "latency_s",
        "time from the middle of exposure and readout of the depth image to its timestamp",
        Between(-1, 1), InUnit("s"), AsFlag());
  v.Add(color_latency_s, "color_latency_s", "latency of colour in addition to the latency of depth",
        Between(-1, 1), InUnit("s"), AsFlag());
  v.Add(readout_s, "readout_s",
        "readout time of a rolling shutter, from the top row to the bottom row", Between(0, 1),
        InUnit("s"), AsFlag());
  v.AddPart(color, "color", "colour camera");
  v.Add(camera_yaml_focal_error, "camera_yaml_focal_error",
        "ex,ey: relative errors of the focal lengths in camera.yaml; 0.01: 1 % too long", AsFlag());
  v.Add(camera_yaml_center_error, "camera_yaml_center_error",
        "ex,ey: errors of the principal point in camera.yaml, to the right and down", InUnit("px"),
        AsFlag());
  v.Add(camera_yaml_times, "camera_yaml_times",
        "values that camera.yaml contains: latency_s, color_latency_s and readout_s, "
        "comma-separated; the others are 0 in camera.yaml",
        AsFlag());
  v.Add(imu_rate_hz, "imu_rate_hz", "rate of the inertial sensor", Between(1, 10000), InUnit("Hz"),
        AsFlag());
  v.Add(camera_from_imu, "camera_from_imu",
        "transform tx,ty,tz,qx,qy,qz,qw from the inertial sensor to the depth camera; empty: that "
        "of a phone",
        InUnit("m"), AsFlag());
  v.Add(imu_time_offset_s, "imu_time_offset_s",
        "time of the inertial sensor minus capture time of depth", Between(-1, 1), InUnit("s"),
        AsFlag());
  v.Add(camera_yaml_imu, "camera_yaml_imu",
        "camera.yaml contains transform, time offset and noise of the inertial sensor", AsFlag());
  v.Check([this] {
    CheckDepthError(inverse_depth_distortion);
    CheckTimes(camera_yaml_times);
    CheckMount(camera_from_imu);
  });
}

void SimulateOptions::Visit(OptionVisitor& v) {
  v.Group("simulation");
  v.Add(output, SharedOption("output", Required(), Everyday()));
  v.Add(scene, "scene", "scene; three_rooms needs 1500 frames to visit all rooms and return",
        OneOf(SceneNames()), AsFlag(), Everyday());
  PairText rooms(Option("rooms", "", Between(1, 2000)), &building.rooms,
                 Option("floors", "", Between(1, 100)), &building.floors);
  v.AddText(rooms, Option("rooms",
                          "ROOMS,FLOORS: total number of rooms, a multiple of FLOORS, and number "
                          "of floors of the scene building",
                          Everyday()));
  v.Add(frames, "frames", "number of frames", AtLeast(1), AsFlag(), Everyday());
  v.Add(seed, SharedOption("seed", AtLeast(0), Everyday()));
  v.Add(sensor, "sensor",
        "depth sensor: exact, Kinect v1, active stereo (RealSense D435), time of flight (Azure "
        "Kinect), or lidar of a phone with confidence images",
        OneOf(SensorNames()), AsFlag(), Everyday());
  SettingsText settings_text(&settings);
  v.AddText(settings_text,
            Option("sensor_settings",
                   "name=value;name=value: true values of the sensors and their errors in "
                   "camera.yaml; in quotes, since ; ends a command of the shell" +
                       SettingsHelp(TableOf(&settings)),
                   AsFlag()));
  v.Add(imu, "imu", "write an inertial sensor to imu.csv, and without errors to imu_exact.csv",
        AsFlag());
  SizeText size(this);
  v.AddText(size, Option("size",
                         "size of the images as WIDTHxHEIGHT; fx and fy scale with it, px, at most "
                         "16384; empty: 640x480, with --sensor=lidar 256x192",
                         AsFlag(), Everyday()));
  v.Add(downsample, SharedOption("downsample", Everyday()));
  v.Add(format, "format",
        "layout of the sequence; icl_nuim: numbered frames, fy < 0, poses mirrored by "
        "diag(1, -1, 1); surface.ply stays right-handed",
        OneOf({"tum", "icl_nuim"}), AsFlag(), Everyday());
  v.Add(surface_grid_m, "surface_grid_m", "distance between the points of surface.ply",
        AtLeast(0.001), AsFlag(), Everyday());
  v.Add(threads, SharedOption("threads", Everyday()));
  StepText step(&path);
  v.AddText(step,
            Option("step_m", "MIN,MAX: bounds of the translation between consecutive frames, m",
                   AsFlag()));
  PartText part_text(this);
  v.AddText(part_text,
            Option("part",
                   "I/N: render only part I of N, into the folder OUTPUT.I; join/N: join all parts "
                   "and delete their folders; the files are the same as without parts; empty: no "
                   "parts",
                   AsFlag()));
}

InverseDepthField DepthErrorOf(const SensorSettings& settings) {
  InverseDepthField error;
  error.coefficients[0] = settings.inverse_depth_offset;
  std::copy(settings.inverse_depth_distortion.begin(), settings.inverse_depth_distortion.end(),
            error.coefficients.begin() + 1);
  return error;
}

RgbdCamera TrueCameraOf(const SimulateOptions& options) {
  RgbdCamera camera;
  camera.depth = Resized(SimulatedSensor(options.sensor).camera(), options.width, options.height)
                     .Subsampled(options.downsample);
  camera.latency_s = options.settings.latency_s;
  camera.color_latency_s = options.settings.color_latency_s;
  camera.readout_s = options.settings.readout_s;
  return camera;
}

RgbdCamera CameraYamlOf(const SensorSettings& settings, RgbdCamera camera) {
  std::map<std::string, double*> unknown = {{"latency_s", &camera.latency_s},
                                            {"color_latency_s", &camera.color_latency_s},
                                            {"readout_s", &camera.readout_s}};
  for (const std::string& name : settings.camera_yaml_times) unknown.erase(name);
  for (const auto& [name, number] : unknown) *number = 0;
  const auto focal = settings.camera_yaml_focal_error.value_or(std::array<double, 2>());
  const auto center = settings.camera_yaml_center_error.value_or(std::array<double, 2>());
  camera.depth.fx *= 1 + focal[0];
  camera.depth.fy *= 1 + focal[1];
  camera.depth.cx += center[0];
  camera.depth.cy += center[1];
  camera.Validate("camera.yaml");
  return camera;
}

ImuSimulation ImuOf(const SimulateOptions& options) {
  ImuSimulation imu;
  imu.rate_hz = options.settings.imu_rate_hz;
  imu.seed = options.seed;
  const std::vector<double>& mount = options.settings.camera_from_imu;
  if (mount.empty()) {
    imu.calibration.camera_from_imu =
        Rigid3d(Eigen::Quaterniond(0, 1, -1, 0).normalized(), {0.02, -0.01, 0.005});
  } else {
    imu.calibration.camera_from_imu =
        Rigid3d(Eigen::Quaterniond(Eigen::Vector4d(mount.data() + 3)).normalized(),
                Eigen::Vector3d(mount.data()));
  }
  imu.calibration.time_offset_s = options.settings.imu_time_offset_s;
  imu.calibration.rotation_sigma_rad = imu.calibration.translation_sigma_m = 0.001;
  imu.calibration.time_offset_sigma_s = 0.001;
  return imu;
}

bool HasUnlistedTruth(const SensorSettings& s) {
  return s.latency_s != 0 || s.color_latency_s != 0 || s.readout_s != 0 || !s.color.ArePlain() ||
         s.camera_yaml_focal_error || s.camera_yaml_center_error;
}

}  // namespace surfit::tools
