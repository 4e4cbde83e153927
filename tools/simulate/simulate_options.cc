#include "simulate/simulate_options.h"

#include <cmath>
#include <map>

#include "core/shared_options.h"
#include "simulate/simulated_sensor.h"
#include "surfit/core/error.h"
#include "surfit/simulation/scene.h"

namespace surfit::tools {
namespace {

// True values of the sensor, and their errors in camera.yaml.
void VisitSensor(OptionVisitor& v, SimulateOptions* o) {
  v.Group("sensor");
  v.Add(o->inverse_depth_offset, "inverse_depth_offset",
        "offset of 1 / z that camera.yaml does not contain; 0.00667 shortens 3 m by 2 %",
        Between(-0.1, 0.1), InUnit("1/m"), AsFlag());
  v.Add(o->inverse_depth_distortion, "inverse_depth_distortion",
        "c1,c2,c3,c4,c5: error of 1 / z that camera.yaml does not contain: c1 x + c2 y + c3 x^2 + "
        "c4 x y + c5 y^2 at the ray (x, y, 1)",
        InUnit("1/m"), AsFlag());
  v.Add(o->latency_s, "latency_s",
        "time from the middle of exposure and readout of the depth image to its timestamp",
        Between(-1, 1), InUnit("s"), AsFlag());
  v.Add(o->color_latency_s, "color_latency_s",
        "latency of colour in addition to the latency of depth", Between(-1, 1), InUnit("s"),
        AsFlag());
  v.Add(o->readout_s, "readout_s",
        "readout time of a rolling shutter, from the top row to the bottom row", Between(0, 1),
        InUnit("s"), AsFlag());
  v.AddPart(o->color, "color", "colour camera");
  v.Add(o->camera_yaml_focal_error, "camera_yaml_focal_error",
        "ex,ey: relative errors of the focal lengths in camera.yaml; 0.01: 1 % too long", AsFlag());
  v.Add(o->camera_yaml_center_error, "camera_yaml_center_error",
        "ex,ey: errors of the principal point in camera.yaml, to the right and down", InUnit("px"),
        AsFlag());
  v.Add(o->camera_yaml_times, "camera_yaml_times",
        "values that camera.yaml contains: latency_s, color_latency_s and readout_s, "
        "comma-separated; the others are 0 in camera.yaml",
        AsFlag());
}

void VisitImu(OptionVisitor& v, SimulateOptions* o) {
  v.Group("inertial sensor");
  v.Add(o->write_imu, "write_imu",
        "write an inertial sensor to imu.csv, and without errors to imu_exact.csv", AsFlag());
  v.Add(o->imu_rate_hz, "imu_rate_hz", "rate of the inertial sensor", Between(1, 10000),
        InUnit("Hz"), AsFlag());
  v.Add(o->camera_from_imu, "camera_from_imu",
        "transform tx,ty,tz,qx,qy,qz,qw from the inertial sensor to the depth camera; empty: that "
        "of a phone",
        InUnit("m"), AsFlag());
  v.Add(o->imu_time_offset_s, "imu_time_offset_s",
        "time of the inertial sensor minus capture time of depth", Between(-1, 1), AsFlag());
  v.Add(o->camera_yaml_imu, "camera_yaml_imu",
        "camera.yaml contains transform, time offset and noise of the inertial sensor", AsFlag());
}

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

void SimulateOptions::Visit(OptionVisitor& v) {
  v.Group("simulation");
  v.Add(output, SharedOption("output", Required(), Everyday()));
  v.Add(scene, "scene", "scene; three_rooms needs 1500 frames to visit all rooms and return",
        OneOf(SceneNames()), AsFlag(), Everyday());
  v.AddPart(building, "building", "size of the building");
  v.Add(frames, "frames", "number of frames", AtLeast(1), AsFlag(), Everyday());
  v.Add(seed, SharedOption("seed", AtLeast(0), Everyday()));
  v.Add(sensor, "sensor",
        "depth sensor: exact, Kinect v1, active stereo (RealSense D435), time of flight (Azure "
        "Kinect), or lidar of a phone with confidence images",
        OneOf(SensorNames()), AsFlag(), Everyday());
  v.Add(width, "width", "width of the images; fx and cx scale with it", InUnit("px"),
        ZeroIs("640, with --sensor=lidar 256"), Between(0, 16384), AsFlag(), Everyday());
  v.Add(height, "height", "height of the images; fy and cy scale with it", InUnit("px"),
        ZeroIs("480, with --sensor=lidar 192"), Between(0, 16384), AsFlag(), Everyday());
  v.Add(downsample, SharedOption("downsample", Everyday()));
  v.Add(image_y_up, "image_y_up",
        "write the convention of ICL-NUIM: numbered frames, fy < 0, poses mirrored by "
        "diag(1, -1, 1); surface.ply stays right-handed",
        AsFlag(), Everyday());
  v.Add(surface_grid_m, "surface_grid_m", "distance between the points of surface.ply",
        AtLeast(0.001), AsFlag(), Everyday());
  v.Add(threads, SharedOption("threads", Everyday()));
  v.AddPart(path, "path", "camera path");
  VisitSensor(v, this);
  VisitImu(v, this);
  v.Group("parts");
  PartText part_text(this);
  v.AddText(part_text,
            Option("part",
                   "I/N: render only part I of N, into the folder OUTPUT.I; join/N: join all parts "
                   "and delete their folders; the files are the same as without parts; empty: no "
                   "parts",
                   AsFlag()));
}

InverseDepthField DepthErrorOf(const SimulateOptions& options) {
  constexpr double kLargest = 0.1;
  InverseDepthField error;
  const std::vector<double>& varying = options.inverse_depth_distortion;
  if (!varying.empty() && varying.size() + 1 != InverseDepthField::kSize)
    throw InputError(
        Concat("--inverse_depth_distortion is ", OptionToText(varying), ", must be five numbers"));
  std::copy(varying.begin(), varying.end(), error.coefficients.begin() + 1);
  error.coefficients[0] = options.inverse_depth_offset;
  for (const double coefficient : varying) {
    if (!(std::abs(coefficient) <= kLargest))
      throw InputError(Concat("--inverse_depth_distortion contains ", coefficient,
                              ", must be from ", -kLargest, " to ", kLargest));
  }
  return error;
}

RgbdCamera TrueCameraOf(const SimulateOptions& options) {
  RgbdCamera camera;
  camera.depth = Resized(SimulatedSensor(options.sensor).camera(), options.width, options.height)
                     .Subsampled(options.downsample);
  camera.latency_s = options.latency_s;
  camera.color_latency_s = options.color_latency_s;
  camera.readout_s = options.readout_s;
  return camera;
}

RgbdCamera CameraYamlOf(const SimulateOptions& options, RgbdCamera camera) {
  std::map<std::string, double*> unknown = {{"latency_s", &camera.latency_s},
                                            {"color_latency_s", &camera.color_latency_s},
                                            {"readout_s", &camera.readout_s}};
  for (const std::string& name : options.camera_yaml_times) {
    if (unknown.erase(name) == 0) {
      throw InputError(Concat("--camera_yaml_times contains '", name,
                              "', must be latency_s, color_latency_s or readout_s, each once"));
    }
  }
  for (const auto& [name, number] : unknown) *number = 0;
  const auto focal = options.camera_yaml_focal_error.value_or(std::array<double, 2>());
  const auto center = options.camera_yaml_center_error.value_or(std::array<double, 2>());
  camera.depth.fx *= 1 + focal[0];
  camera.depth.fy *= 1 + focal[1];
  camera.depth.cx += center[0];
  camera.depth.cy += center[1];
  camera.Validate("camera.yaml");
  return camera;
}

ImuSimulation ImuOf(const SimulateOptions& options) {
  ImuSimulation imu;
  imu.rate_hz = options.imu_rate_hz;
  imu.seed = options.seed;
  const std::vector<double>& mount = options.camera_from_imu;
  if (mount.empty()) {
    imu.calibration.camera_from_imu =
        Rigid3d(Eigen::Quaterniond(0, 1, -1, 0).normalized(), {0.02, -0.01, 0.005});
  } else {
    const double norm = mount.size() == 7 ? Eigen::Vector4d(mount.data() + 3).norm() : 0;
    if (!(std::abs(norm - 1) < 0.01)) {
      throw InputError(Concat("--camera_from_imu is ", OptionToText(mount),
                              ", must be seven numbers with a quaternion of norm 1"));
    }
    imu.calibration.camera_from_imu =
        Rigid3d(Eigen::Quaterniond(Eigen::Vector4d(mount.data() + 3)).normalized(),
                Eigen::Vector3d(mount.data()));
  }
  imu.calibration.time_offset_s = options.imu_time_offset_s;
  imu.calibration.rotation_sigma_rad = imu.calibration.translation_sigma_m = 0.001;
  imu.calibration.time_offset_sigma_s = 0.001;
  return imu;
}

bool HasUnlistedTruth(const SimulateOptions& o) {
  return o.latency_s != 0 || o.color_latency_s != 0 || o.readout_s != 0 || !o.color.ArePlain() ||
         o.camera_yaml_focal_error || o.camera_yaml_center_error;
}

}  // namespace surfit::tools
