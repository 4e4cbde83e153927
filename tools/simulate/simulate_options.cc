#include "simulate/simulate_options.h"

#include <cmath>
#include <map>

#include "core/shared_options.h"
#include "surfit/core/error.h"
#include "surfit/simulation/scene.h"

namespace surfit::tools {
namespace {

// What a camera does, and what its user is told of it.
void VisitSensor(OptionVisitor& v, SimulateOptions* o) {
  v.Group("sensor");
  v.Add(o->inverse_depth_offset, "inverse_depth_offset",
        "what a sensor out of calibration adds to each 1 / z: 0.00667 makes 3 m too near by 2 %; "
        "camera.yaml does not tell",
        Between(-0.1, 0.1), InUnit("1/m"), AsFlag());
  v.Add(o->inverse_depth_distortion, "inverse_depth_distortion",
        "c1,c2,c3,c4,c5: what it adds besides, c1 x + c2 y + c3 x^2 + c4 x y + c5 y^2 at the ray "
        "(x, y, 1); camera.yaml does not tell",
        InUnit("1/m"), AsFlag());
  v.Add(o->latency_s, SharedOption("latency_s"));
  v.Add(o->color_latency_s, SharedOption("color_latency_s"));
  v.Add(o->readout_s, SharedOption("readout_s"));
  v.AddPart(o->color, "color", "how colours are taken");
  v.Add(o->given_focal_error, "given_focal_error",
        "ex,ey: camera.yaml tells a focal length that is too long by such shares: 0.01 is 1 %",
        AsFlag());
  v.Add(o->given_center_error, "given_center_error",
        "ex,ey: camera.yaml tells a principal point that is too far right and down by so much",
        InUnit("px"), AsFlag());
  v.Add(o->known, "known",
        "which of latency_s, color_latency_s and readout_s camera.yaml tells, with commas between "
        "them; empty: none, as if they were 0",
        AsFlag());
}

}  // namespace

void SimulateOptions::Visit(OptionVisitor& v) {
  v.Group("simulation");
  v.Add(output, SharedOption("output", Required(), Everyday()));
  v.Add(scene, "scene", "scene; three_rooms: 1500 frames lead through them and back",
        OneOf(SceneNames()), AsFlag(), Everyday());
  v.AddPart(building, "building", "its size");
  v.Add(frames, "frames", "number of frames", AtLeast(1), AsFlag(), Everyday());
  v.Add(seed, SharedOption("seed", AtLeast(0), Everyday()));
  v.Add(sensor, "sensor", "exact depth, or the noise model of a Kinect v1",
        OneOf({"ideal", "kinect"}), AsFlag(), Everyday());
  v.Add(downsample, SharedOption("downsample", Everyday()));
  v.Add(image_y_up, "image_y_up",
        "write the convention of ICL-NUIM: numbered frames, fy < 0, the poses those of the scene "
        "mirrored by diag(1, -1, 1); surface.ply is right-handed all the same",
        AsFlag(), Everyday());
  v.Add(surface_grid_m, "surface_grid_m", "distance between the points of surface.ply",
        AtLeast(0.001), AsFlag(), Everyday());
  v.Add(threads, SharedOption("threads", Everyday()));
  v.AddPart(path, "path", "how the camera moves");
  VisitSensor(v, this);
  v.Group("parts");
  v.Add(parts, "parts", "parts of about as many frames each, to be rendered apart", AtLeast(1),
        AsFlag());
  v.Add(part, "part", "render this part alone, into a folder of its own, OUTPUT.part",
        ZeroIs("all of them"), AtLeast(0), AsFlag());
  v.Add(join, "join",
        "put all parts together, which are then gone: files are the same as of a simulation in one",
        AsFlag());
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
      throw InputError(Concat("--inverse_depth_distortion has ", coefficient, ", must be from ",
                              -kLargest, " to ", kLargest));
  }
  return error;
}

RgbdCamera TrueCameraOf(const SimulateOptions& options) {
  RgbdCamera camera;
  camera.depth.width = 640;
  camera.depth.height = 480;
  camera.depth.fx = camera.depth.fy = 525;
  camera.depth.cx = 319.5;
  camera.depth.cy = 239.5;
  camera.depth = camera.depth.Subsampled(options.downsample);
  camera.latency_s = options.latency_s;
  camera.color_latency_s = options.color_latency_s;
  camera.readout_s = options.readout_s;
  return camera;
}

RgbdCamera GivenCameraOf(const SimulateOptions& options, RgbdCamera camera) {
  std::map<std::string, double*> unknown = {{"latency_s", &camera.latency_s},
                                            {"color_latency_s", &camera.color_latency_s},
                                            {"readout_s", &camera.readout_s}};
  for (const std::string& name : options.known) {
    if (unknown.erase(name) == 0) {
      throw InputError(Concat("--known has '", name,
                              "', must be latency_s, color_latency_s or readout_s, each once"));
    }
  }
  for (const auto& [name, number] : unknown) *number = 0;
  const auto focal = options.given_focal_error.value_or(std::array<double, 2>());
  const auto center = options.given_center_error.value_or(std::array<double, 2>());
  camera.depth.fx *= 1 + focal[0];
  camera.depth.fy *= 1 + focal[1];
  camera.depth.cx += center[0];
  camera.depth.cy += center[1];
  camera.Validate("camera.yaml");
  return camera;
}

bool HasHiddenTruth(const SimulateOptions& o) {
  return o.latency_s != 0 || o.color_latency_s != 0 || o.readout_s != 0 || !o.color.ArePlain() ||
         o.given_focal_error || o.given_center_error;
}

}  // namespace surfit::tools
