#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "surfit/geometry/rigid3.h"

namespace surfit {

class OptionVisitor;

// Length of gravity, m/s^2.
inline constexpr double kGravity_m_per_s2 = 9.81;

// Measurement of an inertial sensor, in the frame of the sensor. At rest, the accelerometer
// measures the specific force, which points up.
struct ImuSample {
  double stamp_s = 0;  // clock of the inertial sensor
  Eigen::Vector3d gyro_rad_per_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d accel_m_per_s2 = Eigen::Vector3d::Zero();
};

// Additive errors of the measurements: measurement = true value + bias + noise.
struct ImuBias {
  Eigen::Vector3d gyro_rad_per_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d accel_m_per_s2 = Eigen::Vector3d::Zero();
};

// Noise of an inertial sensor. The defaults suit the sensors of phones and depth cameras. The
// densities are larger than in data sheets, because they include scale and timing errors.
struct ImuNoise {
  double gyro_density = 5e-4;        // rad/s/sqrt(Hz), white noise per axis
  double accel_density = 1e-2;       // m/s^2/sqrt(Hz), white noise per axis
  double gyro_bias_density = 2e-5;   // rad/s^2/sqrt(Hz), random walk of the bias
  double accel_bias_density = 5e-4;  // m/s^3/sqrt(Hz), random walk of the bias
  // Prior standard deviation of each bias component.
  double gyro_bias_sigma = 0.01;  // rad/s
  double accel_bias_sigma = 0.1;  // m/s^2
  // Measurements with a component of this size or more are saturated. 0: unlimited range.
  double gyro_range = 0;   // rad/s
  double accel_range = 0;  // m/s^2
  // Longer intervals between two samples are gaps, s.
  double max_step_s = 0.035;

  void Visit(OptionVisitor& visitor);
  // Throws InputError with the name `what`, the field, its value and the constraint.
  void Validate(const std::string& what) const;
};

// Mounting of an inertial sensor on the depth camera, and its noise. Standard deviations describe
// the error of the input value; 0: exact. Infinite: unknown.
struct ImuCalibration {
  Rigid3d camera_from_imu;
  double rotation_sigma_rad = 0;
  double translation_sigma_m = 0.05;
  // Time of the inertial clock minus capture time of the depth image, at the same moment, s.
  double time_offset_s = 0;
  double time_offset_sigma_s = 0.01;
  ImuNoise noise;
};

// Samples in ascending order of time, with their calibration.
struct ImuRecording {
  std::vector<ImuSample> samples;
  ImuCalibration calibration;
  bool has_gyro = true;     // false: only the direction of gravity is used
  std::string read_from;    // file or topics, for messages
  int dropped_samples = 0;  // samples without a number, or not later than the sample before
};

using Matrix15d = Eigen::Matrix<double, 15, 15>;

// Preintegrated motion of an inertial sensor from time i to time j (Forster, Carlone, Dellaert and
// Scaramuzza, "On-Manifold Preintegration for Real-Time Visual-Inertial Odometry", IEEE T-RO 2017).
// With the rotations R, positions p and velocities v of the sensor in a world with gravity g, and
// T = duration_s:
//   rotation   = R_i^T R_j
//   position_m = R_i^T (p_j - p_i - v_i T - g T^2 / 2)
//   velocity   = R_i^T (v_j - v_i - g T)
// Errors are true minus integrated values, in the order (rotation [rad], position [m], velocity
// [m/s], gyroscope bias [rad/s], accelerometer bias [m/s^2]). The rotation error d is a right
// perturbation: true rotation = rotation exp(d). It is thus in the sensor frame at time j. All
// other perturbations of poses in this library are left perturbations (rigid3.h).
struct PreintegratedImu {
  double duration_s = 0;
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_m_per_s = Eigen::Vector3d::Zero();
  ImuBias bias;  // of the integration
  // Covariance of the errors for an exact bias at time i. The bias errors are those of the random
  // walk from i to j. Positive definite if the duration is positive.
  Matrix15d covariance = Matrix15d::Zero();
  // Derivative of the first nine errors by the true bias at time i (gyroscope, accelerometer).
  Eigen::Matrix<double, 9, 6> bias_jacobian = Eigen::Matrix<double, 9, 6>::Zero();
  // Intervals between samples that are longer than ImuNoise::max_step_s, and intervals with a
  // saturated sample.
  int gaps = 0, saturated = 0;
};

// Measurement at a time, linear between two samples. The first and the last sample also apply up to
// ImuNoise::max_step_s before and after them. Otherwise, returns std::nullopt.
std::optional<ImuSample> InterpolateImu(const std::vector<ImuSample>& samples, double stamp_s,
                                        double max_step_s);

// Integrates the samples from `begin_s` to `end_s`, which are times of the inertial clock. The
// measurements at both times are interpolated. Returns std::nullopt unless begin_s < end_s, and if
// InterpolateImu() fails at one of them.
//
// Each step uses the mean rate of both ends (midpoint rule), and the exact integrals of an
// acceleration that is linear in time. The covariance of a step is that of continuous white noise.
// A gap or a saturated sample increases the covariance of its own interval only:
// - The rates within a gap of length T are a Brownian bridge between both ends. It adds the density
//   q T^2 / 12 to the white noise, with q = (3 rad/s)^2/s and (10 m/s^2)^2/s.
// - The true value of a saturated sample differs by 0.3 times the range.
std::optional<PreintegratedImu> PreintegrateImu(const std::vector<ImuSample>& samples,
                                                double begin_s, double end_s, const ImuBias& bias,
                                                const ImuNoise& noise);

// Pose and velocity of an inertial sensor in the world frame.
struct ImuState {
  Rigid3d world_from_imu;
  Eigen::Vector3d velocity_m_per_s = Eigen::Vector3d::Zero();
};

// State at the end of the interval, for the bias of the integration. `gravity_m_per_s2`: vector in
// the world frame that points down.
ImuState PredictImu(const ImuState& begin, const PreintegratedImu& motion,
                    const Eigen::Vector3d& gravity_m_per_s2);

// Interval without a registered pose that the inertial sensor has bridged.
struct ImuBridge {
  int frame = 0;              // first frame with a pose after the interval
  double seconds = 0;         // since the last pose
  Rigid3d world_from_camera;  // predicted pose of this frame
  // Standard deviations of the prediction in the worst direction.
  double sigma_m = 0, sigma_rad = 0;
  // Difference of the registered pose from the prediction.
  double correction_m = 0, correction_rad = 0;
};

// Use of an inertial sensor by tracking.
struct ImuReport {
  std::string read_from;       // ImuRecording::read_from; empty: no sensor
  std::string off_reason;      // reason why the sensor was switched off; empty: in use
  ImuCalibration calibration;  // estimated rotation, time offset and lever arm
  bool rotation_is_known = false;
  bool has_enough_motion = false;  // a wrong sign, unit or axis would have been found
  ImuBias bias;
  double gyro_bias_sigma_rad_per_s = 0;
  // Frames with a pose that was predicted by the gyroscope alone, and by both sensors.
  int gyro_frames = 0, full_frames = 0;
  int starts = 0;  // starts of the prediction by both sensors
  std::vector<ImuBridge> bridges;
  // Unit vector opposite to gravity in the world frame, with its standard deviation in the worst
  // direction. std::nullopt: unknown.
  std::optional<Eigen::Vector3d> up_in_world;
  double up_sigma_rad = 0;
};

}  // namespace surfit
