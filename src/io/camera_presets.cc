
#include "surfit/core/error.h"
#include "surfit/io/camera_files.h"

namespace surfit {
namespace {

using Distortion = std::array<double, 5>;

constexpr double kKinectReadout_s = 1. / 30;  // RgbdCamera::readout_s

PinholeCamera Vga(double fx, double fy, double cx, double cy, const Distortion& distortion = {}) {
  return {640, 480, fx, fy, cx, cy, distortion};
}

RgbdCamera Registered(const PinholeCamera& camera, double depth_units_per_metre) {
  RgbdCamera rgbd;
  rgbd.depth = camera;
  rgbd.depth_units_per_metre = depth_units_per_metre;
  return rgbd;
}

// A Kinect v1 (fr1, fr2) or an Xtion (fr3), stamped on arrival: RgbdCamera::latency_s. Against the
// motion capture of freiburg1's sequences, trajectories are off least with 20 ms.
RgbdCamera Tum(const PinholeCamera& camera) {
  RgbdCamera rgbd = Registered(camera, 5000);
  rgbd.latency_s = 0.02;
  rgbd.readout_s = kKinectReadout_s;
  return rgbd;
}

// The colour camera's figures are measured on the red kitchen; its pose is not published.
RgbdCamera SevenScenes() {
  RgbdCamera rgbd = Registered(Vga(585, 585, 320, 240), 1000);
  rgbd.readout_s = kKinectReadout_s;
  rgbd.color = Vga(525, 525, 312, 240);
  rgbd.color_is_registered = false;
  return rgbd;
}

struct Preset {
  std::string name;
  RgbdCamera camera;
};

const std::vector<Preset>& Presets() {
  static const auto* const presets = new std::vector<Preset>{
      {"tum_fr1",
       Tum(Vga(517.3, 516.5, 318.6, 255.3, Distortion{.2624, -.9531, -.0054, .0026, 1.1633}))},
      {"tum_fr2",
       Tum(Vga(520.9, 521.0, 325.1, 249.7, Distortion{.2312, -.7849, -.0033, -.0001, .9172}))},
      {"tum_fr3", Tum(Vga(535.4, 539.2, 320.1, 247.6))},
      {"icl_nuim", Registered(Vga(481.2, -480, 319.5, 239.5), 5000)},
      {"seven_scenes", SevenScenes()},
      {"redwood", Registered(Vga(525, 525, 319.5, 239.5), 1000)},
      {"replica", Registered({1200, 680, 600, 600, 599.5, 339.5, {}}, 6553.5)},
      {"klg", Registered(Vga(528, 528, 320, 240), 1000)},
  };
  return *presets;
}

}  // namespace

RgbdCamera CameraPreset(const std::string& name) {
  std::string known;
  for (const Preset& preset : Presets()) {
    if (preset.name == name) return preset.camera;
    known += (known.empty() ? "" : ", ") + preset.name;
  }
  throw InputError(Concat("camera is '", name, "', must be one of ", known));
}

std::vector<std::string> CameraPresetNames() {
  std::vector<std::string> names;
  for (const Preset& preset : Presets()) names.push_back(preset.name);
  return names;
}

}  // namespace surfit
