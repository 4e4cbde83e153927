#include "registration/global/initial_pose_search.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>

#include "registration/global/feature_points.h"
#include "registration/solvers/decompositions.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

constexpr int kMaxFeatures = 2000;
constexpr int kFeaturePoses = 10;  // maximum number of RANSAC poses

struct Nearness {
  double distance_m;
  double angle_rad;
};
constexpr Nearness kCoarseNearness = {0.08, 4 * kRadPerDeg};
constexpr Nearness kMiddleNearness = {0.03, 1 * kRadPerDeg};
constexpr Nearness kFineNearness = {0.02, 1 * kRadPerDeg};

// Pixel stride at the coarsest level for the first search over all rotations.
constexpr int kSketchStride = 2;

// Maximum number of distinct poses after each stage.
constexpr std::size_t kCoarsePoses = 40;
constexpr std::size_t kMiddlePoses = 6;
constexpr std::size_t kFinePoses = 8;

bool AreNear(const Rigid3d& a, const Rigid3d& b, const Nearness& nearness) {
  return (a.translation - b.translation).norm() < nearness.distance_m &&
         RotationAngle(a.rotation.conjugate() * b.rotation) < nearness.angle_rad;
}

// Sorts poses by descending score and removes each pose that is near a better pose. Returns at most
// `max_count` poses.
std::vector<CandidatePose> BestDistinct(std::vector<CandidatePose> poses, const Nearness& nearness,
                                        std::size_t max_count) {
  std::stable_sort(poses.begin(), poses.end(), [](const CandidatePose& a, const CandidatePose& b) {
    return a.score > b.score;
  });
  std::vector<CandidatePose> different;
  for (const CandidatePose& pose : poses) {
    if (different.size() == max_count) break;
    if (std::none_of(different.begin(), different.end(), [&](const CandidatePose& better) {
          return AreNear(better.target_from_source, pose.target_from_source, nearness);
        })) {
      different.push_back(pose);
    }
  }
  return different;
}

// Removes poses beyond `bound`.
std::vector<CandidatePose> Within(const MotionBound& bound, std::vector<CandidatePose> poses) {
  const auto is_beyond = [&](const CandidatePose& pose) {
    return !bound.Allows(pose.target_from_source);
  };
  poses.erase(std::remove_if(poses.begin(), poses.end(), is_beyond), poses.end());
  return poses;
}

// Applies `change` to all poses in parallel. Result i belongs to pose i.
std::vector<CandidatePose> ForAll(
    const std::vector<CandidatePose>& poses,
    const std::function<CandidatePose(const CandidatePose&)>& change) {
  std::vector<CandidatePose> changed(poses.size());
  ParallelFor(0, static_cast<int>(poses.size()), 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) changed[i] = change(poses[i]);
  });
  return changed;
}

}  // namespace

std::vector<Eigen::Quaterniond> RotationGrid() {
  constexpr double kReachRad = 60 * kRadPerDeg;
  // Side of the cubes of a body-centred lattice. A rotation vector is at most sqrt(5) / 4 sides
  // from a lattice point.
  constexpr double kSideRad = 19 * kRadPerDeg;
  const int reach = static_cast<int>(kReachRad / kSideRad) + 1;
  std::vector<Eigen::Vector3d> vectors;
  for (const double offset : {0., 0.5}) {
    for (int x = -reach; x <= reach; ++x) {
      for (int y = -reach; y <= reach; ++y) {
        for (int z = -reach; z <= reach; ++z) {
          const Eigen::Vector3d vector =
              kSideRad * (Eigen::Vector3d(x, y, z) + Eigen::Vector3d::Constant(offset));
          if (vector.norm() <= kReachRad) vectors.push_back(vector);
        }
      }
    }
  }
  std::stable_sort(vectors.begin(), vectors.end(),
                   [](const auto& a, const auto& b) { return a.norm() < b.norm(); });
  std::vector<Eigen::Quaterniond> rotations;
  rotations.reserve(vectors.size());
  for (const Eigen::Vector3d& vector : vectors) rotations.push_back(QuaternionExp<double>(vector));
  return rotations;
}

InitialPoseSearch::InitialPoseSearch(const ColoredView& source, const ColoredView& target,
                                     const ErrorModel& error_model)
    : source_(source),
      target_(target),
      error_model_(error_model),
      levels_(
          static_cast<int>(std::min(source.pyramid.levels.size(), target.pyramid.levels.size()))) {
  const auto brightness = [&](const ColoredView& view) {
    const PinholeCamera& camera = view.pyramid.levels.front().camera;
    return BrightnessPyramid(view.color, camera.width, camera.height, levels_);
  };
  source_brightness_ = brightness(source);
  target_brightness_ = brightness(target);
}

// Pixel stride of a stage. All stages use about as many points as the coarsest level.
int InitialPoseSearch::StrideOf(Stage stage) const {
  return 1 << std::max(0, LevelOf(kCoarse) - LevelOf(stage));
}

int InitialPoseSearch::LevelOf(Stage stage) const { return std::max(0, levels_ - 1 - stage); }

ViewLevel InitialPoseSearch::Source(Stage stage) const {
  return {source_.pyramid.levels[LevelOf(stage)], source_brightness_[LevelOf(stage)]};
}

ViewLevel InitialPoseSearch::Target(Stage stage) const {
  return {target_.pyramid.levels[LevelOf(stage)], target_brightness_[LevelOf(stage)]};
}

// The surface error doubles with each coarser level.
double InitialPoseSearch::Score(Stage stage, const Rigid3d& pose, int stride) const {
  ErrorModel error_model = error_model_;
  error_model.floor_sigma_m *= std::pow(2, LevelOf(stage));
  return MeasureFit(Source(stage), Target(stage), error_model, pose, stride).Score();
}

std::vector<CandidatePose> InitialPoseSearch::FromFeatures() const {
  const FeaturePoints source =
      FindFeatures(source_.color, source_.pyramid.levels.front(), error_model_, kMaxFeatures);
  const FeaturePoints target =
      FindFeatures(target_.color, target_.pyramid.levels.front(), error_model_, kMaxFeatures);
  std::vector<CandidatePose> poses;
  for (const Consensus& consensus :
       FindConsensus(source, target, MatchFeatures(source, target), kFeaturePoses)) {
    poses.push_back({consensus.target_from_source, 0});
  }
  return poses;
}

std::vector<CandidatePose> InitialPoseSearch::FromRotations(const MotionBound& bound) const {
  std::vector<CandidatePose> poses;
  for (const Eigen::Quaterniond& rotation : RotationGrid()) {
    if (RotationAngle(rotation) > bound.max_rad + kGridAngleRad) break;
    poses.push_back({Rigid3d(rotation, Eigen::Vector3d::Zero()), 0});
  }
  // The large distance gate allows walls to converge over long distances.
  DescentOptions descent;
  descent.max_steps = 15;
  descent.max_distance_m = 1.5;
  descent.max_distance_end_m = 0.25;
  descent.use_brightness = false;
  descent.stride = kSketchStride;
  return ForAll(poses, [&](const CandidatePose& start) {
    const Rigid3d pose =
        Descend(Source(kCoarse), Target(kCoarse), start.target_from_source, descent);
    return CandidatePose{pose, Score(kCoarse, pose, kSketchStride)};
  });
}

CandidatePose InitialPoseSearch::Improve(const CandidatePose& start) const {
  DescentOptions descent;
  Rigid3d pose = Descend(Source(kCoarse), Target(kCoarse), start.target_from_source, descent);
  descent.max_steps = 8;
  descent.stride = StrideOf(kMiddle);
  descent.max_distance_m = 0.2;
  descent.max_distance_end_m = 0.1;
  pose = Descend(Source(kMiddle), Target(kMiddle), pose, descent);
  return {pose, Score(kMiddle, pose, StrideOf(kMiddle))};
}

// Geometry may not constrain a direction, for example with only two walls. Then the pose along this
// direction is arbitrary. This function tests poses along the weakest direction and returns the
// best poses. Their scores include brightness.
std::vector<CandidatePose> InitialPoseSearch::AlongWeakestDirection(
    const Rigid3d& pose, const MotionBound& bound) const {
  constexpr double kReachM = 1, kStepM = 0.05;
  constexpr std::size_t kBest = 6;
  const JointSystem system = LinearizeJointly(Source(kCoarse), Target(kCoarse),
                                              {kCoarseNearness.distance_m * 3, false}, pose);
  std::vector<CandidatePose> along;
  if (system.pair_count == 0) return along;
  const std::optional<Vector6d> direction = WeakestIncrement(system.hessian, system.RmsDistance());
  if (!direction) return along;
  for (int i = 1; i * kStepM <= kReachM; ++i) {
    for (const double shift_m : {i * kStepM, -i * kStepM}) {
      along.push_back({LeftIncrement<double>(shift_m * *direction, pose), 0});
    }
  }
  const auto score = [&](const CandidatePose& shifted) {
    return CandidatePose{shifted.target_from_source, Score(kCoarse, shifted.target_from_source)};
  };
  return BestDistinct(ForAll(Within(bound, std::move(along)), score), kCoarseNearness, kBest);
}

std::vector<CandidatePose> InitialPoseSearch::FindPoses(const MotionBound& bound) const {
  const auto improve = [&](const std::vector<CandidatePose>& starts) {
    return Within(bound, ForAll(Within(bound, starts),
                                [&](const CandidatePose& start) { return Improve(start); }));
  };
  std::vector<CandidatePose> poses, by_features;
  const std::function<void()> searches[] = {
      [&] {
        poses = improve(
            BestDistinct(Within(bound, FromRotations(bound)), kCoarseNearness, kCoarsePoses));
      },
      [&] { by_features = improve(FromFeatures()); }};
  ParallelFor(0, 2, 1, [&](int k, int) { searches[k](); });
  poses.insert(poses.end(), by_features.begin(), by_features.end());
  std::vector<CandidatePose> best = BestDistinct(poses, kMiddleNearness, kMiddlePoses);
  std::vector<CandidatePose> along;
  for (const CandidatePose& pose : best) {
    for (const CandidatePose& other : AlongWeakestDirection(pose.target_from_source, bound)) {
      along.push_back(other);
    }
  }
  for (const CandidatePose& pose : improve(along)) poses.push_back(pose);
  best = BestDistinct(poses, kMiddleNearness, kFinePoses);

  DescentOptions descent;
  descent.max_steps = 6;
  descent.stride = StrideOf(kFine);
  descent.max_distance_m = descent.max_distance_end_m = 0.1;
  descent.damping = 1e-4;
  const auto refine = [&](const CandidatePose& start) {
    const Rigid3d pose = Descend(Source(kFine), Target(kFine), start.target_from_source, descent);
    return CandidatePose{pose, Score(kFine, pose, StrideOf(kFine))};
  };
  return BestDistinct(Within(bound, ForAll(best, refine)), kFineNearness, kFinePoses);
}

}  // namespace surfit
