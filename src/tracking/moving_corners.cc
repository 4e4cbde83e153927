#include "tracking/moving_corners.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/median.h"
#include "tracking/feature_watch.h"

namespace surfit {
namespace {

constexpr int kMaxMotionCorners = 400;
// The corners are renewed after this time. Slow objects need it, and deforming objects lose their
// corners during it.
constexpr double kRenew_s = 0.095;
constexpr double kWatch_s = 2;
// Maximum time between two frames.
constexpr double kMaxStep_s = 0.25;
// Minimum width of the image. Corners of smaller images are inaccurate.
constexpr int kMinColumns = 240;
// Maximum median motion of the corners since the first frame, as a ratio of the image width.
// Corners are confused in faster motion.
constexpr double kMaxMedianShift = 0.06;

// Moving objects are excluded for this time after a pose contradicts the static corners.
constexpr double kContradicted_s = 1;

// Minimum size of a moving object: ratio of all cells, and corners.
constexpr double kMinObject = 0.01;
constexpr int kMinObjectCorners = 6;
// Connected cells have similar depths.
constexpr float kConnected = 0.03f;
constexpr int kMarginCells = 2;
// Corners at depth edges have the depth of either side.
constexpr int kEdgeReach_px = 2;
constexpr float kMaxEdgeDepth = 0.06f;

using Label = CornerMotion::Label;

double MedianShift(const std::vector<TrackedCorner>& corners) {
  std::vector<double> shifts;
  shifts.reserve(corners.size());
  for (const TrackedCorner& corner : corners) shifts.push_back((corner.seen - corner.first).norm());
  return MedianOf(std::move(shifts));
}

bool IsAtEdge(const Image<float>& depth_m, const Eigen::Vector2d& at, double z) {
  const int u = static_cast<int>(std::lround(at.x())), v = static_cast<int>(std::lround(at.y()));
  for (int y = std::max(0, v - kEdgeReach_px);
       y <= std::min(depth_m.height() - 1, v + kEdgeReach_px); ++y) {
    for (int x = std::max(0, u - kEdgeReach_px);
         x <= std::min(depth_m.width() - 1, u + kEdgeReach_px); ++x) {
      if (depth_m(x, y) > 0 && std::abs(depth_m(x, y) - z) > kMaxEdgeDepth * z) return true;
    }
  }
  return false;
}

// Cell of a pixel of an image that is smaller by `scale`, or -1.
int CellOfSmall(const Eigen::Vector2d& pixel, double scale, const ViewGrid& grid) {
  const Eigen::Vector2d half(0.5, 0.5);
  return grid.CellOf(scale * (pixel + half) - half);
}

// Cells 4-connected to `cell`, with similar depth.
template <typename Visit>
void ForConnected(const Image<float>& depth_m, int cell, const Visit& visit) {
  const int width = depth_m.width(), u = cell % width;
  const auto take = [&](int next) {
    if (next < 0 || next >= static_cast<int>(depth_m.size()) || !(depth_m[next] > 0)) return;
    if (std::abs(depth_m[next] - depth_m[cell]) > kConnected * depth_m[cell]) return;
    visit(next);
  };
  take(cell - width);
  take(cell + width);
  if (u > 0) take(cell - 1);
  if (u + 1 < width) take(cell + 1);
}

}  // namespace

void MovingCorners::Watch(double stamp_s) { watched_until_s_ = stamp_s + kWatch_s; }

void MovingCorners::Follow(const ColoredView& view, double stamp_s) {
  is_followed_ = stamp_s <= watched_until_s_;
  if (!is_followed_) return;
  const bool follows = window_ && stamp_s > last_s_ && stamp_s <= last_s_ + kMaxStep_s;
  last_s_ = stamp_s;
  corners_.clear();
  motion_ = {};
  moving_ = {};
  next_.reset();
  camera_ = SmallLevel(view.pyramid).camera;
  if (view.color.empty() || camera_.width < kMinColumns) {
    window_.reset();
    return;
  }
  GreyPyramid grey = GreyOf(view);
  if (follows) Compare(view, grey);
  const bool is_compared = !motion_.labels.empty();
  if (!is_compared) step_ = Rigid3d();
  if (!is_compared || stamp_s - window_->first_s > kRenew_s) {
    next_ = Begun(view, std::move(grey), stamp_s);
  }
}

void MovingCorners::Compare(const ColoredView& view, const GreyPyramid& grey) {
  const Rigid3d expected = step_ * window_->now_from_first;
  window_->tracks.Follow(grey, [&](const CornerTracks::Track& track) -> Eigen::Vector2f {
    const Eigen::Vector3d& point = window_->points[track.corner];
    const Eigen::Vector2d shift =
        camera_.Project(expected * point) - camera_.Project(window_->now_from_first * point);
    return track.last + (shift.allFinite() ? shift.cast<float>() : Eigen::Vector2f(0, 0));
  });
  for (const CornerTracks::Track& track : window_->tracks.tracks()) {
    corners_.push_back({window_->points[track.corner], track.first.cast<double>(),
                        track.last.cast<double>(), window_->moved_before[track.corner]});
  }
  if (corners_.empty() || MedianShift(corners_) > kMaxMedianShift * camera_.width) return;
  motion_ = FindStaticMotion(corners_, camera_, expected);
  if (motion_.labels.empty()) return;
  step_ = motion_.now_from_before * window_->now_from_first.Inverse();
  window_->now_from_first = motion_.now_from_before;
  for (std::size_t i = 0; i < corners_.size(); ++i) {
    const bool is_open = window_->is_young || motion_.labels[i] == Label::kUnknown;
    if (is_open && corners_[i].moved_before) motion_.labels[i] = Label::kMoving;
  }
  window_->is_young = false;
  moving_ = MovingCells(view);
}

CellMask MovingCorners::Contradicting(const std::optional<Rigid3d>& world_from_camera) {
  if (!is_followed_) return {};
  if (!moving_.empty() && motion_.is_certain && world_from_camera && window_->world_from_first &&
      ContradictsStaticCorners(corners_, motion_, camera_,
                               world_from_camera->Inverse() * *window_->world_from_first)) {
    contradicted_until_s_ = last_s_ + kContradicted_s;
  }
  return last_s_ < contradicted_until_s_ ? moving_ : CellMask();
}

void MovingCorners::Remember(const std::optional<Rigid3d>& world_from_camera) {
  if (!is_followed_ || !next_) return;
  window_ = std::exchange(next_, std::nullopt);
  window_->world_from_first = world_from_camera;
}

void MovingCorners::Forget() {
  if (window_) window_->world_from_first.reset();
}

void MovingCorners::Move(const Rigid3d& new_from_old_world) {
  if (!window_ || !window_->world_from_first) return;
  window_->world_from_first = new_from_old_world * *window_->world_from_first;
}

MovingCorners::Window MovingCorners::Begun(const ColoredView& view, GreyPyramid grey,
                                           double stamp_s) const {
  const FrameLevel& small = SmallLevel(view.pyramid);
  const PinholeCamera& fine = view.pyramid.levels.front().camera;
  const ViewGrid grid(fine);
  const double scale = static_cast<double>(fine.width) / small.camera.width;
  Window window;
  window.first_s = stamp_s;
  std::vector<Eigen::Vector2f> corners;
  for (const Eigen::Vector2f& corner : FindCorners(grey, small.vertex.z, kMaxMotionCorners)) {
    const double depth_m = DepthOfFeature(small.vertex.z, corner.x(), corner.y());
    if (!(depth_m > 0)) continue;
    if (IsAtEdge(small.vertex.z, corner.cast<double>(), depth_m)) continue;
    corners.push_back(corner);
    window.points.emplace_back(small.camera.Ray(corner.x(), corner.y()) * depth_m);
    const int cell = CellOfSmall(corner.cast<double>(), scale, grid);
    window.moved_before.push_back(!moving_.empty() && cell >= 0 && moving_[cell] == kMovingCore);
  }
  window.tracks = CornerTracks(std::move(grey), std::move(corners));
  return window;
}

// Each cell gets the label of the nearest corner along cells of similar depth.
CellMask MovingCorners::MovingCells(const ColoredView& view) const {
  const FrameLevel& surface = view.pyramid.levels.front();
  const ViewGrid grid(surface.camera);
  const double scale =
      static_cast<double>(surface.camera.width) / SmallLevel(view.pyramid).camera.width;
  const Image<float> depth_m = DepthOfCells(surface);
  Image<Label> labels(grid.width, grid.height, Label::kUnknown);
  std::vector<int> queue;
  std::vector<int> corner_count(depth_m.size(), 0);
  for (std::size_t i = 0; i < corners_.size(); ++i) {
    const int cell = CellOfSmall(corners_[i].seen, scale, grid);
    if (cell < 0 || !(depth_m[cell] > 0) || motion_.labels[i] == Label::kUnknown) continue;
    corner_count[cell] += motion_.labels[i] == Label::kMoving;
    if (labels[cell] != Label::kUnknown) continue;
    labels[cell] = motion_.labels[i];
    queue.push_back(cell);
  }
  for (std::size_t i = 0; i < queue.size(); ++i) {
    ForConnected(depth_m, queue[i], [&](int next) {
      if (labels[next] != Label::kUnknown) return;
      labels[next] = labels[queue[i]];
      queue.push_back(next);
    });
  }
  CellMask moving;
  const CellMask core(grid.width, grid.height, kMovingCore);
  std::vector<bool> visited(depth_m.size(), false);
  for (int first = 0; first < static_cast<int>(depth_m.size()); ++first) {
    if (labels[first] != Label::kMoving || visited[first]) continue;
    std::vector<int> cells = {first};
    visited[first] = true;
    int count = 0;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      count += corner_count[cells[i]];
      ForConnected(depth_m, cells[i], [&](int next) {
        if (visited[next] || labels[next] != Label::kMoving) return;
        visited[next] = true;
        cells.push_back(next);
      });
    }
    if (count < kMinObjectCorners ||
        static_cast<double>(cells.size()) < kMinObject * grid.width * grid.height) {
      continue;
    }
    if (moving.empty()) moving = CellMask(grid.width, grid.height, kNotMoving);
    MarkMoving(cells, core, kMarginCells, &moving);
  }
  return moving;
}

}  // namespace surfit
