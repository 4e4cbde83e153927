#include "surfit/simulation/camera_path.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "simulation/gaze.h"
#include "simulation/hand_held_motion.h"
#include "simulation/random.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"

namespace surfit {
namespace {

// Selects the value for a single room or for a building.
int Attempts(const Scene& scene, int in_a_room, int in_a_building) {
  return scene.cells.empty() ? in_a_room : in_a_building;
}

double LeastDistance(const Scene& scene, Walk walk, int frames, double step_m) {
  constexpr int kFramesApart = 10;
  double least = scene.Distance(walk.Position());
  for (int i = 0; i < frames; i += kFramesApart) {
    walk.Advance(kFramesApart * step_m);
    least = std::min(least, scene.Distance(walk.Position()));
  }
  return least;
}

// Returns the first random walk that keeps 0.5 m from all objects. If no walk does, returns the
// walk with the largest minimum distance.
Walk ChooseWalk(const Scene& scene, int frames, double step_m, Random* random) {
  const int candidates = Attempts(scene, 24, 2);
  constexpr double kFarEnough_m = 0.5;
  Walk best(scene, random);
  double best_distance = LeastDistance(scene, best, frames, step_m);
  for (int i = 1; i < candidates && best_distance < kFarEnough_m; ++i) {
    const Walk walk(scene, random);
    const double distance = LeastDistance(scene, walk, frames, step_m);
    if (distance <= best_distance) continue;
    best = walk;
    best_distance = distance;
  }
  return best;
}

struct Operator {
  Walk walk;
  Gaze gaze;
  Hand moving, turning;

  void Film(int begin, int end, double frames_per_second, Trajectory* path) {
    for (int i = begin; i < end; ++i) {
      const Eigen::Quaterniond tremble = QuaternionExp<double>(turning.TrembleAt(i));
      path->push_back({i / frames_per_second, Rigid3d((gaze.Orientation() * tremble).normalized(),
                                                      walk.Position() + moving.TrembleAt(i))});
      walk.Advance(moving.SpeedAt(i));
      gaze.Advance(walk.Position(), turning.SpeedAt(i));
    }
  }
};

// Cost of a path; 0 if it meets all requirements.
double PathCost(const Scene& scene, const PathQuality& quality) {
  constexpr double kMaxPlanar = 0.45;
  const double least_planar = scene.cells.empty() ? 0.28 : 0;
  return 3 * std::max(0.0, least_planar - quality.planar_ratio) +
         std::max(0.0, quality.planar_ratio - kMaxPlanar) + 2 * quality.degenerate_ratio;
}

// Appends poses for the frames [begin, end). Uses the first random gaze whose PathCost() is 0, or
// the gaze of minimum cost.
void FilmPiece(const Scene& scene, int begin, int end, double frames_per_second, Random* random,
               Operator* person, Trajectory* path) {
  const int candidates = Attempts(scene, 16, 12);
  const Operator before = *person;
  Trajectory best;
  double least_shortfall = std::numeric_limits<double>::infinity();
  for (int i = 0; i < candidates && least_shortfall > 0; ++i) {
    Operator candidate = before;
    candidate.gaze.Reseed(random->Index(1 << 30));
    Trajectory piece;
    candidate.Film(begin, end, frames_per_second, &piece);
    const double shortfall = PathCost(scene, EvaluatePath(scene, piece));
    if (shortfall >= least_shortfall) continue;
    least_shortfall = shortfall;
    best = std::move(piece);
    *person = candidate;
  }
  path->insert(path->end(), best.begin(), best.end());
}

Trajectory FilmPath(const Scene& scene, int frames, const PathOptions& options, Random random) {
  const int length = Attempts(scene, 200, 50);
  const double fps = options.frames_per_second;
  const Hand moving(options.min_step_m, options.max_step_m, fps, &random);
  const Hand turning(options.min_turn_deg * kRadPerDeg, options.max_turn_deg * kRadPerDeg, fps,
                     &random);
  const Walk walk = ChooseWalk(scene, frames, options.max_step_m, &random);
  Operator person{walk, Gaze(scene, walk.Position(), random.Index(1 << 30)), moving, turning};
  Trajectory path;
  path.reserve(frames);
  for (int begin = 0; begin < frames; begin += length) {
    FilmPiece(scene, begin, std::min(frames, begin + length), fps, &random, &person, &path);
  }
  return path;
}

}  // namespace

Trajectory MakePath(const Scene& scene, int frames, std::uint64_t seed,
                    const PathOptions& options) {
  Validate(options);
  ThrowIf(frames < 1, "frames is ", frames, ", must be at least 1");
  ThrowIf(scene.camera_space.isEmpty(), "the scene has no space for the camera");
  ThrowIf(scene.targets.size() < 2, "the scene has ", scene.targets.size(),
          " targets, must have at least 2");
  const int walks = Attempts(scene, 6, 1);
  constexpr double kGoodEnough = 0.05;
  Trajectory best;
  double least_shortfall = std::numeric_limits<double>::infinity();
  for (int i = 1; i <= walks && least_shortfall > kGoodEnough; ++i) {
    Trajectory path = FilmPath(scene, frames, options, Random(seed, i));  // the scene uses stream 0
    const double shortfall = PathCost(scene, EvaluatePath(scene, path));
    if (shortfall >= least_shortfall) continue;
    least_shortfall = shortfall;
    best = std::move(path);
  }
  return best;
}

SmoothPath::SmoothPath(Trajectory poses) : poses_(std::move(poses)) {
  ThrowIf(poses_.empty(), "the path has no poses");
  const std::size_t count = poses_.size();
  for (const StampedPose& pose : poses_) {
    const Eigen::Quaterniond& q = pose.world_from_camera.rotation;
    Knot knot;
    knot << pose.world_from_camera.translation, q.coeffs();
    // Uses the quaternion sign that is closer to the previous quaternion.
    if (!values_.empty() && knot.tail<4>().dot(values_.back().tail<4>()) < 0) knot.tail<4>() *= -1;
    values_.push_back(knot);
  }
  // Natural cubic spline through the values y with the steps h. The second derivatives m satisfy
  //   h0 m0 + 2 (h0 + h1) m1 + h1 m2 = 6 ((y2 - y1) / h1 - (y1 - y0) / h0),
  // with m = 0 at both ends.
  second_derivatives_.assign(count, Knot::Zero());
  std::vector<double> above(count, 0);
  const auto step = [&](std::size_t i) { return poses_[i + 1].stamp_s - poses_[i].stamp_s; };
  const auto slope = [&](std::size_t i) -> Knot { return (values_[i + 1] - values_[i]) / step(i); };
  for (std::size_t i = 0; i + 1 < count; ++i) {
    ThrowIf(!(step(i) > 0), "the path has the time ", poses_[i + 1].stamp_s, " s after ",
            poses_[i].stamp_s, " s, must increase");
  }
  std::vector<Knot>& m = second_derivatives_;
  for (std::size_t i = 1; i + 1 < count; ++i) {
    const double h0 = step(i - 1), h1 = step(i), pivot = 2 * (h0 + h1) - h0 * above[i - 1];
    above[i] = h1 / pivot;
    m[i] = (6 * (slope(i) - slope(i - 1)) - h0 * m[i - 1]) / pivot;
  }
  for (std::size_t i = count - 1; i-- > 1;) m[i] -= above[i] * m[i + 1];
}

Rigid3d SmoothPath::At(double stamp_s) const {
  const auto next =
      std::lower_bound(poses_.begin(), poses_.end(), stamp_s,
                       [](const StampedPose& pose, double stamp) { return pose.stamp_s < stamp; });
  if (next != poses_.end() && next->stamp_s == stamp_s) return next->world_from_camera;
  if (poses_.size() == 1) return poses_[0].world_from_camera;
  const auto last = static_cast<std::ptrdiff_t>(poses_.size()) - 1;
  const auto i = std::clamp<std::ptrdiff_t>(next - poses_.begin() - 1, 0, last - 1);
  const double h = poses_[i + 1].stamp_s - poses_[i].stamp_s;
  const double a = (poses_[i + 1].stamp_s - stamp_s) / h, b = 1 - a;
  // negative x: linear extrapolation
  const auto cubic = [](double x) { return x < 0 ? -x : x * x * x - x; };
  const Knot bend = cubic(a) * second_derivatives_[i] + cubic(b) * second_derivatives_[i + 1];
  const Knot value = a * values_[i] + b * values_[i + 1] + h * h / 6 * bend;
  return {Eigen::Quaterniond(Eigen::Vector4d(value.tail<4>())).normalized(), value.head<3>()};
}

}  // namespace surfit
