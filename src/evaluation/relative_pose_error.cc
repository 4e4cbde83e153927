#include "surfit/evaluation/relative_pose_error.h"

#include <algorithm>
#include <cmath>

#include "surfit/core/error.h"

namespace surfit {
namespace {

using Unit = RelativePoseErrorOptions::Unit;

constexpr double kDegreesPerRadian = 57.295779513082320877;
constexpr double kSecondsTolerance = 0.1;  // of delta

// The position of the pose whose stamp is nearest to stamp_s.
std::size_t FindNearest(const std::vector<MatchedPose>& poses, double stamp_s) {
  const auto after =
      std::lower_bound(poses.begin(), poses.end(), stamp_s,
                       [](const MatchedPose& pose, double stamp) { return pose.stamp_s < stamp; });
  if (after == poses.begin()) return 0;
  const auto before = after - 1;
  const bool take_before =
      after == poses.end() || stamp_s - before->stamp_s <= after->stamp_s - stamp_s;
  return (take_before ? before : after) - poses.begin();
}

// The partner of pose i, if it has one.
std::optional<std::size_t> FindPartner(const std::vector<MatchedPose>& poses, std::size_t i,
                                       const RelativePoseErrorOptions& options) {
  if (options.delta_unit == Unit::kFrames) {
    const std::size_t j = i + static_cast<std::size_t>(options.delta);
    return j < poses.size() ? std::make_optional(j) : std::nullopt;
  }
  const double wanted_s = poses[i].stamp_s + options.delta;
  const std::size_t j = FindNearest(poses, wanted_s);
  if (std::abs(poses[j].stamp_s - wanted_s) > kSecondsTolerance * options.delta) {
    return std::nullopt;
  }
  return j;
}

Rigid3d RelativeError(const MatchedPose& i, const MatchedPose& j) {
  const Rigid3d true_motion = i.ground_truth.Inverse() * j.ground_truth;
  const Rigid3d estimated_motion = i.estimate.Inverse() * j.estimate;
  return true_motion.Inverse() * estimated_motion;
}

}  // namespace

void RelativePoseErrorOptions::Validate() const {
  if (!(std::isfinite(delta) && delta > 0)) {
    throw InputError(Concat("delta is ", delta, ", must be finite and positive"));
  }
  if (delta_unit == Unit::kFrames && !(delta == std::floor(delta) && delta < 1e9)) {
    throw InputError(Concat("delta is ", delta, " frames, must be an integer below 1e9"));
  }
}

std::optional<RelativePoseError> ComputeRelativePoseError(const std::vector<MatchedPose>& poses,
                                                          const RelativePoseErrorOptions& options) {
  options.Validate();
  std::vector<double> translations_m, rotations_deg;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const auto j = FindPartner(poses, i, options);
    if (!j) continue;
    const Rigid3d error = RelativeError(poses[i], poses[*j]);
    translations_m.push_back(error.translation.norm());
    rotations_deg.push_back(RotationAngle(error.rotation) * kDegreesPerRadian);
  }
  if (translations_m.empty()) return std::nullopt;
  return RelativePoseError{Summarize(std::move(translations_m)),
                           Summarize(std::move(rotations_deg))};
}

}  // namespace surfit
