
#include "surfit/core/error.h"
#include "surfit/io/camera_files.h"

namespace surfit {
namespace {

using Distortion = std::array<double, 5>;

constexpr double kKinectReadout_s = 1. / 30;  // readout time, see RgbdCamera::readout_s

PinholeCamera Vga(double fx, double fy, double cx, double cy, const Distortion& distortion = {}) {
  return {640, 480, fx, fy, cx, cy, distortion};
}

RgbdCamera Registered(const PinholeCamera& camera, double depth_units_per_metre) {
  RgbdCamera rgbd;
  rgbd.depth = camera;
  rgbd.depth_units_per_metre = depth_units_per_metre;
  return rgbd;
}

// Kinect v1 (fr1, fr2) or Xtion (fr3), with timestamps at arrival. A latency of 20 ms gives the
// smallest trajectory errors for the freiburg1 sequences.
RgbdCamera Tum(const PinholeCamera& camera) {
  RgbdCamera rgbd = Registered(camera, 5000);
  rgbd.latency_s = 0.02;
  rgbd.readout_s = kKinectReadout_s;
  return rgbd;
}

// Kinect v1 of the 7-Scenes data set. The colour intrinsics were estimated from the scene
// redkitchen. The extrinsics are not published.
RgbdCamera SevenScenes() {
  RgbdCamera rgbd = Registered(Vga(585, 585, 320, 240), 1000);
  rgbd.readout_s = kKinectReadout_s;
  rgbd.color = Vga(525, 525, 312, 240);
  rgbd.color_is_registered = false;
  return rgbd;
}

// Sensor models without individual calibration. The priors are standard deviations between devices
// of one model. docs/understand.md lists the source of each number. Numbers without a source are
// marked as assumed.

// PrimeSense sensor, registered by OpenNI. The three calibrated sensors of TUM differ from the
// driver default. Focal lengths differ from 525 px by -1.5, -0.8 and 2.3 %. Aspect ratios differ by
// 0.4 %, and principal points by 9 px (RMS). Depth errors are a few centimetres (Boehm 2014, 18
// sensors). This is about one disparity step.
RgbdCamera PrimeSense() {
  RgbdCamera rgbd = Registered(Vga(525, 525, 319.5, 239.5), 1000);
  rgbd.latency_s = 0.02;
  rgbd.readout_s = kKinectReadout_s;
  rgbd.prior.focal_relative_sigma = 0.017;
  rgbd.prior.aspect_relative_sigma = 0.004;
  rgbd.prior.center_px = 9;
  return rgbd;
}

// Sensor with a global shutter and timestamps at the exposure. Assumed: the timestamp error is at
// most 10 ms.
RgbdCamera GlobalShutter(const PinholeCamera& camera, double inverse_depth_sigma,
                         const CalibrationPrior& prior) {
  RgbdCamera rgbd = Registered(camera, 1000);
  rgbd.noise.inverse_depth_sigma = inverse_depth_sigma;
  rgbd.prior = prior;
  rgbd.prior.latency_s = 0.01;
  rgbd.prior.readout_s = 0.0005;
  return rgbd;
}

// Intrinsics of one device, published by libfreenect2 users. The principal point of another device
// differs by 2 px and 5 px. The image centre differs by 1 px and 6 px. Assumed: depth noise of 4 mm
// and depth error of 20 mm at 2 m, and the prior of the focal length.
RgbdCamera KinectV2() {
  const PinholeCamera camera = {
      512, 424, 365.456, 365.456, 254.878, 205.395, {0.0905474, -0.26819, 0, 0, 0.0950862}};
  return GlobalShutter(camera, 0.001, {0.005, 0.001, 4, 0.005});
}

// Factory calibration of the narrow, unbinned mode (Azure Kinect Sensor SDK, issue 1617). Images
// must be undistorted: the distortion model has more coefficients than the five of OpenCV. The
// depth error is 11 mm plus 0.1 % (data sheet; Toelgyessy et al., Sensors 2021, up to 3.5 m): 13 mm
// at 2 m. Assumed: depth noise of 4 mm at 2 m, and the priors.
RgbdCamera AzureKinect() {
  return GlobalShutter({640, 576, 503.8, 503.7, 321.5, 329.0, {}}, 0.001, {0.005, 0.001, 5, 0.003});
}

// Stereo camera at 848 x 480 with a disparity noise of 0.1 px (as in BAD SLAM). `share`: relative
// depth error at `range_m`. Factory calibrations of three D435 have focal lengths of 422.7, 424.2
// and 426.8 px. The principal point of a D455 is 8 px and 10 px from the image centre.
RgbdCamera RealSense(double focal_px, double baseline_m, double share, double range_m) {
  return GlobalShutter({848, 480, focal_px, focal_px, 423.5, 239.5, {}},
                       0.1 / (focal_px * baseline_m), {0.005, 0.001, 6, share / range_m});
}

// Rolling shutter with a readout time of half a frame period (assumed).
RgbdCamera RealSenseD415() {
  RgbdCamera rgbd = RealSense(665.5, 0.055, 0.02, 2);  // horizontal field of view of 65 degrees
  rgbd.readout_s = 1. / 60;
  rgbd.prior.readout_s = 1. / 120;
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
      {"kinect_v1", PrimeSense()},
      {"xtion", PrimeSense()},
      {"kinect_v2", KinectV2()},
      {"azure_kinect", AzureKinect()},
      {"realsense_d415", RealSenseD415()},
      {"realsense_d435", RealSense(424, 0.05, 0.02, 2)},
      {"realsense_d455", RealSense(424, 0.095, 0.02, 4)},
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
  throw InputError("camera is '", name, "', must be one of ", known);
}

std::vector<std::string> CameraPresetNames() {
  std::vector<std::string> names;
  for (const Preset& preset : Presets()) names.push_back(preset.name);
  return names;
}

}  // namespace surfit
