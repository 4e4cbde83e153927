#pragma once

#include <string>
#include <tuple>

#include "surfit/geometry/pinhole_camera.h"
#include "surfit/geometry/rigid3.h"

namespace surfit {

class OptionVisitor;

// Noise of a structured-light or stereo depth sensor, constant in inverse depth. With baseline b,
// focal length f and disparity noise delta,
//   sigma_z = delta z^2 / (b f),  sigma_(1/z) = delta / (b f)
// (Khoshelham and Elberink 2012; Schoeps et al., BAD SLAM, 2019).
struct DepthNoise {
  // 1/m. Kinect v1: 0.1 px / (0.075 m * 525 px) = 0.0025. The default is 8 mm at 2 m.
  double inverse_depth_sigma = 0.002;

  // Standard deviation in m of a depth z in m.
  double SigmaZ(double z_m) const { return inverse_depth_sigma * z_m * z_m; }

  void Visit(OptionVisitor& visitor);

  // Throws InputError with the name `what`, the value and the constraint unless 0 < sigma < 1.
  void Validate(const std::string& what) const;
};

// Conversion of disparity images to depth. With the disparity d = (count - count_at_infinity) /
// counts_per_px in px, triangulation gives z = focal_px baseline_m / d:
//   1 / z = (count - count_at_infinity) / (counts_per_px focal_px baseline_m).
// Raw counts of a Kinect v1 decrease with the disparity. It has counts_per_px = -8,
// count_at_infinity of about 1090 and baseline_m = 0.075 (Khoshelham and Elberink 2012). focal_px
// is the focal length of the disparity computation. It can differ from fx of the camera.
struct Disparity {
  double focal_px = 0;
  double baseline_m = 0;  // 0: depth images are not disparities
  double counts_per_px = 1;
  double count_at_infinity = 0;

  bool IsGiven() const { return baseline_m != 0; }
  // Inverse depth of a count, 1/m. Zero or negative at or beyond infinity. Requires IsGiven(). Does
  // not detect missing values; FrameRectifier treats 0, 65535 and NaN as missing.
  double InverseDepth(double count) const {
    return (count - count_at_infinity) / (counts_per_px * focal_px * baseline_m);
  }
  // Throws InputError with the name `what`, the field, its value and the constraint, also unless
  // IsGiven().
  void Validate(const std::string& what) const;
};

// Prior of a calibration: standard deviations of the errors of the input values. 0: no prior. The
// defaults are for a Kinect v1. CameraPreset() has the values of other sensors. Calibration and
// refinement use all members except latency_s, color_translation_m and color_rotation_rad.
// surfit_convert estimates the colour camera, and uses color_translation_m and color_rotation_rad
// as well. latency_s is not used.
struct CalibrationPrior {
  double focal_relative_sigma = 0.01;    // of fx and fy, relative
  double aspect_relative_sigma = 0.001;  // of fx / fy, relative
  double center_px = 5;                  // of cx and cy
  double inverse_depth_sigma = 0.02;     // 1/m, per coefficient of InverseDepthField
  // Latencies and readout of RgbdCamera, s.
  double latency_s = 0.01;
  double color_latency_s = 0.02;
  double readout_s = 0.003;
  // RgbdCamera::color_from_depth, or the extrinsics that a driver used to register colour: m and
  // rad.
  double color_translation_m = 0.005;
  double color_rotation_rad = 0.01;

  void Visit(OptionVisitor& visitor);
  bool operator==(const CalibrationPrior& other) const {
    const auto values = [](const CalibrationPrior& p) {
      return std::tie(p.focal_relative_sigma, p.aspect_relative_sigma, p.center_px,
                      p.inverse_depth_sigma, p.latency_s, p.color_latency_s, p.readout_s,
                      p.color_translation_m, p.color_rotation_rad);
    };
    return values(*this) == values(other);
  }

  // Throws InputError with the name `what`, the field, its value and the constraint.
  void Validate(const std::string& what) const;
};

// Model of a depth image: projection, noise and readout.
struct DepthSensor {
  PinholeCamera camera;  // without distortion, which is not checked
  DepthNoise noise;
  double readout_s = 0;  // RgbdCamera::readout_s
  CalibrationPrior prior = {};

  // Throws InputError with the field, its value and the constraint. fy must be positive.
  void Validate() const;
};

// RGB-D sensor of a recording: a depth camera and a colour camera.
struct RgbdCamera {
  PinholeCamera depth;
  PinholeCamera color;
  // True: a colour pixel has the ray of the depth pixel at the same coordinates. `color` and
  // `color_from_depth` are then not used, but color_from_depth must be finite.
  bool color_is_registered = true;
  Rigid3d color_from_depth;
  double depth_units_per_metre = 5000;  // not used with `disparity`, but must be positive
  Disparity disparity = {};
  DepthNoise noise;
  double frames_per_second = 30;  // for sequences without timestamps
  // Depth latency in s: timestamp minus capture time. The capture time is the middle of exposure
  // and readout. 0: timestamps are capture times. Kinect v1 and Xtion: 0.02, which is half of the
  // readout time plus a few milliseconds for transfer.
  double latency_s = 0;
  // Additional latency of colour in s. Capture time of colour = timestamp - latency_s -
  // color_latency_s.
  double color_latency_s = 0;
  // Readout time of a rolling shutter in s, from the top row to the bottom row. 0: global shutter.
  // Kinect v1 and Xtion: 1/30 (Aptina MT9M001).
  double readout_s = 0;
  CalibrationPrior prior = {};

  // Throws InputError with the name `what`, the field, its value and the constraint.
  void Validate(const std::string& what) const;
};

// Sequences with a camera y axis that points up (fy < 0, for example ICL-NUIM) have left-handed
// camera and world frames. S = diag(1, -1, 1) mirrors both frames: a point x becomes S x. With
// |fy|, S x has the same pixel as x,
//   v = fy y/z + cy = |fy| (-y)/z + cy,
// so the images do not change. S is its own inverse.

// Pose S pose S between the mirrored frames. Its quaternion is (-x, y, -z, w).
inline Rigid3d Mirrored(const Rigid3d& pose) {
  const Eigen::Quaterniond& q = pose.rotation;
  const Eigen::Vector3d& t = pose.translation;
  return Rigid3d(Eigen::Quaterniond(q.w(), -q.x(), q.y(), -q.z()), {t.x(), -t.y(), t.z()});
}

// Mirrored camera: fy and the tangential coefficient p1 change their signs.
inline PinholeCamera Mirrored(PinholeCamera camera) {
  camera.fy = -camera.fy;
  camera.distortion[2] = -camera.distortion[2];
  return camera;
}

// Mirrors both cameras and color_from_depth. Other members do not change.
inline RgbdCamera Mirrored(RgbdCamera camera) {
  camera.depth = Mirrored(camera.depth);
  camera.color = Mirrored(camera.color);
  camera.color_from_depth = Mirrored(camera.color_from_depth);
  return camera;
}

}  // namespace surfit
