#include "output/report/compare_runs.h"

#include <algorithm>
#include <cmath>

#include "geometry/kd_tree.h"
#include "surfit/core/parallel.h"
#include "surfit/evaluation/trajectory_evaluation.h"

namespace surfit {
namespace {

float DistanceToDisc(const Eigen::Vector3f& p, const Surfel& disc) {
  const Eigen::Vector3f offset = p - disc.position_in_world;
  const float height = disc.normal_in_world.dot(offset);
  const float aside = (offset - height * disc.normal_in_world).norm();
  return std::hypot(height, std::max(0.f, aside - disc.radius_m));
}

}  // namespace

std::optional<RunAlignment> AlignRuns(const Trajectory& source, const Trajectory& target) {
  const std::vector<MatchedPose> poses = MatchPoses(target, source, MatchOptions());
  const auto error = ComputeAbsoluteTrajectoryError(poses);
  if (!error) return std::nullopt;
  if (error->alignment.status == AlignmentStatus::kAligned) {
    return RunAlignment{error->alignment.target_from_source, poses.size(),
                        error->translation_m.rmse};
  }
  const MatchedPose& middle = poses[poses.size() / 2];
  const Rigid3d target_from_source = middle.ground_truth * middle.estimate.Inverse();
  double sum = 0;
  for (const MatchedPose& pose : poses) {
    const Eigen::Vector3d moved = target_from_source * pose.estimate.translation;
    sum += (pose.ground_truth.translation - moved).squaredNorm();
  }
  return RunAlignment{target_from_source, poses.size(),
                      std::sqrt(sum / static_cast<double>(poses.size()))};
}

std::vector<float> DistancesFromMap(const std::vector<Surfel>& surfels,
                                    const Rigid3d& map_from_surfels,
                                    const std::vector<Surfel>& map) {
  std::vector<float> distances(surfels.size(), kFarFromMap);
  std::vector<Eigen::Vector3f> centres;
  std::vector<std::size_t> surfel_of_centre;
  for (std::size_t i = 0; i < map.size(); ++i) {
    if (!map[i].position_in_world.allFinite()) continue;
    centres.push_back(map[i].position_in_world);
    surfel_of_centre.push_back(i);
  }
  if (centres.empty()) return distances;
  const KdTree tree(centres);
  constexpr int kGrain = 4096;
  ParallelFor(0, static_cast<int>(surfels.size()), kGrain, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const Eigen::Vector3d position = surfels[i].position_in_world.cast<double>();
      const Eigen::Vector3f p = (map_from_surfels * position).cast<float>();
      if (!p.allFinite()) continue;
      const auto nearest = tree.Nearest(p, kFarFromMap * kFarFromMap);
      if (nearest.rank == KdTree::kNone) continue;
      const Surfel& disc = map[surfel_of_centre[tree.order()[nearest.rank]]];
      distances[i] = std::min(kFarFromMap, DistanceToDisc(p, disc));
    }
  });
  return distances;
}

}  // namespace surfit
