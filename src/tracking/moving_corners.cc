#include "tracking/moving_corners.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <random>
#include <utility>

#include "core/median.h"
#include "registration/solvers/decompositions.h"
#include "surfit/core/parallel.h"
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

// Bound on the reprojection error of a static corner: tracking error, and the effect of readout and
// motion blur, which grows with the image motion.
constexpr double kCornerSigma_px = 0.5, kBoundPerShift = 0.05;
// A corner moves if its error is larger than the bound by this factor.
constexpr double kMovingFactor = 2.5;
// A pose contradicts the static corners if this ratio of them is farther from their place than
// kApartFactor bounds. Moving objects are then excluded for kContradicted_s.
constexpr double kApartFactor = 1.5, kMinApartRatio = 0.5, kContradicted_s = 1;
constexpr int kSamples = 300, kMinSample = 3, kSampleSteps = 3, kRefineSteps = 6;
constexpr int kSamplesPerBlock = 25;
// A motion with more than this ratio of the corners is not compared with random samples.
constexpr double kClearRatio = 0.75;
// Minimum support of a motion: blocks of the image, and ratio of all blocks with corners.
constexpr double kMinBlocks = 10, kMinSupport = 0.15;
// Minimum support of a motion that contradicts a pose.
constexpr double kCertainSupport = 0.25;
constexpr int kBlocksAcross = 16;
// Weight of a corner on an object that moved before.
constexpr double kWeightMoved = 0.25;
// Minimum support of a background motion relative to a nearer motion.
constexpr double kMinBehind = 0.5;

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

double BoundOf(const TrackedCorner& corner) {
  return 2 * kCornerSigma_px + kBoundPerShift * (corner.seen - corner.first).norm();
}

// Returns whether enough corners agree on a second motion, see FeatureMotion::HasTwoMotions().
bool HasSecondMotion(std::size_t static_count, std::size_t second_count) {
  FeatureMotion motion;
  motion.consistent_count = static_cast<int>(static_count);
  motion.apart = static_cast<int>(second_count);
  return motion.HasTwoMotions();
}

// Rigid motion with the corners within the bound, and their support: sum of the truncated quadratic
// scores, in blocks of the image.
struct MotionSupport {
  Rigid3d motion;
  double support = 0;
  std::vector<int> corners;
};

// Reprojection errors of all corners.
class MotionSearch {
 public:
  MotionSearch(const std::vector<TrackedCorner>& corners, const PinholeCamera& camera)
      : corners_(corners), camera_(camera), weights_(corners.size()) {
    std::map<std::pair<int, int>, int> count_of_block;
    const double block = static_cast<double>(camera.width) / kBlocksAcross;
    const auto block_of = [&](const TrackedCorner& corner) {
      return std::make_pair(static_cast<int>(corner.first.x() / block),
                            static_cast<int>(corner.first.y() / block));
    };
    for (const TrackedCorner& corner : corners) ++count_of_block[block_of(corner)];
    for (std::size_t i = 0; i < corners.size(); ++i) {
      weights_[i] = 1. / count_of_block[block_of(corners[i])];
      if (corners[i].moved_before) weights_[i] *= kWeightMoved;
      bounds_.push_back(BoundOf(corners[i]));
    }
    block_count_ = static_cast<double>(count_of_block.size());
  }

  double block_count() const { return block_count_; }
  double weight(int corner) const { return weights_[corner]; }

  // In units of the bound of a static corner.
  double Error(int corner, const Rigid3d& motion) const {
    const Eigen::Vector3d point = motion * corners_[corner].point;
    if (!(point.z() > 0.05)) return std::numeric_limits<double>::infinity();
    return (camera_.Project(point) - corners_[corner].seen).norm() / bounds_[corner];
  }

  std::vector<int> Apart(const std::vector<int>& used, const Rigid3d& motion) const {
    std::vector<int> apart;
    std::copy_if(used.begin(), used.end(), std::back_inserter(apart),
                 [&](int i) { return Error(i, motion) > kMovingFactor; });
    return apart;
  }

  MotionSupport At(const std::vector<int>& used, const Rigid3d& motion) const {
    MotionSupport found = {motion, 0, {}};
    for (const int i : used) {
      const double error = Error(i, motion);
      if (!(error < 1)) continue;
      found.support += weights_[i] * (1 - error * error);
      found.corners.push_back(i);
    }
    return found;
  }

  // Returns the motion with the largest support among the corners `used`.
  MotionSupport Find(const std::vector<int>& used, const std::vector<Rigid3d>& initial) const {
    MotionSupport best = At(used, initial.front());
    const auto compare = [&](const Rigid3d& motion) {
      MotionSupport found = At(used, motion);
      if (found.support > best.support) best = std::move(found);
    };
    for (const Rigid3d& motion : initial) {
      compare(motion);
      compare(Refined(used, motion));
    }
    if (!IsClear(used, best)) {
      compare(BestSample(used, initial.front(), best.support));
      compare(Refined(used, best.motion));
    }
    return best;
  }

 private:
  // True if more than kClearRatio of the corners agree with the motion. No other motion has more.
  bool IsClear(const std::vector<int>& used, const MotionSupport& found) const {
    double all = 0, agreeing = 0;
    for (const int i : used) all += weights_[i];
    for (const int i : found.corners) agreeing += weights_[i];
    return agreeing > kClearRatio * all;
  }

  // Returns the motion with the largest support among those of random samples. Samples with less
  // support than `least` are not compared.
  Rigid3d BestSample(const std::vector<int>& used, const Rigid3d& initial, double least) const {
    std::mt19937_64 generator(1);
    std::vector<std::array<int, kMinSample>> samples(kSamples);
    for (auto& sample : samples) {
      for (int& corner : sample) corner = used[generator() % used.size()];
    }
    std::vector<Rigid3d> motions(kSamples, initial);
    std::vector<double> supports(kSamples);
    ParallelFor(0, kSamples, kSamplesPerBlock, [&](int begin, int end) {
      double most = least;
      for (int i = begin; i < end; ++i) {
        for (int step = 0; step < kSampleSteps; ++step) {
          motions[i] = Step(samples[i], motions[i], false);
        }
        supports[i] = SupportOf(used, motions[i], most);
        most = std::max(most, supports[i]);
      }
    });
    return motions[std::max_element(supports.begin(), supports.end()) - supports.begin()];
  }

  // Returns the support of a motion, or a value below `least` if the support is below `least`.
  double SupportOf(const std::vector<int>& used, const Rigid3d& motion, double least) const {
    constexpr double kRounding = 1e-9;
    double support = 0, possible = 0;
    for (const int i : used) possible += weights_[i];
    for (const int i : used) {
      possible -= weights_[i];
      const double error = Error(i, motion);
      if (error < 1) support += weights_[i] * (1 - error * error);
      if (support + possible < least - kRounding) break;
    }
    return support;
  }

  Rigid3d Refined(const std::vector<int>& used, Rigid3d motion) const {
    for (int step = 0; step < kRefineSteps; ++step) motion = Step(used, motion, true);
    return motion;
  }

  // Gauss-Newton step of the reprojection error. With `robust`, only static corners count.
  template <typename Corners>
  Rigid3d Step(const Corners& used, const Rigid3d& motion, bool robust) const {
    Matrix6d normal = 1e-9 * Matrix6d::Identity();
    Vector6d right = Vector6d::Zero();
    for (const int i : used) {
      const Eigen::Vector3d point = motion * corners_[i].point;
      if (!(point.z() > 0.05)) continue;
      const Eigen::Vector2d residual = camera_.Project(point) - corners_[i].seen;
      const double bound = bounds_[i];
      if (robust && residual.norm() > 2 * bound) continue;
      Eigen::Matrix<double, 2, 3> projection;
      const double z = point.z();
      projection << camera_.fx / z, 0, -camera_.fx * point.x() / (z * z), 0, camera_.fy / z,
          -camera_.fy * point.y() / (z * z);
      Eigen::Matrix<double, 2, 6> row;
      row.leftCols<3>() = -projection * CrossMatrix<double>(point);
      row.rightCols<3>() = projection;
      const double weight = weights_[i] / (bound * bound);
      normal += weight * row.transpose() * row;
      right -= weight * row.transpose() * residual;
    }
    const Vector6d increment = SolveLdlt(normal, right);
    if (!increment.allFinite() || increment.head<3>().norm() > 1) return motion;
    return LeftIncrement<double>(increment, motion);
  }

  const std::vector<TrackedCorner>& corners_;
  const PinholeCamera& camera_;
  std::vector<double> weights_, bounds_;
  double block_count_ = 0;
};

double MedianDepth(const std::vector<TrackedCorner>& corners, const std::vector<int>& used) {
  std::vector<double> depths;
  depths.reserve(used.size());
  for (const int i : used) depths.push_back(corners[i].point.z());
  return MedianOf(std::move(depths));
}

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

CornerMotion FindStaticMotion(const std::vector<TrackedCorner>& corners,
                              const PinholeCamera& camera, const Rigid3d& expected) {
  if (corners.size() < kMinBlocks) return {};
  const MotionSearch search(corners, camera);
  std::vector<int> all(corners.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<int>(i);
  MotionSupport found = search.Find(all, {expected, Rigid3d()});
  MotionSupport other;
  const std::vector<int> apart = search.Apart(all, found.motion);
  if (apart.size() >= kMinSample && !found.corners.empty()) {
    other = search.Find(apart, {expected, Rigid3d()});
    const bool is_behind = !other.corners.empty() && MedianDepth(corners, other.corners) >
                                                         MedianDepth(corners, found.corners);
    if (is_behind && other.support >= kMinBehind * found.support) {
      std::swap(found, other);
      found = search.At(all, found.motion);
    }
  }
  if (found.support < kMinBlocks || found.support < kMinSupport * search.block_count()) return {};
  CornerMotion motion;
  motion.now_from_before = found.motion;
  motion.is_certain = found.support >= kCertainSupport * search.block_count() &&
                      HasSecondMotion(found.corners.size(), other.corners.size());
  for (const int i : all) {
    const double error = search.Error(i, found.motion);
    motion.labels.push_back(error < 1               ? Label::kStatic
                            : error > kMovingFactor ? Label::kMoving
                                                    : Label::kUnknown);
  }
  return motion;
}

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
      Contradicts(world_from_camera->Inverse() * *window_->world_from_first)) {
    contradicted_until_s_ = last_s_ + kContradicted_s;
  }
  return last_s_ < contradicted_until_s_ ? moving_ : CellMask();
}

bool MovingCorners::Contradicts(const Rigid3d& now_from_first) const {
  const MotionSearch search(corners_, camera_);
  double all = 0, apart = 0;
  for (int i = 0; i < static_cast<int>(corners_.size()); ++i) {
    if (motion_.labels[i] != Label::kStatic) continue;
    all += search.weight(i);
    if (search.Error(i, now_from_first) > kApartFactor) apart += search.weight(i);
  }
  return apart > kMinApartRatio * all;
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
