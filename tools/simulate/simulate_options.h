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

struct SimulateOptions {
  std::string output;
  std::string scene = "room";
  BuildingOptions building;
  int frames = 200;
  PathOptions path;
  int seed = 4;
  std::string sensor = "kinect";
  int width = 0, height = 0;  // px; 0: size of the sensor
  double inverse_depth_offset = 0;
  std::vector<double> inverse_depth_distortion;
  double latency_s = 0;
  double color_latency_s = 0;
  double readout_s = 0;
  ColorOptions color;
  std::optional<std::array<double, 2>> camera_yaml_focal_error, camera_yaml_center_error;
  std::vector<std::string> known;
  int downsample = 1;
  bool image_y_up = false;
  double surface_grid_m = 0.005;
  int threads = 2;
  int parts = 1;
  int part = 0;  // part to render, starting at 1; 0: all
  bool join = false;

  void Visit(OptionVisitor& visitor);
};

// Error of the inverse depth. All functions throw InputError with the name of the flag.
InverseDepthField DepthErrorOf(const SimulateOptions& options);

RgbdCamera TrueCameraOf(const SimulateOptions& options);

// Camera in camera.yaml.
RgbdCamera CameraYamlOf(const SimulateOptions& options, RgbdCamera camera);

// True if camera.yaml and the images may not contain all true values.
bool HasUnlistedTruth(const SimulateOptions& options);

}  // namespace surfit::tools
