#include "tracking/moving_regions.h"

#include <algorithm>
#include <cmath>

namespace surfit {
namespace {

constexpr int kMargin = 3;  // of a moving region, in cells

// Views are stored every 0.2 s, for 10 s. An object that rests longer becomes a part of the
// scene.
constexpr double kBetweenViews_s = 0.2;
constexpr std::size_t kMaxPastViews = 50;
// Minimum size of a region as a ratio of all cells. Smaller regions are noise at edges.
constexpr double kLeastMovingRatio = 0.01;
// Minimum ratio of a moving region that an earlier view observed as free space, or that moved in
// the last frame.
constexpr double kMinSeenThrough = 0.5, kMinMoved = 0.3;
// Minimum distance of a free-space violation from the observed depth, as in Fusion.
constexpr double kMargin_m = 0.05, kMarginSigmas = 4;

// Returns whether a cell and most of its neighbours are in front of the model. Excludes thin
// lines of cells at depth edges.
bool IsCore(const Image<Side>& sides, int u, int v) {
  constexpr int kMinNeighbours = 6;
  if (u < 1 || v < 1 || u + 1 >= sides.width() || v + 1 >= sides.height()) return false;
  int count = 0;
  for (int dv = -1; dv <= 1; ++dv) {
    for (int du = -1; du <= 1; ++du) count += sides(u + du, v + dv) == Side::kInFront;
  }
  return sides(u, v) == Side::kInFront && count > kMinNeighbours;
}

// Returns the connected region of a cell: neighbours with a similar depth. Removes the region
// from `left`.
std::vector<int> Grow(int first, const FrameLevel& frame, CellMask* left) {
  constexpr float kSamePart = 0.04f;  // of the depth
  const ViewGrid grid(frame.camera);
  const auto depth_m = [&](int cell) {
    return frame.vertex.z(grid.Pixel(cell % grid.width), grid.Pixel(cell / grid.width));
  };
  std::vector<int> cells = {first};
  (*left)[first] = kNotMoving;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const int cell = cells[i], u = cell % grid.width;
    const auto take = [&](int next) {
      if (next < 0 || next >= static_cast<int>(left->size()) || (*left)[next] == kNotMoving) return;
      if (std::abs(depth_m(next) - depth_m(cell)) > kSamePart * depth_m(cell)) return;
      (*left)[next] = kNotMoving;
      cells.push_back(next);
    };
    take(cell - grid.width);
    take(cell + grid.width);
    if (u > 0) take(cell - 1);
    if (u + 1 < grid.width) take(cell + 1);
  }
  return cells;
}

bool IsMasked(const CellMask& mask, double scale, int u, int v) {
  const int x = std::min(mask.width() - 1, static_cast<int>(u * scale));
  const int y = std::min(mask.height() - 1, static_cast<int>(v * scale));
  return mask(x, y) != 0;
}

struct FreeSpaceCount {
  int seen = 0;     // visible and not occluded
  int through = 0;  // observed as free space
};

}  // namespace

Image<float> DepthOfCells(const FrameLevel& frame) {
  const ViewGrid grid(frame.camera);
  Image<float> depth_m(grid.width, grid.height);
  for (int v = 0; v < grid.height; ++v) {
    for (int u = 0; u < grid.width; ++u) {
      depth_m(u, v) = frame.vertex.z(grid.Pixel(u), grid.Pixel(v));
    }
  }
  return depth_m;
}

void MarkMoving(const std::vector<int>& cells, const CellMask& kinds, int margin,
                CellMask* moving) {
  const int width = moving->width(), height = moving->height();
  for (const int cell : cells) {
    const int u = cell % width, v = cell / width;
    for (int y = std::max(0, v - margin); y <= std::min(height - 1, v + margin); ++y) {
      for (int x = std::max(0, u - margin); x <= std::min(width - 1, u + margin); ++x) {
        (*moving)(x, y) = std::max((*moving)(x, y), static_cast<std::uint8_t>(kMovingMargin));
      }
    }
    (*moving)[cell] = std::max((*moving)[cell], kinds[cell]);
  }
}

double AddMoving(const FrameLevel& frame, const CellMask& more, CellMask* moving) {
  if (moving->empty()) *moving = CellMask(more.width(), more.height(), kNotMoving);
  for (std::size_t i = 0; i < more.size(); ++i) (*moving)[i] = std::max((*moving)[i], more[i]);
  const Image<float> depth_m = DepthOfCells(frame);
  int all = 0, count = 0;
  for (std::size_t i = 0; i < depth_m.size(); ++i) {
    all += depth_m[i] > 0;
    count += depth_m[i] > 0 && (*moving)[i] != kNotMoving;
  }
  return all > 0 ? static_cast<double>(count) / all : 0;
}

struct MovingRegions::PastView {
  double stamp_s = 0;
  Rigid3d world_from_camera;
  PinholeCamera camera;
  DepthNoise noise;
  Image<float> depth_m;
  CellMask moving;  // empty except in `last_`

  // Returns the cell of a point of the camera frame, or -1.
  int CellOf(const Eigen::Vector3d& point) const {
    return point.z() > 0 ? ViewGrid(camera).CellOf(camera.Project(point)) : -1;
  }

  double Margin(double depth) const { return kMargin_m + kMarginSigmas * noise.SigmaZ(depth); }

  FreeSpaceCount Count(const std::vector<Eigen::Vector3d>& points_in_world) const {
    FreeSpaceCount count;
    const Rigid3d camera_from_world = world_from_camera.Inverse();
    for (const Eigen::Vector3d& point_in_world : points_in_world) {
      const Eigen::Vector3d point = camera_from_world * point_in_world;
      const int cell = CellOf(point);
      if (cell < 0) continue;
      const double depth = depth_m[cell], margin_m = Margin(depth);
      count.seen += depth > point.z() - margin_m;
      count.through += depth > point.z() + margin_m;
    }
    return count;
  }
};

MovingRegions::MovingRegions() = default;
MovingRegions::~MovingRegions() = default;

CellMask MovingRegions::Find(const FrameLevel& frame, const ViewComparison& comparison,
                             const Rigid3d& world_from_camera, double stamp_s) const {
  const Image<Side>& sides = comparison.sides;
  const CellMask moved = MovedBefore(frame, sides, world_from_camera, stamp_s);
  CellMask kinds(sides.width(), sides.height(), kNotMoving);
  for (int v = 0; v < sides.height(); ++v) {
    for (int u = 0; u < sides.width(); ++u) {
      if (sides(u, v) == Side::kInFront || sides(u, v) == Side::kUnknown)
        kinds(u, v) = kMovingMargin;
      const bool has_moved = !moved.empty() && moved(u, v) != kNotMoving;
      if (has_moved || IsCore(sides, u, v)) kinds(u, v) = kMovingCore;
    }
  }
  CellMask left = kinds, moving;
  for (int i = 0; i < static_cast<int>(left.size()); ++i) {
    if (left[i] != kMovingCore) continue;
    std::vector<int> cells = Grow(i, frame, &left);
    if (!Moves(cells, frame, kinds, moved, world_from_camera)) continue;
    RemoveStaticCells(frame, sides, world_from_camera, &cells);
    if (moving.empty()) moving = CellMask(sides.width(), sides.height(), kNotMoving);
    MarkMoving(cells, kinds, kMargin, &moving);
  }
  return moving;
}

bool MovingRegions::Moves(const std::vector<int>& cells, const FrameLevel& frame,
                          const CellMask& kinds, const CellMask& moved,
                          const Rigid3d& world_from_camera) const {
  const ViewGrid grid(frame.camera);
  const auto size = static_cast<double>(cells.size());
  if (size < kLeastMovingRatio * grid.width * grid.height) return false;
  std::vector<Eigen::Vector3d> points_in_world;
  int moved_count = 0, core_count = 0;
  for (const int cell : cells) {
    const int u = grid.Pixel(cell % grid.width), v = grid.Pixel(cell / grid.width);
    points_in_world.push_back(world_from_camera * frame.vertex(u, v).cast<double>());
    moved_count += !moved.empty() && moved[cell] != kNotMoving;
    core_count += kinds[cell] == kMovingCore;
  }
  if (moved_count >= kMinMoved * core_count) return true;
  return std::any_of(past_views_.begin(), past_views_.end(), [&](const PastView& past_view) {
    const FreeSpaceCount count = past_view.Count(points_in_world);
    return count.through >= kLeastMovingRatio * grid.width * grid.height &&
           count.through >= kMinSeenThrough * count.seen;
  });
}

// Includes cells without a model surface, because a moving object can enter them.
CellMask MovingRegions::MovedBefore(const FrameLevel& frame, const Image<Side>& sides,
                                    const Rigid3d& world_from_camera, double stamp_s) const {
  constexpr double kSameThing_m = 0.15, kMost_m = 0.45, kMetresPerSecond = 1.5;
  if (!last_) return {};
  const double same_m =
      std::clamp(kMetresPerSecond * (stamp_s - last_->stamp_s), kSameThing_m, kMost_m);
  const ViewGrid grid(frame.camera);
  const Rigid3d last_from_now = last_->world_from_camera.Inverse() * world_from_camera;
  CellMask moved(grid.width, grid.height, kNotMoving);
  for (int v = 0; v < grid.height; ++v) {
    for (int u = 0; u < grid.width; ++u) {
      if (sides(u, v) != Side::kInFront && sides(u, v) != Side::kUnknown) continue;
      const Eigen::Vector3d point =
          last_from_now * frame.vertex(grid.Pixel(u), grid.Pixel(v)).cast<double>();
      const int cell = last_->CellOf(point);
      if (cell < 0 || last_->moving[cell] == kNotMoving) continue;
      if (std::abs(last_->depth_m[cell] - point.z()) > same_m) continue;
      moved(u, v) = kMovingCore;
    }
  }
  return moved;
}

// Removes cells without a model surface if the second to last stored view shows the same surface
// there.
void MovingRegions::RemoveStaticCells(const FrameLevel& frame, const Image<Side>& sides,
                                      const Rigid3d& world_from_camera,
                                      std::vector<int>* cells) const {
  constexpr double kSame_m = 0.015, kSameSigmas = 3, kResting = 0.8, kMinSeen = 0.2;
  if (past_views_.size() < 2) return;
  const PastView& past_view = *(past_views_.rbegin() + 1);
  const ViewGrid grid(frame.camera);
  const Rigid3d past_from_now = past_view.world_from_camera.Inverse() * world_from_camera;
  int unknown = 0, seen = 0, resting = 0;
  for (const int cell : *cells) {
    if (sides[cell] != Side::kUnknown) continue;
    ++unknown;
    const int u = grid.Pixel(cell % grid.width), v = grid.Pixel(cell / grid.width);
    const Eigen::Vector3d point = past_from_now * frame.vertex(u, v).cast<double>();
    const int there = past_view.CellOf(point);
    if (there < 0 || !(past_view.depth_m[there] > 0)) continue;
    const double margin_m = kSame_m + kSameSigmas * past_view.noise.SigmaZ(point.z());
    ++seen;
    resting += std::abs(past_view.depth_m[there] - point.z()) < margin_m;
  }
  if (seen < kMinSeen * unknown || resting < kResting * seen) return;
  const auto is_unknown = [&](int cell) { return sides[cell] == Side::kUnknown; };
  cells->erase(std::remove_if(cells->begin(), cells->end(), is_unknown), cells->end());
}

void MovingRegions::Remember(const FrameLevel& frame, const CellMask& moving,
                             const Rigid3d& world_from_camera, double stamp_s) {
  const bool is_due =
      past_views_.empty() || stamp_s >= past_views_.back().stamp_s + kBetweenViews_s;
  last_.reset();
  followed_.reset();
  if (!is_due && moving.empty()) return;
  PastView past_view = {stamp_s,     world_from_camera,   frame.camera,
                        frame.noise, DepthOfCells(frame), {}};
  if (!moving.empty()) {
    last_ = std::make_unique<PastView>(past_view);
    last_->moving = moving;
  }
  if (!is_due) return;
  if (past_views_.size() == kMaxPastViews) past_views_.pop_front();
  past_views_.push_back(std::move(past_view));
}

void MovingRegions::Follow(const FrameLevel& frame) {
  constexpr int kReach = 3;             // cells per frame
  constexpr float kSameObject = 0.04f;  // of the depth
  const PastView* earlier = followed_ ? followed_.get() : last_.get();
  if (!earlier) return;
  auto now = std::make_unique<PastView>();
  now->depth_m = DepthOfCells(frame);
  const int width = now->depth_m.width(), height = now->depth_m.height();
  now->moving = CellMask(width, height, kNotMoving);
  // The object enters a cell whose depth changes. Static surfaces beside the object keep their
  // depth between two frames.
  const auto is_object = [&](int u, int v, float depth_m) {
    const float before_m = earlier->depth_m(u, v);
    const bool is_same = std::abs(before_m - depth_m) <= kSameObject * depth_m;
    if (is_same) return earlier->moving(u, v) == kMovingCore;
    for (int y = std::max(0, v - kReach); y <= std::min(height - 1, v + kReach); ++y) {
      for (int x = std::max(0, u - kReach); x <= std::min(width - 1, u + kReach); ++x) {
        if (earlier->moving(x, y) != kMovingCore) continue;
        if (std::abs(earlier->depth_m(x, y) - depth_m) <= kSameObject * depth_m) return true;
      }
    }
    return false;
  };
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const float depth_m = now->depth_m(u, v);
      if (depth_m > 0 && is_object(u, v, depth_m)) now->moving(u, v) = kMovingCore;
    }
  }
  followed_ = std::move(now);
}

CellMask MovingRegions::Followed() const {
  if (!followed_) return {};
  const CellMask& core = followed_->moving;
  std::vector<int> cells;
  for (int i = 0; i < static_cast<int>(core.size()); ++i) {
    if (core[i] == kMovingCore) cells.push_back(i);
  }
  if (cells.empty()) return {};
  CellMask moving(core.width(), core.height(), kNotMoving);
  MarkMoving(cells, core, kMargin, &moving);
  return moving;
}

void MovingRegions::Forget() {
  past_views_.clear();
  last_.reset();
  followed_.reset();
}

void MovingRegions::Move(const Rigid3d& new_from_old_world) {
  for (PastView& past_view : past_views_) {
    past_view.world_from_camera = new_from_old_world * past_view.world_from_camera;
  }
  if (last_) last_->world_from_camera = new_from_old_world * last_->world_from_camera;
}

Image<float> Without(Image<float> depth_m, const CellMask& moving) {
  if (moving.empty()) return depth_m;
  const double scale = static_cast<double>(moving.width()) / depth_m.width();
  for (int v = 0; v < depth_m.height(); ++v) {
    for (int u = 0; u < depth_m.width(); ++u) {
      if (IsMasked(moving, scale, u, v)) depth_m(u, v) = 0;
    }
  }
  return depth_m;
}

RgbdFrame Without(RgbdFrame frame, const CellMask& moving) {
  frame.depth_m = Without(std::move(frame.depth_m), moving);
  return frame;
}

FramePyramid Without(FramePyramid pyramid, const CellMask& moving) {
  if (moving.empty()) return pyramid;
  for (FrameLevel& level : pyramid.levels) {
    const double scale = static_cast<double>(moving.width()) / level.vertex.width();
    for (int v = 0; v < level.vertex.height(); ++v) {
      for (int u = 0; u < level.vertex.width(); ++u) {
        if (!IsMasked(moving, scale, u, v)) continue;
        level.vertex.Set(u, v, Eigen::Vector3f::Zero());
        level.normal.Set(u, v, Eigen::Vector3f::Zero());
      }
    }
  }
  return pyramid;
}

}  // namespace surfit
