#include "tracking/feature_watch.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "core/median.h"

namespace surfit {
namespace {

constexpr int kMaxColumns = 400, kMaxCorners = 250;
// A feature agrees with the poses within kTogether_m + kSigmas * error + camera motion in
// kBetweenImages_s. This time covers the readout and the delay between depth and colour.
constexpr double kPlaceSigma_px = 0.5;  // error of a tracked corner
constexpr double kTogether_m = 0.03, kSigmas = 3, kBetweenImages_s = 0.03;
// Minimum support of a second motion: kMinApart features and kLeastRatio of all features, or
// kMinOfMost features and kMost.
constexpr int kMinApart = 12, kMinOfMost = 7;
constexpr double kLeastRatio = 0.25, kMost = 0.5;
constexpr int kTries = 400;

// The check interval is kShareOfTime of the elapsed time, in [kBetween_s, kMaxBetween_s]. Frames
// are compared if they are at most kComparable_s apart.
constexpr double kBetween_s = 0.5, kMaxBetween_s = 8, kShareOfTime = 0.25, kComparable_s = 1;
constexpr double kSlack_s = 0.005;

// Bound on the motion of a point between depth and colour image, m. `point` is in camera
// coordinates.
double Way(const CameraMotion& motion, const Eigen::Vector3d& point) {
  return kBetweenImages_s *
         (motion.velocity_m_per_s.norm() + motion.angular_velocity_rad_per_s.norm() * point.norm());
}

Image<Rgb8> Reduced(const Image<Rgb8>& color, int step) {
  if (step == 1) return color;
  Image<Rgb8> small(color.width() / step, color.height() / step);
  const cv::Mat all(color.height(), color.width(), CV_8UC3, const_cast<Rgb8*>(color.data()));
  cv::Mat means(small.height(), small.width(), CV_8UC3, small.data());
  cv::resize(all(cv::Rect(cv::Point(), means.size() * step)), means, means.size(), 0, 0,
             cv::INTER_AREA);
  return small;
}

FrameLevel WithoutMovingObjects(const FrameLevel& level, const CellMask& moving) {
  return std::move(Without(FramePyramid{{level}}, moving).levels.front());
}

// Pixel of a point relative to the principal point, px.
Eigen::Vector2d OffsetOf(const Eigen::Vector3d& point, const PinholeCamera& camera) {
  return {camera.fx * point.x() / point.z(), camera.fy * point.y() / point.z()};
}

// Returns false without depth.
bool AddPoint(const FrameLevel& surface, const Eigen::Vector2f& at, const ErrorModel& error_model,
              FeaturePoints* points) {
  const double depth_m = DepthOfFeature(surface.vertex.z, at.x(), at.y());
  if (!(depth_m > 0)) return false;
  points->points.emplace_back(surface.camera.Ray(at.x(), at.y()) * depth_m);
  points->sigmas_m.push_back(
      SigmaOfFeature(depth_m, kPlaceSigma_px, surface.sensor(), error_model));
  return true;
}

}  // namespace

const FrameLevel& SmallLevel(const FramePyramid& pyramid) {
  const std::vector<FrameLevel>& levels = pyramid.levels;
  const auto small = std::find_if(levels.begin(), levels.end(), [](const FrameLevel& level) {
    return level.camera.width <= kMaxColumns;
  });
  return small != levels.end() ? *small : levels.back();
}

GreyPyramid GreyOf(const ColoredView& view) {
  return MakeGreyPyramid(
      Reduced(view.color, view.color.width() / SmallLevel(view.pyramid).camera.width));
}

bool FeatureMotion::HasTwoMotions() const {
  const int all = consistent_count + apart;
  return (apart >= kMinApart && apart >= kLeastRatio * all) ||
         (apart >= kMinOfMost && apart >= kMost * all);
}

FeatureMotion CompareMotions(const FeaturePoints& source, const MovingPose& source_frame,
                             const FeaturePoints& target, const MovingPose& target_frame) {
  const Rigid3d target_from_source =
      target_frame.world_from_camera.Inverse() * source_frame.world_from_camera;
  FeatureMotion motion;
  std::vector<FeatureMatch> others;
  std::vector<double> depths_as_posed, depths_apart;
  for (int i = 0; i < source.size(); ++i) {
    const Eigen::Vector3d &from = source.points[i], &to = target.points[i];
    const double bound_m = kTogether_m +
                           kSigmas * std::hypot(source.sigmas_m[i], target.sigmas_m[i]) +
                           Way(source_frame.motion, from) + Way(target_frame.motion, to);
    if ((target_from_source * from - to).norm() < bound_m) {
      ++motion.consistent_count;
      depths_as_posed.push_back(to.z());
    } else {
      others.push_back({i, i});
    }
  }
  const std::vector<Consensus> apart = FindConsensus(source, target, others, 1, kTries);
  if (apart.empty()) return motion;
  for (const int i : apart.front().inliers) {
    depths_apart.push_back(target.points[others[i].target].z());
  }
  motion.apart = static_cast<int>(depths_apart.size());
  motion.is_second_behind =
      !depths_as_posed.empty() && MedianOf(depths_apart) > MedianOf(depths_as_posed);
  return motion;
}

void FeatureWatch::Follow(const ColoredView& view, const std::optional<Rigid3d>& world_from_camera,
                          double stamp_s) {
  if (!last_ || stamp_s > last_s_ + kComparable_s || view.color.empty()) {
    tracks_ = {};
    return;
  }
  const PinholeCamera& camera = SmallLevel(view.pyramid).camera;
  const Rigid3d world_from_next = world_from_camera.value_or(world_from_followed_);
  const auto pixel_from = [&](const Rigid3d& world_from_here) {
    const Rigid3d here_from_first = world_from_here.Inverse() * last_->world_from_camera;
    return [here_from_first, camera](const Eigen::Vector3d& point) {
      return OffsetOf(here_from_first * point, camera);
    };
  };
  const auto before = pixel_from(world_from_followed_), after = pixel_from(world_from_next);
  tracks_.Follow(GreyOf(view), [&](const CornerTracks::Track& track) {
    const Eigen::Vector3d& point = points_.points[track.corner];
    const Eigen::Vector2f way = (after(point) - before(point)).cast<float>();
    return Eigen::Vector2f(track.last + (way.allFinite() ? way : Eigen::Vector2f::Zero()));
  });
  world_from_followed_ = world_from_next;
}

FeatureMotion FeatureWatch::Compare(const FrameLevel& surface, const MovingPose& frame) const {
  const Rigid3d here_from_first = frame.world_from_camera.Inverse() * last_->world_from_camera;
  const auto expected = [&](const CornerTracks::Track& track) {
    const Eigen::Vector3d here = here_from_first * points_.points[track.corner];
    const Eigen::Vector2d centre(surface.camera.cx, surface.camera.cy);
    return Eigen::Vector2f((OffsetOf(here, surface.camera) + centre).cast<float>());
  };
  FeaturePoints source, target;
  for (const CornerTracks::Track& track : tracks_.Lasting(expected)) {
    if (!AddPoint(surface, track.last, error_model_, &target)) continue;
    source.points.push_back(points_.points[track.corner]);
    source.sigmas_m.push_back(points_.sigmas_m[track.corner]);
  }
  return CompareMotions(source, *last_, target, frame);
}

void FeatureWatch::Begin(const ColoredView& view, const FrameLevel& surface) {
  points_ = {};
  tracks_ = {};
  if (view.color.empty()) return;
  GreyPyramid grey = GreyOf(view);
  std::vector<Eigen::Vector2f> corners;
  for (const Eigen::Vector2f& corner : FindCorners(grey, surface.vertex.z, kMaxCorners)) {
    if (AddPoint(surface, corner, error_model_, &points_)) corners.push_back(corner);
  }
  tracks_ = CornerTracks(std::move(grey), std::move(corners));
}

FeatureMotion FeatureWatch::Check(const ColoredView& view, const CellMask& moving,
                                  const MovingPose& frame, double stamp_s) {
  if (!last_) begin_s_ = stamp_s;
  const FrameLevel surface = WithoutMovingObjects(SmallLevel(view.pyramid), moving);
  const bool is_comparable = last_ && stamp_s <= last_s_ + kComparable_s;
  FeatureMotion motion;
  if (is_comparable) motion = Compare(surface, frame);
  was_apart_ = motion.IsRejected();
  if (was_apart_) return motion;
  const double later_s = std::clamp((stamp_s - begin_s_) * kShareOfTime, kBetween_s, kMaxBetween_s);
  due_s_ = stamp_s + (is_comparable ? later_s : kBetween_s) - kSlack_s;
  last_ = frame;
  last_s_ = stamp_s;
  world_from_followed_ = frame.world_from_camera;
  Begin(view, surface);
  return motion;
}

void FeatureWatch::Forget() {
  last_.reset();
  tracks_ = {};
  was_apart_ = false;
}

void FeatureWatch::Move(const Rigid3d& new_from_old_world) {
  if (last_) last_->world_from_camera = new_from_old_world * last_->world_from_camera;
  world_from_followed_ = new_from_old_world * world_from_followed_;
}

}  // namespace surfit
