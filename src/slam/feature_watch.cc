#include "slam/feature_watch.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace surfit {
namespace {

constexpr int kMostColumns = 400, kMostFeatures = 500;
// A feature has moved as the poses say within so much beyond its own error, and what the camera
// moves in the time between depth and colour, or while rows are read out.
constexpr double kTogether_m = 0.03, kSigmas = 3, kBetweenImages_s = 0.03;
// Of features that look alike and are not the same, so many agree on a motion by chance; fewer if
// they are no small part.
constexpr int kLeastApart = 12, kLeastOfMost = 7;
constexpr double kLeastShare = 0.25, kMost = 0.5;
constexpr int kTries = 400;

// In the beginning, later, and the most between two frames that are compared.
constexpr double kBetween_s = 0.5, kMostBetween_s = 8, kShareOfTime = 0.25, kComparable_s = 1;
constexpr double kSlack_s = 0.005;

// How far a point of the camera's frame goes there meanwhile.
double Way(const CameraMotion& motion, const Eigen::Vector3d& point) {
  return kBetweenImages_s *
         (motion.velocity_m_per_s.norm() + motion.turn_rad_per_s.norm() * point.norm());
}

bool HasMovedAsPosed(const PosedFeatures& source, const PosedFeatures& target,
                     const Rigid3d& target_from_source, const FeatureMatch& match) {
  const Eigen::Vector3d& from = source.features.points[match.source];
  const Eigen::Vector3d& to = target.features.points[match.target];
  const double sigma_m =
      std::hypot(source.features.sigmas_m[match.source], target.features.sigmas_m[match.target]);
  const double bound_m =
      kTogether_m + kSigmas * sigma_m + Way(source.motion, from) + Way(target.motion, to);
  return (target_from_source * from - to).norm() < bound_m;
}

// The mean of each block of pixels.
Image<Rgb8> Reduced(const Image<Rgb8>& color, int step) {
  if (step == 1) return color;
  Image<Rgb8> small(color.width() / step, color.height() / step);
  const int count = step * step;
  for (int v = 0; v < small.height(); ++v) {
    for (int u = 0; u < small.width(); ++u) {
      Eigen::Vector3i sum = Eigen::Vector3i::Constant(count / 2);
      for (int i = 0; i < count; ++i) {
        const Rgb8 pixel = color(u * step + i % step, v * step + i / step);
        sum += Eigen::Vector3i(pixel.r, pixel.g, pixel.b);
      }
      const auto mean = [&](int k) { return static_cast<std::uint8_t>(sum[k] / count); };
      small(u, v) = {mean(0), mean(1), mean(2)};
    }
  }
  return small;
}

}  // namespace

bool FeatureMotion::IsApart() const {
  const int all = as_posed + apart;
  return (apart >= kLeastApart && apart >= kLeastShare * all) ||
         (apart >= kLeastOfMost && apart >= kMost * all);
}

FeaturePoints FeaturesAtRest(const ColoredView& view, const CellMask& moving,
                             const ErrorModel& error_model) {
  if (view.color.empty()) return {};
  const std::vector<FrameLevel>& levels = view.pyramid.levels;
  const auto small = std::find_if(levels.begin(), levels.end(), [](const FrameLevel& level) {
    return level.camera.width <= kMostColumns;
  });
  const FrameLevel& level = small != levels.end() ? *small : levels.back();
  const FramePyramid at_rest = Without(FramePyramid{{level}}, moving);
  return FindFeatures(Reduced(view.color, view.color.width() / level.camera.width),
                      at_rest.levels.front(), error_model, kMostFeatures);
}

FeatureMotion CompareFeatures(const PosedFeatures& source, const PosedFeatures& target) {
  const Rigid3d target_from_source = target.world_from_camera.Inverse() * source.world_from_camera;
  FeatureMotion motion;
  std::vector<FeatureMatch> others;
  for (const FeatureMatch& match : MatchFeatures(source.features, target.features)) {
    if (HasMovedAsPosed(source, target, target_from_source, match)) {
      ++motion.as_posed;
    } else {
      others.push_back(match);
    }
  }
  const std::vector<Consensus> found =
      FindConsensus(source.features, target.features, others, 1, kTries);
  if (!found.empty()) motion.apart = static_cast<int>(found.front().inliers.size());
  return motion;
}

FeatureMotion FeatureWatch::Check(PosedFeatures frame, double stamp_s) {
  if (!last_) begin_s_ = stamp_s;
  const bool is_comparable = last_ && stamp_s <= last_s_ + kComparable_s;
  FeatureMotion motion;
  if (is_comparable) motion = CompareFeatures(frame, *last_);
  was_apart_ = motion.IsRefuted();
  if (was_apart_) return motion;
  const double later_s =
      std::clamp((stamp_s - begin_s_) * kShareOfTime, kBetween_s, kMostBetween_s);
  due_s_ = stamp_s + (is_comparable ? later_s : kBetween_s) - kSlack_s;
  last_ = std::move(frame);
  last_s_ = stamp_s;
  return motion;
}

void FeatureWatch::Move(const Rigid3d& new_from_old_world) {
  if (last_) last_->world_from_camera = new_from_old_world * last_->world_from_camera;
}

}  // namespace surfit
