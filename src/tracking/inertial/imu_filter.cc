#include "tracking/inertial/imu_filter.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "registration/solvers/decompositions.h"

namespace surfit {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// First index of each error.
enum FilterBlock {
  kOfTurn = 0,
  kOfPlace = 3,
  kOfSpeed = 6,
  kOfGyroBias = 9,
  kOfAccelBias = 12,
  kOfGravity = 15,
  kOfArm = 18
};

constexpr int kMinPoses = 5;
constexpr double kMinStart_s = 0.4;
constexpr double kMaxSpeedSigma = 0.15, kMaxGravitySigma = 3 * kRadPerDeg;
constexpr double kGravityLengthSigma = 0.03;
constexpr double kMaxDistance2 = 50;
constexpr double kMapDrift_rad = 0.00175, kMapDrift_m = 0.005;  // in one second

// Unknowns of the start: rotation, position and velocity at the last pose, accelerometer bias,
// gravity, lever arm.
constexpr int kStartSize = 18;
enum StartBlock {
  kStartTurn = 0,
  kStartPlace = 3,
  kStartSpeed = 6,
  kStartBias = 9,
  kStartGravity = 12,
  kStartArm = 15
};

// Equation of one pose: place = rows * unknowns + constant.
struct StartRow {
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(3, kStartSize);
  Vector3d place;  // minus the constant
  Matrix3d information;
};

// With the preintegrated motion over T from the pose k to the last pose n, the sensor moves by
//   p_n - p_k = v_n T - g T^2 / 2 + R_k (D_p - D_v T),  R_k = R_n D_R^T.
// The camera of pose k is at p_k - C_k l, with the lever arm l.
std::optional<StartRow> RowOf(const RegisteredPose& pose, const std::vector<ImuSample>& samples,
                              double last_s, const Rigid3d& world_from_last_camera,
                              const ImuCalibration& calibration, const ImuBias& bias) {
  StartRow row;
  PreintegratedImu motion;
  if (pose.stamp_s < last_s) {
    const auto found = PreintegrateImu(samples, pose.stamp_s + calibration.time_offset_s,
                                       last_s + calibration.time_offset_s, bias, calibration.noise);
    if (!found) return std::nullopt;
    motion = *found;
  }
  const double t = motion.duration_s;
  const Eigen::Quaterniond last =
      world_from_last_camera.rotation * calibration.camera_from_imu.rotation;
  const Matrix3d last_from_k = motion.rotation.conjugate().toRotationMatrix();
  const Matrix3d rotation = last.toRotationMatrix() * last_from_k;
  const Matrix3d camera =
      (last * motion.rotation.conjugate() * calibration.camera_from_imu.rotation.conjugate())
          .toRotationMatrix();
  const Vector3d arm = calibration.camera_from_imu.translation;
  const Vector3d moved = motion.position_m - t * motion.velocity_m_per_s;
  row.rows.block<3, 3>(0, kStartTurn) =
      last.toRotationMatrix() * CrossMatrix<double>(Vector3d(last_from_k * moved));
  row.rows.block<3, 3>(0, kStartPlace).setIdentity();
  row.rows.block<3, 3>(0, kStartSpeed) = -t * Matrix3d::Identity();
  row.rows.block<3, 3>(0, kStartBias) = -rotation * (motion.bias_jacobian.block<3, 3>(3, 3) -
                                                     t * motion.bias_jacobian.block<3, 3>(6, 3));
  row.rows.block<3, 3>(0, kStartGravity) = t * t / 2 * Matrix3d::Identity();
  row.rows.block<3, 3>(0, kStartArm) = -camera;
  row.place = pose.world_from_camera.translation + rotation * moved + camera * arm;
  const Matrix3d in_world = pose.world_from_camera.rotation.toRotationMatrix();
  Matrix3d covariance = in_world * pose.covariance.bottomRightCorner<3, 3>() * in_world.transpose();
  // Noise of the integration between both poses.
  covariance += motion.covariance.block<3, 3>(3, 3).trace() / 3 * Matrix3d::Identity();
  row.information = covariance.inverse();
  return row;
}

void AddStartPrior(int at, double sigma, Eigen::MatrixXd* information) {
  for (int k = 0; k < 3; ++k) (*information)(at + k, at + k) += 1 / (sigma * sigma);
}

double DirectionSigma(const Matrix3d& covariance, const Vector3d& gravity) {
  const Vector3d down = gravity.normalized();
  const Matrix3d across = Matrix3d::Identity() - down * down.transpose();
  const Matrix3d of_direction = across * covariance * across / gravity.squaredNorm();
  return LargestSigma(of_direction);
}

}  // namespace

Matrix6d MapDrift(double seconds) {
  Vector6d variances;
  variances << Vector3d::Constant(kMapDrift_rad * kMapDrift_rad),
      Vector3d::Constant(kMapDrift_m * kMapDrift_m);
  return (seconds * variances).asDiagonal();
}

std::optional<ImuFilter> ImuFilter::Start(const std::vector<ImuSample>* samples,
                                          const std::vector<RegisteredPose>& poses,
                                          const ImuCalibration& calibration,
                                          const Eigen::Vector3d& gyro_bias_rad_per_s,
                                          double gyro_bias_sigma_rad_per_s) {
  if (static_cast<int>(poses.size()) < kMinPoses ||
      poses.back().stamp_s - poses.front().stamp_s < kMinStart_s) {
    return std::nullopt;
  }
  const RegisteredPose& last = poses.back();
  const ImuBias bias = {gyro_bias_rad_per_s, Vector3d::Zero()};
  Eigen::MatrixXd data = Eigen::MatrixXd::Zero(kStartSize, kStartSize);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(kStartSize);
  Vector3d mean_force = Vector3d::Zero();
  double squares = 0;  // of the right sides
  for (const RegisteredPose& pose : poses) {
    const auto row = RowOf(pose, *samples, last.stamp_s, last.world_from_camera, calibration, bias);
    const auto sample = InterpolateImu(*samples, pose.stamp_s + calibration.time_offset_s,
                                       calibration.noise.max_step_s);
    if (!row || !sample) return std::nullopt;
    data += row->rows.transpose() * row->information * row->rows;
    right += row->rows.transpose() * row->information * row->place;
    squares += row->place.dot(row->information * row->place);
    mean_force += pose.world_from_camera.rotation *
                  (calibration.camera_from_imu.rotation * sample->accel_m_per_s2);
  }
  const double turn_sigma = std::hypot(std::sqrt(last.covariance.topLeftCorner<3, 3>().trace() / 3),
                                       calibration.rotation_sigma_rad);
  AddStartPrior(kStartTurn, turn_sigma, &data);
  AddStartPrior(kStartBias, calibration.noise.accel_bias_sigma, &data);
  AddStartPrior(kStartArm, std::max(1e-4, calibration.translation_sigma_m), &data);

  Vector3d down = -mean_force.normalized();
  Eigen::VectorXd solution;
  Eigen::MatrixXd covariance;
  for (int iteration = 0; iteration < 3; ++iteration) {
    Eigen::MatrixXd information = data;
    Eigen::VectorXd side = right;
    const double weight = 1 / (kGravityLengthSigma * kGravityLengthSigma);
    information.block<3, 3>(kStartGravity, kStartGravity) += weight * down * down.transpose();
    side.segment<3>(kStartGravity) += weight * kGravity_m_per_s2 * down;
    const Eigen::LDLT<Eigen::MatrixXd> solver(information);
    if (!solver.isPositive()) return std::nullopt;
    solution = solver.solve(side);
    covariance = solver.solve(Eigen::MatrixXd::Identity(kStartSize, kStartSize));
    down = solution.segment<3>(kStartGravity).normalized();
  }
  covariance = ((covariance + covariance.transpose()) / 2).eval();
  const double residual2 = squares - right.dot(solution);

  ImuFilter filter;
  filter.samples_ = samples;
  filter.calibration_ = calibration;
  filter.stamp_s_ = last.stamp_s;
  filter.start_distance2_ = std::max(0., residual2) / (3. * static_cast<double>(poses.size()));
  const Eigen::Quaterniond rotation =
      last.world_from_camera.rotation * calibration.camera_from_imu.rotation *
      QuaternionExp<double>(Vector3d(solution.segment<3>(kStartTurn)));
  filter.state_.world_from_imu = Rigid3d(rotation.normalized(), solution.segment<3>(kStartPlace));
  filter.state_.velocity_m_per_s = solution.segment<3>(kStartSpeed);
  filter.bias_ = {gyro_bias_rad_per_s, solution.segment<3>(kStartBias)};
  filter.gravity_ = solution.segment<3>(kStartGravity);
  filter.lever_arm_ = calibration.camera_from_imu.translation + solution.segment<3>(kStartArm);
  const int from[] = {kStartTurn, kStartPlace, kStartSpeed, kStartBias, kStartGravity, kStartArm};
  const int to[] = {kOfTurn, kOfPlace, kOfSpeed, kOfAccelBias, kOfGravity, kOfArm};
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 6; ++j) {
      filter.covariance_.block<3, 3>(to[i], to[j]) = covariance.block<3, 3>(from[i], from[j]);
    }
  }
  filter.covariance_.block<3, 3>(kOfGyroBias, kOfGyroBias) =
      std::pow(std::max(1e-6, gyro_bias_sigma_rad_per_s), 2) * Matrix3d::Identity();
  const double speed_sigma =
      std::sqrt(filter.covariance_.block<3, 3>(kOfSpeed, kOfSpeed).diagonal().maxCoeff());
  if (!(speed_sigma < kMaxSpeedSigma) || !(filter.GravitySigma() < kMaxGravitySigma))
    return std::nullopt;
  return filter;
}

double ImuFilter::GravitySigma() const {
  return DirectionSigma(covariance_.block<3, 3>(kOfGravity, kOfGravity), gravity_);
}

std::optional<ImuFilter::Advanced> ImuFilter::AdvancedTo(double stamp_s) const {
  const auto motion =
      PreintegrateImu(*samples_, ImuTime(stamp_s_), ImuTime(stamp_s), bias_, calibration_.noise);
  if (!motion) return std::nullopt;
  const double t = motion->duration_s;
  const Matrix3d rotation = state_.world_from_imu.rotation.toRotationMatrix();
  const auto& by_bias = motion->bias_jacobian;
  Covariance transition = Covariance::Identity(kSize, kSize);
  transition.block<3, 3>(kOfTurn, kOfTurn) = motion->rotation.conjugate().toRotationMatrix();
  transition.block<3, 6>(kOfTurn, kOfGyroBias) = by_bias.topRows<3>();
  transition.block<3, 3>(kOfPlace, kOfTurn) = -rotation * CrossMatrix<double>(motion->position_m);
  transition.block<3, 3>(kOfPlace, kOfSpeed) = t * Matrix3d::Identity();
  transition.block<3, 6>(kOfPlace, kOfGyroBias) = rotation * by_bias.middleRows<3>(3);
  transition.block<3, 3>(kOfPlace, kOfGravity) = t * t / 2 * Matrix3d::Identity();
  transition.block<3, 3>(kOfSpeed, kOfTurn) =
      -rotation * CrossMatrix<double>(motion->velocity_m_per_s);
  transition.block<3, 6>(kOfSpeed, kOfGyroBias) = rotation * by_bias.bottomRows<3>();
  transition.block<3, 3>(kOfSpeed, kOfGravity) = t * Matrix3d::Identity();
  // Errors of PreintegratedImu in the frames of the filter.
  Matrix15d to_world = Matrix15d::Identity();
  to_world.block<3, 3>(3, 3) = to_world.block<3, 3>(6, 6) = rotation;
  Advanced advanced;
  advanced.state = PredictImu(state_, *motion, gravity_);
  advanced.covariance = transition * covariance_ * transition.transpose();
  advanced.covariance.topLeftCorner<15, 15>() +=
      to_world * motion->covariance * to_world.transpose();
  advanced.covariance = ((advanced.covariance + advanced.covariance.transpose()) / 2).eval();
  return advanced;
}

// With the rotation M = camera_from_imu and the lever arm l, the camera is at p - C l with C = R
// M^T. Its errors are w = M (rotation error) and v = C^T (position error) + [l]x w - (arm error).
Eigen::MatrixXd ImuFilter::CameraJacobian(const ImuState& state) const {
  const Matrix3d mount = calibration_.camera_from_imu.rotation.toRotationMatrix();
  const Matrix3d camera = state.world_from_imu.rotation.toRotationMatrix() * mount.transpose();
  Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(6, kSize);
  jacobian.block<3, 3>(0, kOfTurn) = mount;
  jacobian.block<3, 3>(3, kOfTurn) = CrossMatrix<double>(lever_arm_) * mount;
  jacobian.block<3, 3>(3, kOfPlace) = camera.transpose();
  jacobian.block<3, 3>(3, kOfArm) = -Matrix3d::Identity();
  return jacobian;
}

ImuPrediction ImuFilter::CameraOf(const ImuState& state, const Covariance& covariance) const {
  const Eigen::Quaterniond camera =
      (state.world_from_imu.rotation * calibration_.camera_from_imu.rotation.conjugate())
          .normalized();
  ImuPrediction prediction;
  prediction.world_from_camera =
      Rigid3d(camera, state.world_from_imu.translation - camera * lever_arm_);
  const Eigen::MatrixXd jacobian = CameraJacobian(state);
  prediction.covariance = jacobian * covariance * jacobian.transpose();
  return prediction;
}

std::optional<ImuPrediction> ImuFilter::Predict(double stamp_s) const {
  const std::optional<Advanced> advanced = AdvancedTo(stamp_s);
  if (!advanced) return std::nullopt;
  return CameraOf(advanced->state, advanced->covariance);
}

std::optional<double> ImuFilter::Correct(const RegisteredPose& pose) {
  const std::optional<Advanced> advanced = AdvancedTo(pose.stamp_s);
  if (!advanced) return std::nullopt;
  stamp_s_ = pose.stamp_s;
  state_ = advanced->state;
  covariance_ = advanced->covariance;
  const ImuPrediction predicted = CameraOf(state_, covariance_);
  const Rigid3d error = predicted.world_from_camera.Inverse() * pose.world_from_camera;
  Vector6d innovation;
  innovation << QuaternionLog<double>(error.rotation), error.translation;
  const Eigen::MatrixXd jacobian = CameraJacobian(state_);
  Matrix6d measured = pose.covariance;
  const double distance2 = innovation.dot(SolveLdlt(predicted.covariance + measured, innovation));
  if (distance2 > kMaxDistance2) measured *= distance2 / kMaxDistance2;
  const Matrix6d sum = predicted.covariance + measured;
  const Eigen::MatrixXd gain = covariance_ * jacobian.transpose() * SymmetricInverse(sum);
  const Eigen::VectorXd step = gain * innovation;
  const Covariance left = Covariance::Identity(kSize, kSize) - gain * jacobian;
  covariance_ = left * covariance_ * left.transpose() + gain * measured * gain.transpose();
  covariance_ = ((covariance_ + covariance_.transpose()) / 2).eval();
  Rigid3d& imu = state_.world_from_imu;
  imu.rotation =
      (imu.rotation * QuaternionExp<double>(Vector3d(step.segment<3>(kOfTurn)))).normalized();
  imu.translation += step.segment<3>(kOfPlace);
  state_.velocity_m_per_s += step.segment<3>(kOfSpeed);
  bias_.gyro_rad_per_s += step.segment<3>(kOfGyroBias);
  bias_.accel_m_per_s2 += step.segment<3>(kOfAccelBias);
  gravity_ += step.segment<3>(kOfGravity);
  lever_arm_ += step.segment<3>(kOfArm);
  return distance2;
}

// The drift w [rad], v [m] is a left perturbation of the world about the sensor.
void ImuFilter::AddMapDrift(double seconds) {
  Eigen::MatrixXd drift = Eigen::MatrixXd::Zero(kSize, 6);
  drift.block<3, 3>(kOfTurn, 0) = state_.world_from_imu.rotation.conjugate().toRotationMatrix();
  drift.block<3, 3>(kOfPlace, 3).setIdentity();
  drift.block<3, 3>(kOfSpeed, 0) = -CrossMatrix<double>(state_.velocity_m_per_s);
  drift.block<3, 3>(kOfGravity, 0) = -CrossMatrix<double>(gravity_);
  covariance_ += drift * MapDrift(seconds) * drift.transpose();
}

void ImuFilter::Recalibrate(const ImuCalibration& calibration) {
  Eigen::Quaterniond& rotation = state_.world_from_imu.rotation;
  rotation = (rotation * calibration_.camera_from_imu.rotation.conjugate() *
              calibration.camera_from_imu.rotation)
                 .normalized();
  calibration_ = calibration;
}

void ImuFilter::Move(const Rigid3d& new_from_old) {
  state_.world_from_imu = new_from_old * state_.world_from_imu;
  state_.velocity_m_per_s = new_from_old.rotation * state_.velocity_m_per_s;
  gravity_ = new_from_old.rotation * gravity_;
  Covariance turn = Covariance::Identity(kSize, kSize);
  for (const int at : {kOfPlace, kOfSpeed, kOfGravity}) {
    turn.block<3, 3>(at, at) = new_from_old.rotation.toRotationMatrix();
  }
  covariance_ = turn * covariance_ * turn.transpose();
}

}  // namespace surfit
