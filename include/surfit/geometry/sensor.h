#pragma once

#include <string>

#include "surfit/geometry/pinhole_camera.h"
#include "surfit/geometry/rigid3.h"

namespace surfit {

class OptionVisitor;

// Noise of a structured-light or stereo depth sensor, constant in inverse depth: with baseline b,
// focal length f and disparity noise delta, sigma_z = delta z^2 / (b f), that is
// sigma_(1/z) = delta / (b f) (Khoshelham and Elberink 2012; Schoeps et al., BAD SLAM, 2019).
struct DepthNoise {
  // 1/m. Kinect v1: 0.1 px / (0.075 m * 525 px) = 0.0025; 8 mm at 2 m.
  double inverse_depth_sigma = 0.002;

  // Standard deviation of a depth z, in metres.
  double SigmaZ(double z_m) const { return inverse_depth_sigma * z_m * z_m; }

  void Visit(OptionVisitor& visitor);

  // Of images. Throws InputError naming `what`, the field, its value and the constraint.
  void Validate(const std::string& what) const;
};

// How depth images of disparities become depth. With the disparity d = (count - count_at_infinity)
// / counts_per_px in px, stereo triangulation has z = focal_px baseline_m / d, so that
//   1 / z = (count - count_at_infinity) / (counts_per_px focal_px baseline_m).
// Kinect v1's raw counts fall with the disparity: counts_per_px = -8, count_at_infinity about 1090
// (Khoshelham and Elberink 2012), baseline_m = 0.075. The focal length is that which the
// disparities were made with, whatever becomes of the camera's.
struct Disparity {
  double focal_px = 0;
  double baseline_m = 0;  // 0: depth images are no disparities
  double counts_per_px = 1;
  double count_at_infinity = 0;

  bool IsGiven() const { return baseline_m != 0; }
  // 1/m; not positive where nothing is told, or beyond infinity.
  double InverseDepth(double count) const {
    return (count - count_at_infinity) / (counts_per_px * focal_px * baseline_m);
  }
  // Throws InputError naming `what`, the field, its value and the constraint.
  void Validate(const std::string& what) const;
};

// What is known of a calibration as a user is given it: standard deviations of its errors, about
// which it is right; 0 = nothing is known. Factory calibrations and presets of a series are off by
// about a percent; pixels are square to a thousandth; a structured-light sensor's depth is off by
// about one step of disparity, which is 1 px / (0.075 m * 580 px) for a Kinect v1 (Khoshelham and
// Elberink 2012). The defaults are a Kinect v1's; other sensors' stand with CameraPreset().
struct CalibrationPrior {
  double focal_share = 0.01;          // of fx and of fy
  double aspect_share = 0.001;        // of fx / fy
  double center_px = 5;               // of cx and of cy
  double inverse_depth_sigma = 0.02;  // 1/m: of each coefficient of InverseDepthField
  // Of the times of RgbdCamera.
  double latency_s = 0.01;
  double color_latency_s = 0.02;
  double readout_s = 0.003;
  // Of color_from_depth, or of what a driver registers colour to depth with.
  double color_translation_m = 0.005;
  double color_rotation_rad = 0.01;

  void Visit(OptionVisitor& visitor);

  // Throws InputError naming `what`, the field, its value and the constraint.
  void Validate(const std::string& what) const;
};

// What the pixels of a depth image are: how they see, and how well. Given once, where a program
// begins; every stage takes it from there, or from the FrameLevel that it works on.
struct DepthSensor {
  PinholeCamera camera;  // undistorted
  DepthNoise noise;
  double readout_s = 0;  // of a rolling shutter: RgbdCamera
  CalibrationPrior prior = {};

  // Throws InputError naming the field, its value and the constraint.
  void Validate() const;
};

// The whole sensor as a recording has it: a depth camera with a colour camera beside it.
struct RgbdCamera {
  PinholeCamera depth;
  PinholeCamera color;
  // Colour pixels see the same rays as depth pixels; color and color_from_depth are then unused.
  bool color_is_registered = true;
  Rigid3d color_from_depth;
  double depth_units_per_metre = 5000;  // unused where disparity is given
  Disparity disparity = {};
  DepthNoise noise;
  double frames_per_second = 30;
  // How long before its stamp the middle of a depth frame's exposure and readout lies. Kinect v1
  // and Xtion: 0.02. They send a frame while they read it out, in 1/30 s, and the driver stamps it
  // when it has come (openni_camera: the time of its callback). So the middle lies 1/60 s before
  // the end, and transfer and computation add some milliseconds. 0 where stamps are of the moment
  // itself.
  double latency_s = 0;
  // How much earlier than colour's stamp less latency_s the middle of its exposure and readout
  // really lies: the colour camera's own delay, beyond depth's.
  double color_latency_s = 0;
  // From the first row that a rolling shutter reads, at the top, to the last. Kinect v1 and Xtion:
  // 1/30 s, as their sensor (Aptina MT9M001) reads rows all the time between two frames. 0: all
  // rows are of one moment.
  double readout_s = 0;
  CalibrationPrior prior = {};

  // Throws InputError naming `what`, the field, its value and the constraint.
  void Validate(const std::string& what) const;
};

// Sequences whose image y axis points up (fy < 0; ICL-NUIM) have left-handed camera and world
// frames. S = diag(1, -1, 1) mirrors both: a point x becomes S x, and with |fy| it keeps its pixel,
//   v = fy y/z + cy = |fy| (-y)/z + cy,
// so that images stay as they are. Mirroring twice gives the original back.

// S pose S: the same motion between mirrored frames. Its rotation matrix S R S turns by R's angle
// about -S axis (an axis is a pseudovector), hence the quaternion (-x, y, -z, w).
inline Rigid3d Mirrored(const Rigid3d& pose) {
  const Eigen::Quaterniond& q = pose.rotation;
  const Eigen::Vector3d& t = pose.translation;
  return Rigid3d(Eigen::Quaterniond(q.w(), -q.x(), q.y(), -q.z()), {t.x(), -t.y(), t.z()});
}

// The same lens before mirrored points: fy and the tangential coefficient p1 change sign.
inline PinholeCamera Mirrored(PinholeCamera camera) {
  camera.fy = -camera.fy;
  camera.distortion[2] = -camera.distortion[2];
  return camera;
}

inline RgbdCamera Mirrored(RgbdCamera camera) {
  camera.depth = Mirrored(camera.depth);
  camera.color = Mirrored(camera.color);
  camera.color_from_depth = Mirrored(camera.color_from_depth);
  return camera;
}

}  // namespace surfit
