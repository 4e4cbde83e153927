#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "surfit/geometry/inertial.h"

namespace surfit {

// Rotation of the camera between two poses.
struct CameraTurn {
  double begin_s = 0, end_s = 0;  // capture times
  Eigen::Quaterniond begin_from_end = Eigen::Quaterniond::Identity();
};

// Integrated rates of a gyroscope, for fast rotations between any two times.
class GyroIntegral {
 public:
  GyroIntegral() = default;
  // Keeps the pointer. The samples must be ascending.
  explicit GyroIntegral(const std::vector<ImuSample>* samples);

  // True if both times are within the samples.
  bool Covers(double begin_s, double end_s) const;
  // Rotation vector of the sensor between two covered times, divided by the time between them,
  // rad/s.
  Eigen::Vector3d MeanRate(double begin_s, double end_s) const;
  // Sum of the rotation angles of the steps between two covered times, to the next samples, rad.
  double PathLength(double begin_s, double end_s) const;

 private:
  Eigen::Quaterniond RotationAt(double stamp_s) const;

  const std::vector<ImuSample>* samples_ = nullptr;
  std::vector<Eigen::Quaterniond> rotations_;  // from the first sample to each sample
  std::vector<double> lengths_;                // path length to each sample, rad
};

// Calibration of a gyroscope by the rotations of the camera.
struct ImuAlignment {
  ImuCalibration calibration;  // input with the estimated rotation and time offset
  bool is_known = false;       // the rotation has a standard deviation below 1 degree
  Eigen::Vector3d gyro_bias_rad_per_s = Eigen::Vector3d::Zero();
  double gyro_bias_sigma_rad_per_s = 0;
  double residual_rad = 0;         // RMS per axis of the rotation between two poses
  std::string fault;               // wrong sign, unit or motion; empty: none
  bool has_enough_motion = false;  // a wrong sign or unit would be found
};

// Estimates rotation, time offset and gyroscope bias from the rotations of camera and gyroscope
// (hand-eye calibration of rotations). With the mean rates c of the camera and w of the gyroscope,
// the residuals are
//   c_k - R (w_k(offset) - bias).
// The calibration has the priors of `given`, the bias has its prior. An unknown rotation begins
// with the rotation of best fit (Kabsch) over time offsets of up to three standard deviations.
// Residuals have a Cauchy weight. Turns outside of the samples are not used.
ImuAlignment AlignImu(const GyroIntegral& gyro, const std::vector<CameraTurn>& turns,
                      const ImuCalibration& given);

}  // namespace surfit
