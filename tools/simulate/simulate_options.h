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

// What to simulate.
struct SimulateOptions {
  std::string output;
  std::string scene = "room";
  BuildingOptions building;
  int frames = 200;
  PathOptions path;
  int seed = 4;
  std::string sensor = "kinect";
  double inverse_depth_offset = 0;
  std::vector<double> inverse_depth_distortion;
  double latency_s = 0;
  double color_latency_s = 0;
  double readout_s = 0;
  ColorOptions color;
  std::optional<std::array<double, 2>> given_focal_error, given_center_error;
  std::vector<std::string> known;
  int downsample = 1;
  bool image_y_up = false;
  double surface_grid_m = 0.005;
  int threads = 2;
  int parts = 1;  // that the frames are cut into
  int part = 0;   // to be rendered, from 1 on; 0: all
  bool join = false;

  void Visit(OptionVisitor& visitor);
};

// What the sensor adds to each inverse depth. Throws InputError naming the flag, as do the others.
InverseDepthField DepthErrorOf(const SimulateOptions& options);

// The camera as it is in truth.
RgbdCamera TrueCameraOf(const SimulateOptions& options);

// As its user is told.
RgbdCamera GivenCameraOf(const SimulateOptions& options, RgbdCamera camera);

// Whether camera.yaml and the images themselves may not tell all.
bool HasHiddenTruth(const SimulateOptions& options);

}  // namespace surfit::tools
