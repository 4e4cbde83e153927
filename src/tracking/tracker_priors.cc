#include <algorithm>
#include <utility>

#include "registration/solvers/decompositions.h"
#include "tracking/tracker.h"

namespace surfit {
namespace {

// Maximum squared difference of a registered pose from prior poses, in standard deviations. A
// chi-square variable with 6 degrees of freedom exceeds it with a probability of 4e-7.
constexpr double kMaxPriorDifference = 40;
// Bounds the influence of outliers of the registration.
constexpr double kMaxPriorSigmas = 3;

// Distance of two poses: translation plus 2 m times the rotation angle.
double DistanceOf(const Rigid3d& a, const Rigid3d& b) {
  const Rigid3d motion = a.Inverse() * b;
  return motion.translation.norm() + 2 * RotationAngle(motion.rotation);
}

// A registered pose agrees with the inertial prediction within these bounds. The bounds of a
// certain prediction are those of AreOnePlace().
constexpr double kImuShift_m = 0.05, kMaxImuShift_m = 0.15, kMaxImuTurn_rad = 0.05;
// Information of a given pose: 0.1 mrad and 0.1 mm.
constexpr double kGivenInformation = 1e8;

}  // namespace

// A registration that differs from the prior is an outlier, unless the prior differs more from the
// motion of the last frame.
bool Tracker::AgreesWithPrior(const PreprocessedFrame& frame, const Tracked& tracked,
                              const Prediction& prediction) const {
  if (!tracked.has_pose() || tracked.verdict != Verdict::kAccepted) return false;
  if (tracked.prior_squared_difference < kMaxPriorDifference) return true;
  const Rigid3d smooth = motion_model_.PredictPose(state_, last_.world_from_view, SecondsTo(frame));
  return DistanceOf(smooth, prediction.world_from_camera) <
         DistanceOf(smooth, tracked.world_from_registered);
}

std::optional<ImuTracking::Prediction> Tracker::PredictByImu(double stamp_s) const {
  if (!imu_ || !state_.is_localised || state_.IsTentative()) return std::nullopt;
  return imu_->Predict(stamp_s);
}

// Uncertainty of the prediction: of the inertial sensor, else of the prior poses, else of the
// motion model. Drift of prior poses is larger than the noise of most registrations, so prior poses
// change the poses of weakly constrained frames only.
std::optional<MotionUncertainty> Tracker::PredictedUncertainty(
    const PreprocessedFrame& frame) const {
  MotionUncertainty motion;
  if (prior_motion_) {
    motion.covariance = last_covariance_ + prior_motion_->covariance;
    motion.registration_scale = prior_poses_->registration_scale();
    motion.max_sigmas = kMaxPriorSigmas;
    motion.holds_weak_frames_only = true;
    return motion;
  }
  if (imu_prediction_ && imu_prediction_->covariance) {
    motion.covariance = *imu_prediction_->covariance;
    motion.registration_noise = imu_prediction_->pose_noise;
    return motion;
  }
  const bool holds_weak_frames_only = options_.acceleration_m_per_s2 == 0;
  if (holds_weak_frames_only && (imu_ || options_.icp.error_model.UsesIntensities())) {
    return std::nullopt;
  }
  const auto covariance = motion_model_.PriorCovariance(state_, SecondsTo(frame));
  if (!covariance) return std::nullopt;
  motion.covariance = *covariance;
  motion.holds_weak_frames_only = holds_weak_frames_only;
  return motion;
}

// The inertial sensor loses no frame: a pose that is not accepted is registered again without the
// inertial prior.
Tracked Tracker::WithoutImu(const PreprocessedFrame& frame, const Prediction& prediction,
                            Tracked tracked) {
  const bool is_accepted = tracked.has_pose() && tracked.verdict == Verdict::kAccepted;
  if (prior_motion_ || !imu_prediction_ || !imu_prediction_->covariance || is_accepted) {
    return tracked;
  }
  const std::optional<ImuTracking::Prediction> predicted = std::exchange(imu_prediction_, {});
  Tracked again = ByDepthAlone(
      frame, prediction, Register(frame, *prediction.reference, prediction.world_from_camera));
  if (again.has_pose() && again.verdict == Verdict::kAccepted) return again;
  imu_prediction_ = predicted;
  return tracked;
}

// A pose that agrees with the prediction of both inertial sensors needs no search, even if it is
// uncertain: two independent measurements agree.
bool Tracker::AgreesWithImu(const Tracked& tracked) const {
  if (!imu_prediction_ || !imu_prediction_->covariance || !tracked.has_pose() ||
      tracked.verdict == Verdict::kRejected) {
    return false;
  }
  const Rigid3d error =
      imu_prediction_->world_from_camera.Inverse() * tracked.world_from_registered;
  const Matrix6d& covariance = *imu_prediction_->covariance;
  const double sigma_m = LargestSigma(covariance.bottomRightCorner<3, 3>());
  return error.translation.norm() <= std::min(kImuShift_m + 3 * sigma_m, kMaxImuShift_m) &&
         RotationAngle(error.rotation) <= kMaxImuTurn_rad;
}

// As AgreesWithImu(), for prior poses.
bool Tracker::IsHeldByPrior(const Tracked& tracked) const {
  if (!prior_motion_ || !tracked.has_pose() || tracked.verdict != Verdict::kAccepted) return false;
  const Rigid3d predicted = last_.world_from_view * prior_motion_->last_from_frame;
  const Rigid3d error = predicted.Inverse() * tracked.world_from_registered;
  return tracked.prior_squared_difference < kMaxPriorDifference &&
         error.translation.norm() <= kMaxImuShift_m &&
         RotationAngle(error.rotation) <= kMaxImuTurn_rad;
}

void Tracker::AddToImu(const PreprocessedFrame& frame, const Tracked& tracked) {
  if (!imu_) return;
  TrackedPose pose;
  pose.frame = frame.images.index;
  pose.stamp_s = frame.images.stamp_s;
  pose.world_from_camera = pose.registered = tracked.world_from_camera;
  if (tracked.state == FrameState::kGiven) {
    pose.information = kGivenInformation * Matrix6d::Identity();
  } else if (!tracked.registered_information.isZero(0)) {
    pose.registered = tracked.world_from_registered;
    pose.information = tracked.registered_information;
  }
  const bool changes_submap = tracked.submap && *tracked.submap != submap_;
  // A pose from a search that agrees with the prediction needs no new start.
  const bool is_expected = !tracked.found_by_search || AgreesWithImu(tracked);
  pose.continues = state_.HasStarted() && state_.is_localised && is_expected && !changes_submap;
  imu_->Add(pose, imu_prediction_);
  imu_prediction_.reset();
}

// Also keeps the covariance of the pose: the prior's motion to the next frame adds to it.
void Tracker::ComparePrior(const PreprocessedFrame& frame, const Tracked& tracked) {
  const bool is_registered = !tracked.registered_information.isZero(0);
  const Rigid3d registered =
      is_registered ? tracked.world_from_registered : tracked.world_from_camera;
  const bool is_next = state_.HasLastPose() && !tracked.found_by_search && !tracked.submap;
  if (is_next) {
    prior_poses_->Add({last_stamp_s_, frame.images.stamp_s,
                       world_from_registered_.Inverse() * registered,
                       tracked.icp.trusted_information, ModelAge(frame.images)});
  }
  if (prior_motion_ && tracked.motion_covariance && is_next) {
    prior_poses_->CountUse();
    last_covariance_ = *tracked.motion_covariance;
  } else {
    last_covariance_ = Matrix6d::Zero();
  }
  world_from_registered_ = registered;
}

// Frame indices are converted to seconds by their mean rate.
double Tracker::ModelAge(const RgbdFrame& frame) {
  if (!first_frame_) first_frame_ = {frame.index, frame.stamp_s};
  const double first_seen = views_->View().mean_first_seen;
  const int frames = frame.index - first_frame_->index;
  if (options_.IsFrameToFrame() || first_seen < 0 || frames <= 0) return 0;
  const double seconds = frame.stamp_s - first_frame_->stamp_s;
  return std::clamp((frame.index - first_seen) / frames, 0., 1.) * seconds;
}

}  // namespace surfit
