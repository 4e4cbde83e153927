#include "tracking/inertial/imu_tracking.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "registration/solvers/decompositions.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

using Eigen::Vector3d;

constexpr double kMaxBridge_s = 1.1;
// Longest extrapolation of the translation at constant velocity.
constexpr double kMaxConstantVelocity_s = 0.2;
// Shortest turn for the alignment, and the time between two turns.
constexpr double kTurn_s = 0.2, kBetweenTurns_s = 0.1;
constexpr std::size_t kMaxTurns = 400;
// The alignment runs after each tenth turn.
constexpr std::size_t kTurnsPerAlignment = 10;
constexpr double kRecent_s = 1.5;
constexpr std::size_t kMinRecent = 8;
// An interval without poses of this length is a bridge. It exceeds the interval of slow cameras.
constexpr double kBridge_s = 0.25;
// The sensor is switched off after this number of consecutive frames whose rotation differs by more
// than the limit, or whose pose exceeds this squared Mahalanobis distance (6 degrees of freedom).
constexpr int kMaxContradictions = 8;
constexpr double kMaxTurnError_rad = 0.03, kMaxTurnError_rad_per_s = 0.1, kMaxPoseDistance2 = 100;

// Covariance of a pose with this information, and a prior of 1 rad and 1 m for directions without
// information.
Matrix6d CovarianceOf(const Matrix6d& information) {
  return SymmetricInverse(information + Matrix6d::Identity());
}

}  // namespace

ImuTracking::ImuTracking(ImuRecording recording)
    : recording_(std::move(recording)), gyro_(&recording_.samples) {
  alignment_ = AlignImu(gyro_, {}, recording_.calibration);
  report_.read_from = recording_.read_from;
  if (!recording_.has_gyro) SwitchOff("the sensor has no gyroscope");
}

bool ImuTracking::IsActive() const {
  return report_.off_reason.empty() && alignment_.is_known && !recent_.empty();
}

std::optional<ImuTracking::Prediction> ImuTracking::Predict(double stamp_s) const {
  if (!IsActive()) return std::nullopt;
  const TrackedPose& last = recent_.back();
  const double seconds = stamp_s - last.stamp_s;
  if (!(seconds > 0 && seconds <= kMaxBridge_s)) return std::nullopt;
  if (filter_) {
    const auto predicted = filter_->Predict(stamp_s);
    if (!predicted) return std::nullopt;
    return Prediction{predicted->world_from_camera, predicted->covariance};
  }
  const ImuCalibration& calibration = alignment_.calibration;
  const auto motion =
      PreintegrateImu(recording_.samples, last.stamp_s + calibration.time_offset_s,
                      stamp_s + calibration.time_offset_s,
                      {alignment_.gyro_bias_rad_per_s, Vector3d::Zero()}, calibration.noise);
  if (!motion) return std::nullopt;
  const Eigen::Quaterniond& mount = calibration.camera_from_imu.rotation;
  Prediction prediction = {last.world_from_camera, std::nullopt};
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
  for (int k = 0; k < 3; ++k) {
    registered.covariance(k, k) += kPoseSigma_rad * kPoseSigma_rad;
    registered.covariance(3 + k, 3 + k) += kPoseSigma_m * kPoseSigma_m;
  }
  return registered;
}

void ImuTracking::Add(const TrackedPose& pose, const std::optional<Prediction>& predicted) {
  if (!report_.off_reason.empty()) return;
  const bool continues =
      pose.continues && !recent_.empty() && pose.stamp_s > recent_.back().stamp_s;
  if (!continues) {
    recent_ = {pose};
    filter_.reset();
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
                         "the gyroscope contradicts the registered rotation");
    }
  }
  if (filter_) {
    const std::optional<double> distance2 =
        seconds <= kMaxBridge_s ? filter_->Correct(Registered(pose)) : std::nullopt;
    if (distance2) {
      CountContradiction(*distance2 > kMaxPoseDistance2,
                         "the inertial sensor contradicts the registered poses");
    } else {
      filter_.reset();
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
    if (seconds > kMaxBridge_s) return;
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
  std::vector<RegisteredPose> poses;
  for (const TrackedPose& pose : recent_) poses.push_back(Registered(pose));
  filter_ = ImuFilter::Start(&recording_.samples, poses, alignment_.calibration,
                             alignment_.gyro_bias_rad_per_s, alignment_.gyro_bias_sigma_rad_per_s);
  report_.starts += filter_.has_value();
}

void ImuTracking::CountContradiction(bool contradicts, const char* what) {
  contradictions_ = contradicts ? contradictions_ + 1 : 0;
  if (contradictions_ < kMaxContradictions) return;
  SwitchOff(Concat(what, " in ", kMaxContradictions, " consecutive frames"));
}

void ImuTracking::SwitchOff(const std::string& reason) {
  report_.off_reason = reason;
  filter_.reset();
  if (recording_.has_gyro) {
    LOG(WARNING) << "the inertial sensor is switched off: " << reason;
  }
}

void ImuTracking::Move(const Rigid3d& new_from_old) {
  for (TrackedPose& pose : recent_) {
    pose.world_from_camera = new_from_old * pose.world_from_camera;
    pose.registered = new_from_old * pose.registered;
  }
  if (filter_) filter_->Move(new_from_old);
}

ImuReport ImuTracking::report() const {
  ImuReport report = report_;
  report.calibration = alignment_.calibration;
  report.rotation_is_known = alignment_.is_known;
  report.has_enough_motion = alignment_.has_enough_motion;
  report.bias.gyro_rad_per_s = alignment_.gyro_bias_rad_per_s;
  report.gyro_bias_sigma_rad_per_s = alignment_.gyro_bias_sigma_rad_per_s;
  if (!filter_) return report;
  report.bias = filter_->bias();
  report.calibration.camera_from_imu.translation = filter_->lever_arm_m();
  report.calibration.translation_sigma_m =
      LargestSigma(filter_->covariance().bottomRightCorner<3, 3>());
  report.up_in_world = -filter_->gravity_m_per_s2().normalized();
  report.up_sigma_rad = filter_->GravitySigma();
  return report;
}

}  // namespace surfit
