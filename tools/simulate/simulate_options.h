#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "surfit/core/options.h"
#include "surfit/geometry/inverse_depth_field.h"
#include "surfit/geometry/sensor.h"
#include "surfit/simulation/camera_path.h"
#include "surfit/simulation/render.h"
#include "surfit/simulation/scene.h"

namespace surfit::tools {

// True values of the simulated sensors, and their errors in camera.yaml. These are the settings of
// one flag, with units, bounds and meanings in Visit().
struct SensorSettings {
  double inverse_depth_offset = 0;
  std::vector<double> inverse_depth_distortion;
  double latency_s = 0;
  double color_latency_s = 0;
  double readout_s = 0;
  ColorOptions color;
  // Errors of camera.yaml, as (x, y): relative errors of fx and fy, and errors of cx and cy in px.
  std::optional<std::array<double, 2>> camera_yaml_focal_error, camera_yaml_center_error;
  // Times that camera.yaml contains: latency_s, color_latency_s, readout_s. Other times are 0
  // there.
  std::vector<std::string> camera_yaml_times;
  double imu_rate_hz = 200;
  // True values of the inertial sensor. camera_from_imu: tx, ty, tz [m], qx, qy, qz, qw; empty: a
  // phone.
  std::vector<double> camera_from_imu;
  double imu_time_offset_s = 0;
  bool camera_yaml_imu = false;  // camera.yaml contains these true values

  void Visit(OptionVisitor& visitor);
};

// Options of surfit_simulate. Visit() has units, bounds and meanings as help texts.
struct SimulateOptions {
  std::string output;
  std::string scene = "room";
  BuildingOptions building;
  int frames = 200;
  PathOptions path;
  int seed = 4;
  std::string sensor = "kinect";
  SensorSettings settings;
  bool imu = false;           // writes imu.csv and imu_exact.csv; requires the format tum
  int width = 0, height = 0;  // px; 0: size of the sensor
  int downsample = 1;
  std::string format = "tum";  // icl_nuim: SequenceLayout::kIclNuim; requires latency_s = 0
  double surface_grid_m = 0.005;
  int threads = 2;
  int parts = 1;      // number of parts that are rendered separately
  int part = 0;       // part to render, starting at 1; 0: all
  bool join = false;  // join the parts and delete their folders; not with `part`

  void Visit(OptionVisitor& visitor);
};

// Error of the inverse depth, added to 1/z of the images. The settings must be valid.
InverseDepthField DepthErrorOf(const SensorSettings& settings);

// True camera: that of the sensor, resized to `width` and `height`, then subsampled, with the true
// latencies and readout. Throws InputError for an unknown sensor.
RgbdCamera TrueCameraOf(const SimulateOptions& options);

// Camera in camera.yaml: `camera` with the errors of the settings. Times that `camera_yaml_times`
// does not list are 0. Throws InputError for an invalid camera. The settings must be valid.
RgbdCamera CameraYamlOf(const SensorSettings& settings, RgbdCamera camera);

// True inertial sensor, with errors. The settings must be valid.
ImuSimulation ImuOf(const SimulateOptions& options);

// True if camera.yaml and the images may not contain all true values: times, options of colour, or
// errors of camera.yaml. Errors of the depth alone are not included.
bool HasUnlistedTruth(const SensorSettings& settings);

}  // namespace surfit::tools
