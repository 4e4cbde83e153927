#include "surfit/simulation/camera_path.h"

#include <glog/logging.h>

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

double LeastDistance(const Scene& scene, Walk walk, int frames, double step_m) {
  constexpr int kFramesApart = 10;
  double least = scene.Distance(walk.Position());
  for (int i = 0; i < frames; i += kFramesApart) {
    walk.Advance(kFramesApart * step_m);
    least = std::min(least, scene.Distance(walk.Position()));
  }
  return least;
}

// Of some random walks the first that keeps away from objects, or the one that does best.
Walk ChooseWalk(const Scene& scene, int frames, double step_m, Random* random) {
  constexpr int kCandidates = 24;
  constexpr double kFarEnough_m = 0.5;
  Walk best(scene, random);
  double best_distance = LeastDistance(scene, best, frames, step_m);
  for (int i = 1; i < kCandidates && best_distance < kFarEnough_m; ++i) {
    const Walk walk(scene, random);
    const double distance = LeastDistance(scene, walk, frames, step_m);
    if (distance <= best_distance) continue;
    best = walk;
    best_distance = distance;
  }
  return best;
}

// Who holds the camera: where they are and what they look at.
struct Operator {
  Walk walk;
  Gaze gaze;
  Hand moving, turning;  // in metres and rad a frame

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

// How far a path falls short of what we want to see; 0 where it does not.
double Shortfall(const PathQuality& quality) {
  constexpr double kLeastPlanar = 0.28, kMostPlanar = 0.45;
  return 3 * std::max(0.0, kLeastPlanar - quality.planar_share) +
         std::max(0.0, quality.planar_share - kMostPlanar) + 2 * quality.bare_share;
}

// Goes on with the path: of some random ways to look around the first that does not fall short, or
// the best.
void FilmPiece(const Scene& scene, int begin, int end, double frames_per_second, Random* random,
               Operator* person, Trajectory* path) {
  constexpr int kCandidates = 16;
  const Operator before = *person;
  Trajectory best;
  double least_shortfall = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kCandidates && least_shortfall > 0; ++i) {
    Operator candidate = before;
    candidate.gaze.Reseed(random->Index(1 << 30));
    Trajectory piece;
    candidate.Film(begin, end, frames_per_second, &piece);
    const double shortfall = Shortfall(JudgePath(scene, piece));
    if (shortfall >= least_shortfall) continue;
    least_shortfall = shortfall;
    best = std::move(piece);
    *person = candidate;
  }
  path->insert(path->end(), best.begin(), best.end());
}

Trajectory FilmPath(const Scene& scene, int frames, const PathOptions& options, Random random) {
  constexpr int kPiece = 200;
  const double fps = options.frames_per_second;
  const Hand moving(options.min_step_m, options.max_step_m, fps, &random);
  const Hand turning(options.min_turn_deg * kRadPerDeg, options.max_turn_deg * kRadPerDeg, fps,
                     &random);
  const Walk walk = ChooseWalk(scene, frames, options.max_step_m, &random);
  Operator person{walk, Gaze(scene, walk.Position(), random.Index(1 << 30)), moving, turning};
  Trajectory path;
  path.reserve(frames);
  for (int begin = 0; begin < frames; begin += kPiece) {
    FilmPiece(scene, begin, std::min(frames, begin + kPiece), fps, &random, &person, &path);
  }
  return path;
}

}  // namespace

Trajectory MakePath(const Scene& scene, int frames, std::uint64_t seed,
                    const PathOptions& options) {
  Validate(options);
  if (frames < 1) throw InputError(Concat("frames is ", frames, ", must be at least 1"));
  CHECK(!scene.camera_space.isEmpty() && scene.targets.size() > 1);
  constexpr int kWalks = 6;
  constexpr double kGoodEnough = 0.05;
  Trajectory best;
  double least_shortfall = std::numeric_limits<double>::infinity();
  for (int i = 1; i <= kWalks && least_shortfall > kGoodEnough; ++i) {
    Trajectory path = FilmPath(scene, frames, options, Random(seed, i));  // stream 0: the scene's
    const double shortfall = Shortfall(JudgePath(scene, path));
    if (shortfall >= least_shortfall) continue;
    least_shortfall = shortfall;
    best = std::move(path);
  }
  return best;
}

}  // namespace surfit
