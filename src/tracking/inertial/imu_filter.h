#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "surfit/geometry/inertial.h"
#include "surfit/geometry/trajectory.h"
#include "surfit/registration/normal_system.h"

namespace surfit {

// Predicted camera pose.
struct ImuPrediction {
  Rigid3d world_from_camera;
  // Covariance (rad, m) of the left perturbation of the identity in the predicted camera frame.
  Matrix6d covariance = Matrix6d::Zero();
};

// Registered pose without any inertial information, with its covariance as in ImuPrediction.
struct RegisteredPose {
  double stamp_s = 0;  // capture time
  Rigid3d world_from_camera;
  Matrix6d covariance = Matrix6d::Zero();
};

// Covariance (rad, m) of the drift of a map in some seconds, in the camera frame. Registration
// holds the camera in the map, but the errors of new surfaces add up. The drift is a random walk
// with standard deviations of 0.1 degrees and 5 mm per axis in one second.
Matrix6d MapDrift(double seconds);

// Error-state Kalman filter of pose, velocity, biases, gravity and lever arm of an inertial sensor.
// The order of the errors, true minus estimated, is
//   rotation (right perturbation, sensor frame), position, velocity (world), gyroscope bias,
//   accelerometer bias, gravity (world), lever arm (sensor position in the camera frame).
// The rotation and the time offset of the calibration are fixed.
class ImuFilter {
 public:
  static constexpr int kSize = 21;
  using Covariance = Eigen::MatrixXd;  // kSize rows

  // Solves velocity, gravity, accelerometer bias and lever arm from the given poses by linear least
  // squares. The state is that of the last pose. Bias, lever arm and the length of gravity have
  // priors.
  // Requires at least five poses over at least 0.4 s. Returns std::nullopt for fewer poses or
  // missing samples, and if the standard deviation of the velocity exceeds 0.15 m/s or that of
  // gravity's direction 3 degrees. Keeps the pointer to the samples.
  static std::optional<ImuFilter> Start(const std::vector<ImuSample>* samples,
                                        const std::vector<RegisteredPose>& poses,
                                        const ImuCalibration& calibration,
                                        const Eigen::Vector3d& gyro_bias_rad_per_s,
                                        double gyro_bias_sigma_rad_per_s);

  // Prediction at a capture time after the last one. Returns std::nullopt without samples.
  std::optional<ImuPrediction> Predict(double stamp_s) const;
  // Moves the state to the time of a registered pose, and corrects it by this pose. The pose must
  // not contain inertial information, so that no sample counts twice. Returns the squared
  // Mahalanobis distance (6 degrees of freedom) of the pose from the prediction. A distance above
  // 50 increases the covariance of the pose, so that it does not exceed 50. Returns std::nullopt
  // without samples; the state is then unchanged.
  std::optional<double> Correct(const RegisteredPose& pose);
  // Adds the drift of the map in some seconds. Pose, velocity and gravity turn against the map.
  void AddMapDrift(double seconds);
  // Replaces rotation and time offset of the calibration. The camera pose stays.
  void Recalibrate(const ImuCalibration& calibration);
  // Applies a correction of the world frame.
  void Move(const Rigid3d& new_from_old);

  double stamp_s() const { return stamp_s_; }
  // Mean squared Mahalanobis distance per coordinate of the poses of Start().
  double start_distance2() const { return start_distance2_; }
  const ImuState& state() const { return state_; }
  const ImuBias& bias() const { return bias_; }
  const Eigen::Vector3d& gravity_m_per_s2() const { return gravity_; }
  const Eigen::Vector3d& lever_arm_m() const { return lever_arm_; }
  const Covariance& covariance() const { return covariance_; }
  // Standard deviation of the direction of gravity in the worst direction, rad.
  double GravitySigma() const;

 private:
  struct Advanced {
    ImuState state;
    Covariance covariance;
  };
  std::optional<Advanced> AdvancedTo(double stamp_s) const;
  ImuPrediction CameraOf(const ImuState& state, const Covariance& covariance) const;
  Eigen::MatrixXd CameraJacobian(const ImuState& state) const;
  double ImuTime(double stamp_s) const { return stamp_s + calibration_.time_offset_s; }

  const std::vector<ImuSample>* samples_ = nullptr;
  ImuCalibration calibration_;
  double stamp_s_ = 0;  // capture time of the state
  double start_distance2_ = 0;
  ImuState state_;
  ImuBias bias_;
  Eigen::Vector3d gravity_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d lever_arm_ = Eigen::Vector3d::Zero();
  Covariance covariance_ = Covariance::Zero(kSize, kSize);
};

}  // namespace surfit
