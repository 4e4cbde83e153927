#include "tracking/inertial/imu_tracking.h"

#include <glog/logging.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>

#include "registration/solvers/decompositions.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

using Eigen::Vector3d;

// Longest extrapolation of the translation at constant velocity.
constexpr double kMaxConstantVelocity_s = 0.2;
// Shortest turn for the alignment, and the time between two turns.
constexpr double kTurn_s = 0.2, kBetweenTurns_s = 0.1;
constexpr std::size_t kMaxTurns = 400;
// The alignment runs after each tenth turn.
constexpr std::size_t kTurnsPerAlignment = 10;
constexpr double kRecent_s = 1.5;
// Bounds of the pose noise per axis, and the weight of one frame in its mean.
constexpr double kMinPoseSigma_rad = 0.0003, kMaxPoseSigma_rad = 0.02;
constexpr double kMinPoseSigma_m = 0.0006, kMaxPoseSigma_m = 0.04, kMaxStartSigma_m = 0.02;
constexpr double kNoiseRate = 0.05;
constexpr std::size_t kMinRecent = 8;
// An interval without poses of this length is a bridge. It exceeds the interval of slow cameras.
constexpr double kBridge_s = 0.25;
// The filter starts again after this number of consecutive contradictions. A rotation
// contradicts the gyroscope beyond the limit. A pose contradicts both sensors beyond this squared
// Mahalanobis distance (6 degrees of freedom).
constexpr int kMaxContradictions = 8;
// Minimum time from the first start of the filter, and from a contradiction, to the next one.
constexpr double kMinTrusted_s = 5;
constexpr double kMaxTurnError_rad = 0.03, kMaxTurnError_rad_per_s = 0.1, kMaxPoseDistance2 = 100;

// Covariance of a pose with this information, and a prior of 1 rad and 1 m for directions without
// information.
Matrix6d CovarianceOf(const Matrix6d& information) {
  return SymmetricInverse(information + Matrix6d::Identity());
}

// True if registration constrains all directions of the pose. Only then does the pose drift with
// the map.
bool IsHeldByMap(const Matrix6d& information) {
  constexpr double kLeast = 1;  // 1/rad^2, 1/m^2
  const Eigen::SelfAdjointEigenSolver<Matrix6d> solver(information, Eigen::EigenvaluesOnly);
  return solver.eigenvalues().minCoeff() > kLeast;
}

// Accepted mean size of the accelerometer, m/s^2. A swung camera increases it.
constexpr double kMinMeanForce = 8.5, kMaxMeanForce = 12;
// Ratio of squared distances below which the negative accelerometer fits better.
constexpr double kMirroredForce = 0.25;
// Poses for the mean of the accelerometer.
constexpr int kMinForces = 10;

}  // namespace

ImuTracking::ImuTracking(ImuRecording recording)
    : recording_(std::move(recording)), gyro_(&recording_.samples) {
  alignment_ = AlignImu(gyro_, {}, recording_.calibration);
  report_.read_from = recording_.read_from;
  if (const std::string fault = FaultOfSize(); !fault.empty()) SwitchOff(fault);
}

bool ImuTracking::IsActive() const {
  return recording_.has_gyro && report_.off_reason.empty() && alignment_.is_known &&
         !recent_.empty();
}

std::optional<ImuTracking::Prediction> ImuTracking::Predict(double stamp_s) const {
  if (!IsActive()) return std::nullopt;
  const TrackedPose& last = recent_.back();
  const double seconds = stamp_s - last.stamp_s;
  if (!(seconds > 0 && seconds <= kMaxImuBridge_s)) return std::nullopt;
  if (filter_) {
    const auto predicted = filter_->Predict(stamp_s);
    if (!predicted) return std::nullopt;
    return Prediction{predicted->world_from_camera, predicted->covariance, noise_.Covariance()};
  }
  const ImuCalibration& calibration = alignment_.calibration;
  const auto motion =
      PreintegrateImu(recording_.samples, last.stamp_s + calibration.time_offset_s,
                      stamp_s + calibration.time_offset_s,
                      {alignment_.gyro_bias_rad_per_s, Vector3d::Zero()}, calibration.noise);
  if (!motion) return std::nullopt;
  const Eigen::Quaterniond& mount = calibration.camera_from_imu.rotation;
  Prediction prediction;
  prediction.world_from_camera = last.world_from_camera;
  prediction.world_from_camera.rotation =
      (last.world_from_camera.rotation * mount * motion->rotation * mount.conjugate()).normalized();
  if (recent_.size() >= 2) {
    const TrackedPose& before = recent_[recent_.size() - 2];
    const Vector3d velocity =
        (last.world_from_camera.translation - before.world_from_camera.translation) /
        (last.stamp_s - before.stamp_s);
    prediction.world_from_camera.translation +=
        std::min(seconds, kMaxConstantVelocity_s) * velocity;
  }
  return prediction;
}

std::optional<Vector3d> ImuTracking::CameraRate(double stamp_s) const {
  if (!IsActive()) return std::nullopt;
  const ImuCalibration& calibration = alignment_.calibration;
  const auto sample = InterpolateImu(recording_.samples, stamp_s + calibration.time_offset_s,
                                     calibration.noise.max_step_s);
  if (!sample) return std::nullopt;
  const Vector3d& bias = filter_ ? filter_->bias().gyro_rad_per_s : alignment_.gyro_bias_rad_per_s;
  return calibration.camera_from_imu.rotation * Vector3d(sample->gyro_rad_per_s - bias);
}

RegisteredPose ImuTracking::Registered(const TrackedPose& pose) const {
  RegisteredPose registered = {pose.stamp_s, pose.registered, CovarianceOf(pose.information)};
  registered.covariance += noise_.Covariance();
  return registered;
}

Matrix6d ImuTracking::PoseNoise::Covariance() const {
  Vector6d variances;
  variances << Vector3d::Constant(turn_rad * turn_rad), Vector3d::Constant(shift_m * shift_m);
  return variances.asDiagonal();
}

// The difference of two consecutive errors has twice the variance of one registered pose. A lasting
// error is one of the prediction, and does not count. Differences beyond three standard deviations
// are limited.
void ImuTracking::AddError(const Rigid3d& predicted_from_registered) {
  const auto update = [](double difference2, double least, double most, double* sigma) {
    const double now = *sigma * *sigma;
    const double variance = std::min(difference2 / 2, 9 * 3 * now) / 3;
    *sigma = std::clamp(std::sqrt(now + kNoiseRate * (variance - now)), least, most);
  };
  Vector6d error;
  error << QuaternionLog<double>(predicted_from_registered.rotation),
      predicted_from_registered.translation;
  if (last_error_) {
    const Vector6d difference = error - *last_error_;
    update(difference.head<3>().squaredNorm(), kMinPoseSigma_rad, kMaxPoseSigma_rad,
           &noise_.turn_rad);
    update(difference.tail<3>().squaredNorm(), kMinPoseSigma_m, kMaxPoseSigma_m, &noise_.shift_m);
  }
  last_error_ = error;
}

void ImuTracking::Add(const TrackedPose& pose, const std::optional<Prediction>& predicted) {
  AddForce(pose);
  if (!recording_.has_gyro || !report_.off_reason.empty()) return;
  if (!pose.information.isZero(0)) {
    registrations_[pose.frame] = {pose.world_from_camera.Inverse() * pose.registered,
                                  Registered(pose).covariance};
  }
  const bool continues =
      pose.continues && !recent_.empty() && pose.stamp_s > recent_.back().stamp_s;
  if (!continues) {
    recent_ = {pose};
    StopFilter();
    return;
  }
  const double seconds = pose.stamp_s - recent_.back().stamp_s;
  if (predicted) {
    const Rigid3d error = predicted->world_from_camera.Inverse() * pose.registered;
    const double turn_error = RotationAngle(error.rotation);
    ++(predicted->covariance ? report_.full_frames : report_.gyro_frames);
    if (seconds >= kBridge_s && predicted->covariance) {
      const Matrix6d& covariance = *predicted->covariance;
      report_.bridges.push_back({pose.frame, seconds, predicted->world_from_camera,
                                 LargestSigma(covariance.bottomRightCorner<3, 3>()),
                                 LargestSigma(covariance.topLeftCorner<3, 3>()),
                                 error.translation.norm(), turn_error});
    }
    if (!filter_) {
      CountContradiction(turn_error > kMaxTurnError_rad + kMaxTurnError_rad_per_s * seconds,
                         "the gyroscope contradicts the registered rotation", pose);
    }
  }
  if (filter_) {
    const std::optional<double> distance2 =
        seconds <= kMaxImuBridge_s ? filter_->Correct(Registered(pose)) : std::nullopt;
    if (distance2) {
      if (IsHeldByMap(pose.information)) filter_->AddMapDrift(std::min(seconds, kBridge_s));
      if (predicted && predicted->covariance) {
        AddError(predicted->world_from_camera.Inverse() * pose.registered);
      }
      const bool is_noisy =
          noise_.shift_m >= kMaxPoseSigma_m || noise_.turn_rad >= kMaxPoseSigma_rad;
      CountContradiction(*distance2 > kMaxPoseDistance2 || is_noisy,
                         "the inertial sensor contradicts the registered poses", pose);
    } else {
      StopFilter();
      recent_.clear();
    }
  }
  if (!report_.off_reason.empty()) return;
  recent_.push_back(pose);
  while (recent_.size() > kMinRecent && recent_.front().stamp_s < pose.stamp_s - kRecent_s)
    recent_.erase(recent_.begin());
  AddTurn(pose);
  if (!filter_ && report_.off_reason.empty()) StartFilter();
}

void ImuTracking::AddTurn(const TrackedPose& pose) {
  if (pose.stamp_s - last_turn_s_ < kBetweenTurns_s && !turns_.empty()) return;
  for (std::size_t i = recent_.size() - 1; i-- > 0;) {
    const TrackedPose& begin = recent_[i];
    const double seconds = pose.stamp_s - begin.stamp_s;
    if (seconds < kTurn_s) continue;
    if (seconds > kMaxImuBridge_s) return;
    last_turn_s_ = pose.stamp_s;
    turns_.push_back({begin.stamp_s, pose.stamp_s,
                      begin.registered.rotation.conjugate() * pose.registered.rotation});
    if (turns_.size() > kMaxTurns) turns_.erase(turns_.begin());
    if (turns_.size() % kTurnsPerAlignment == 0) Align();
    return;
  }
}

void ImuTracking::Align() {
  alignment_ = AlignImu(gyro_, turns_, recording_.calibration);
  if (!alignment_.fault.empty()) SwitchOff(alignment_.fault);
  if (filter_) filter_->Recalibrate(alignment_.calibration);
}

void ImuTracking::StartFilter() {
  if (!alignment_.is_known) return;
  for (const bool is_second : {false, true}) {
    std::vector<RegisteredPose> poses;
    for (const TrackedPose& pose : recent_) poses.push_back(Registered(pose));
    filter_ =
        ImuFilter::Start(&recording_.samples, poses, alignment_.calibration,
                         alignment_.gyro_bias_rad_per_s, alignment_.gyro_bias_sigma_rad_per_s);
    if (!filter_ || is_second || filter_->start_distance2() <= 1) break;
    // The fit shows the pose noise.
    noise_.shift_m =
        std::min(kMaxStartSigma_m, noise_.shift_m * std::sqrt(filter_->start_distance2()));
  }
  report_.starts += filter_.has_value();
  if (filter_ && !trusted_since_s_) trusted_since_s_ = recent_.back().stamp_s;
}

// The state of the filter can be wrong. A contradiction soon after the first start or after another
// contradiction is a fault of the sensor.
void ImuTracking::CountContradiction(bool contradicts, const char* what, const TrackedPose& pose) {
  contradictions_ = contradicts ? contradictions_ + 1 : 0;
  if (contradictions_ < kMaxContradictions) return;
  const bool is_negative = filter_ && NegativeAccelFits();
  if (filter_ && !is_negative && pose.stamp_s - *trusted_since_s_ > kMinTrusted_s) {
    trusted_since_s_ = pose.stamp_s;
    contradictions_ = 0;
    noise_ = {};
    StopFilter();
    recent_.clear();
    return;
  }
  SwitchOff(Concat(what, " in ", kMaxContradictions, " consecutive frames",
                   is_negative ? ": the sign of the accelerometer is wrong" : ""));
}

std::string ImuTracking::FaultOfSize() const {
  if (recording_.samples.empty()) return "there is no sample";
  double sum = 0;
  for (const ImuSample& sample : recording_.samples) sum += sample.accel_m_per_s2.norm();
  const double mean = sum / static_cast<double>(recording_.samples.size());
  if (mean > kMinMeanForce && mean < kMaxMeanForce) return "";
  const double in_g = mean * kGravity_m_per_s2;
  const bool is_g = in_g > kMinMeanForce && in_g < kMaxMeanForce;
  return Concat("the mean size of the accelerometer is ", mean, ", must be about ",
                kGravity_m_per_s2, " (m/s^2)", is_g ? ": its unit is g" : "");
}

bool ImuTracking::NegativeAccelFits() const {
  std::vector<ImuSample> negative = recording_.samples;
  for (ImuSample& sample : negative) sample.accel_m_per_s2 *= -1;
  std::vector<RegisteredPose> poses;
  for (const TrackedPose& pose : recent_) poses.push_back(Registered(pose));
  const auto start = [&](const std::vector<ImuSample>& samples) {
    return ImuFilter::Start(&samples, poses, alignment_.calibration, alignment_.gyro_bias_rad_per_s,
                            alignment_.gyro_bias_sigma_rad_per_s);
  };
  const auto as_given = start(recording_.samples), negated = start(negative);
  return negated && as_given &&
         negated->start_distance2() < kMirroredForce * as_given->start_distance2();
}

// The acceleration of the camera averages out over the recording.
void ImuTracking::AddForce(const TrackedPose& pose) {
  const ImuCalibration& calibration = alignment_.calibration;
  const auto sample = InterpolateImu(recording_.samples, pose.stamp_s + calibration.time_offset_s,
                                     calibration.noise.max_step_s);
  if (!sample || !alignment_.is_known) return;
  force_sum_ += pose.world_from_camera.rotation *
                (calibration.camera_from_imu.rotation * sample->accel_m_per_s2);
  ++force_count_;
}

void ImuTracking::StopFilter() {
  filter_.reset();
  last_error_.reset();
}

void ImuTracking::SwitchOff(const std::string& reason) {
  report_.off_reason = reason;
  StopFilter();
  LOG(WARNING) << "the inertial sensor is switched off: " << reason;
}

void ImuTracking::Move(const Rigid3d& new_from_old) {
  for (TrackedPose& pose : recent_) {
    pose.world_from_camera = new_from_old * pose.world_from_camera;
    pose.registered = new_from_old * pose.registered;
  }
  force_sum_ = new_from_old.rotation * force_sum_;
  if (smoothed_up_) smoothed_up_ = new_from_old.rotation * *smoothed_up_;
  if (filter_) filter_->Move(new_from_old);
}

std::optional<std::vector<Rigid3d>> ImuTracking::Smooth(const std::vector<FramePose>& frames) {
  const ImuReport now = report();
  if (!now.off_reason.empty() || now.full_frames == 0 || frames.empty()) return std::nullopt;
  std::vector<PoseToSmooth> poses;
  for (const FramePose& frame : frames) {
    PoseToSmooth pose = {frame.stamp_s, frame.world_from_camera, std::nullopt, Matrix6d::Zero(),
                         !poses.empty() && frame.segment == frames[poses.size() - 1].segment};
    const auto found = registrations_.find(frame.frame);
    if (found != registrations_.end()) {
      pose.registered = frame.world_from_camera * found->second.camera_from_registered;
      pose.covariance = found->second.covariance;
    }
    poses.push_back(pose);
  }
  SmoothedPoses smoothed = SmoothByImu(recording_.samples, now.calibration, poses);
  smoothed_up_ = smoothed.up_in_world;
  return std::move(smoothed.world_from_camera);
}

ImuReport ImuTracking::report() const {
  ImuReport report = report_;
  report.calibration = alignment_.calibration;
  report.rotation_is_known = alignment_.is_known;
  report.has_enough_motion = alignment_.has_enough_motion;
  report.bias.gyro_rad_per_s = alignment_.gyro_bias_rad_per_s;
  report.gyro_bias_sigma_rad_per_s = alignment_.gyro_bias_sigma_rad_per_s;
  if (!filter_) {
    // Sensors without gyroscope have the mean force alone.
    const bool is_known =
        recording_.has_gyro ? smoothed_up_.has_value() : force_count_ >= kMinForces;
    if (!is_known) return report;
    report.up_in_world = smoothed_up_.value_or(force_sum_.normalized());
    report.up_sigma_rad =
        std::hypot(recording_.calibration.noise.accel_bias_sigma / kGravity_m_per_s2,
                   alignment_.calibration.rotation_sigma_rad);
    return report;
  }
  report.bias = filter_->bias();
  report.calibration.camera_from_imu.translation = filter_->lever_arm_m();
  report.calibration.translation_sigma_m =
      LargestSigma(filter_->covariance().bottomRightCorner<3, 3>());
  report.up_in_world = smoothed_up_.value_or(-filter_->gravity_m_per_s2().normalized());
  // The error of the mounting does not average out.
  report.up_sigma_rad =
      std::hypot(filter_->GravitySigma(), alignment_.calibration.rotation_sigma_rad);
  return report;
}

}  // namespace surfit
