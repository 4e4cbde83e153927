#include "registration/global/key_poses.h"

#include <algorithm>
#include <optional>

#include "registration/global/cloud_features.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

constexpr double kFpfhCells = 5;  // radius of the histograms, in cells
constexpr double kKeyToleranceCells = 1.5;
constexpr double kKeySigmaCells = 0.2;
constexpr int kMaxKeyMatches = 3000;
constexpr int kMaxHypotheses = 60;
constexpr std::size_t kRegisteredHypotheses = 12;

// Registers the key points from the best hypotheses.
std::vector<ScoredKeyPose> RegisterKeys(const CloudPair& pair, const KeyPoints& source,
                                        const KeyPoints& target,
                                        const std::vector<KeyConsensus>& hypotheses) {
  const double cell_m = pair.cell_m();
  const PointSet from = PointSetOfKeys(source, kKeySigmaCells * cell_m);
  const PointSet to = PointSetOfKeys(target, kKeySigmaCells * cell_m);
  std::vector<ScoredKeyPose> poses;
  poses.reserve(hypotheses.size());
  for (const KeyConsensus& hypothesis : hypotheses) {
    poses.push_back({hypothesis.target_from_source, pair.KeyScore(hypothesis.target_from_source)});
  }
  const auto sort = [&] {
    std::stable_sort(poses.begin(), poses.end(),
                     [](const auto& a, const auto& b) { return a.score > b.score; });
  };
  sort();
  if (poses.size() > kRegisteredHypotheses) poses.resize(kRegisteredHypotheses);
  RegisterCloudsOptions options;
  options.levels = 2;
  options.icp.gates = {2 * cell_m, 0.8};
  options.icp.error_model.floor_sigma_m = kKeySigmaCells * cell_m;
  options.icp.min_inliers = 20;
  options.icp.min_inlier_ratio = 0.01;
  PointSet facing = to;
  FaceViewpoint(pair.target().viewpoint, &facing);
  std::vector<std::optional<ScoredKeyPose>> registered(poses.size());
  const auto register_from = [&](const Rigid3d& start) -> std::optional<ScoredKeyPose> {
    PointSet turned = from;
    FaceViewpoint(start.Inverse() * pair.target().viewpoint, &turned);
    const IcpResult icp = RegisterClouds(turned, facing, start, options);
    const Rigid3d found = icp.Succeeded() ? icp.target_from_source : start;
    const double violations = pair.ViolationRatio(found).value_or(0);
    if (violations > 2 * pair.criteria().max_free_space_violation_ratio) return std::nullopt;
    return ScoredKeyPose{found, pair.KeyScore(found)};
  };
  // One pose does not have enough points for all threads.
  ParallelFor(0, static_cast<int>(poses.size()), 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) registered[i] = register_from(poses[i].target_from_source);
  });
  poses.clear();
  for (const std::optional<ScoredKeyPose>& pose : registered) {
    if (pose) poses.push_back(*pose);
  }
  sort();
  return poses;
}

}  // namespace

std::vector<ScoredKeyPose> FindKeyPoses(const CloudPair& pair,
                                        const CloudPair::ViewpointPair& viewpoints) {
  const double cell_m = pair.cell_m();
  const KeyPoints source = MakeKeyPoints(pair.source().points.points, cell_m, viewpoints.first);
  const KeyPoints target = MakeKeyPoints(pair.target().points.points, cell_m, viewpoints.second);
  const std::vector<KeyMatch> matches = MatchFpfh(
      FindFpfh(source, kFpfhCells * cell_m), FindFpfh(target, kFpfhCells * cell_m), kMaxKeyMatches);
  const std::vector<KeyConsensus> hypotheses =
      FindKeyConsensus(source, target, matches, kKeyToleranceCells * cell_m, kMaxHypotheses);
  return RegisterKeys(pair, source, target, hypotheses);
}

}  // namespace surfit
