#include <algorithm>
#include <cmath>
#include <utility>

#include "loop_closure/correct_frames.h"
#include "registration/solvers/decompositions.h"
#include "surfit/slam/backend.h"

namespace surfit {
namespace {

// Mean of the differences between the rotations of prior poses and keyframes.
constexpr double kRotationWindow_s = 10;

}  // namespace

// Snapshot with the edges of prior motions. These edges come last, so the chain of odometry edges
// gives the initial poses.
//
// Positions of a source can be more accurate than its rotations. So the translation of an edge is
// that in the world of the source. It is rotated by the mean difference of the rotations over some
// seconds.
PoseGraph Backend::Graph(const std::vector<Rigid3d>& world_from_keyframe) {
  PoseGraph graph = poses_.Snapshot();
  if (!prior_motions_) return graph;
  struct Added {
    std::size_t edge;
    PriorEdge motion;
    double stamp_s;
    Eigen::Quaterniond world_from_source;
  };
  std::vector<Added> added;
  for (std::size_t i = 0; i < graph.edges.size(); ++i) {
    if (graph.edges[i].loop) continue;
    const PosedFrame& a = poses_.FrameOf(static_cast<int>(graph.edges[i].a));
    const PosedFrame& b = poses_.FrameOf(static_cast<int>(graph.edges[i].b));
    const auto motion = prior_motions_(a.stamp_s, b.stamp_s);
    if (!motion) continue;
    added.push_back({i, *motion, a.stamp_s,
                     world_from_keyframe[graph.edges[i].a].rotation *
                         motion->source_from_a.rotation.conjugate()});
  }
  for (const Added& prior : added) {
    Eigen::Vector4d mean = Eigen::Vector4d::Zero();
    for (const Added& near : added) {
      if (std::abs(near.stamp_s - prior.stamp_s) > kRotationWindow_s) continue;
      const double sign = near.world_from_source.dot(prior.world_from_source) < 0 ? -1 : 1;
      mean += sign * near.world_from_source.coeffs();
    }
    PoseGraphEdge& odometry = graph.edges[prior.edge];
    const Rigid3d source_a_from_b =
        prior.motion.source_from_a.Inverse() * prior.motion.source_from_b;
    PoseGraphEdge edge = odometry;
    edge.a_from_b.rotation = source_a_from_b.rotation;
    edge.a_from_b.translation =
        world_from_keyframe[odometry.a].rotation.conjugate() *
        (Eigen::Quaterniond(mean).normalized() *
         (prior.motion.source_from_b.translation - prior.motion.source_from_a.translation));
    const Matrix6d a_from_b = IncrementTransform(edge.a_from_b);
    edge.information = SymmetricInverse(a_from_b * prior.motion.covariance * a_from_b.transpose());
    odometry.information =
        SymmetricInverse(SymmetricInverse(odometry.information) +
                         a_from_b * prior.motion.odometry_covariance * a_from_b.transpose());
    graph.edges.push_back(edge);
  }
  return graph;
}

// Poses of the keyframes that combine odometry, loops and prior motions. std::nullopt without prior
// motions between keyframes, or if the optimisation fails.
std::optional<std::vector<Rigid3d>> Backend::KeyframesWithPrior() {
  constexpr int kRounds = 2;  // the edges depend on the rotations of the keyframes
  PoseGraphOptions options = options_.graph;
  options.start = "given";
  options.loop_robustness = "none";
  std::vector<Rigid3d> poses = poses_.KeyframePoses();
  for (int round = 0; round < kRounds; ++round) {
    PoseGraph graph = Graph(poses);
    if (graph.edges.size() == poses_.edges().size()) return std::nullopt;
    const std::vector<bool> in_graph = poses_.loops_in_graph();
    std::size_t loop = 0;
    const auto is_outlier = [&](const PoseGraphEdge& edge) {
      return edge.loop && !in_graph[loop++];
    };
    graph.edges.erase(std::remove_if(graph.edges.begin(), graph.edges.end(), is_outlier),
                      graph.edges.end());
    if (!OptimizePoseGraph(options, &graph).Succeeded()) return std::nullopt;
    for (std::size_t k = 0; k < poses.size(); ++k) poses[k] = graph.poses[k].world_from_pose;
  }
  return poses;
}

// Each pose is a measurement with the noise of the registration, and a quarter of the variance of
// its motion between both keyframes. This is the variance of a random walk in the middle of two
// fixed ends.
// Prior motions connect consecutive frames.
std::vector<Rigid3d> Backend::SmoothedByPrior(std::vector<Rigid3d> world_from_frame) const {
  const std::vector<PosedFrame>& frames = poses_.frames();
  PoseGraph graph;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    graph.poses.push_back({frames[i].index, world_from_frame[i], true});
    if (i == 0 || frames[i].segment != frames[i - 1].segment) continue;
    const auto motion = prior_motions_(frames[i - 1].stamp_s, frames[i].stamp_s);
    if (!motion) continue;
    const Rigid3d a_from_b = motion->source_from_a.Inverse() * motion->source_from_b;
    const Matrix6d transform = IncrementTransform(a_from_b);
    graph.edges.push_back({i - 1, i, a_from_b,
                           SymmetricInverse(transform * motion->covariance * transform.transpose()),
                           false});
    for (const std::size_t k : {i - 1, i}) {
      if (!graph.poses[k].fixed) continue;
      graph.poses[k].fixed = false;
      Matrix6d covariance = motion->registration_noise;
      const int keyframe = frames[k].keyframe;
      if (keyframe + 1 < static_cast<int>(poses_.keyframes().size())) {
        const auto between =
            prior_motions_(poses_.FrameOf(keyframe).stamp_s, poses_.FrameOf(keyframe + 1).stamp_s);
        if (between) covariance += 0.25 * between->odometry_covariance;
      }
      graph.priors.push_back({k, Rigid3d(), world_from_frame[k], SymmetricInverse(covariance)});
    }
  }
  PoseGraphOptions options = options_.graph;
  options.start = "given";
  options.loop_robustness = "none";
  if (graph.edges.empty() || !OptimizePoseGraph(options, &graph).Succeeded()) {
    return world_from_frame;
  }
  for (std::size_t i = 0; i < frames.size(); ++i) {
    world_from_frame[i] = graph.poses[i].world_from_pose;
  }
  return world_from_frame;
}

// The keyframes follow the prior over long times, the other frames over short times.
void Backend::FusePriorMotions(std::vector<WorldCorrection>* corrections) {
  if (!prior_motions_ || poses_.keyframes().empty()) return;
  const std::vector<PosedFrame> frames = poses_.frames();
  const std::vector<Rigid3d> before = poses_.KeyframePoses();
  const std::vector<Rigid3d> after = KeyframesWithPrior().value_or(before);
  const FrameCorrections of_keyframes =
      CorrectionsOfFrames(frames, poses_.frame_of_keyframe(), CorrectionsOfKeyframes(after));
  std::vector<Rigid3d> poses;
  poses.reserve(frames.size());
  for (const PosedFrame& frame : frames) {
    poses.push_back(of_keyframes.At(frame.index) * frame.world_from_camera);
  }
  corrections->push_back(MoveFrames(SmoothedByPrior(std::move(poses))));
}

// Measurements of edges move with the keyframes, so that a continued session keeps the result.
WorldCorrection Backend::MoveFrames(const std::vector<Rigid3d>& world_from_frame) {
  const std::vector<PosedFrame> frames = poses_.frames();
  const std::vector<Rigid3d> before = poses_.KeyframePoses();
  std::vector<Rigid3d> of_indices;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    of_indices.resize(frames[i].index - frames.front().index,
                      of_indices.empty() ? Rigid3d() : of_indices.back());
    of_indices.push_back(world_from_frame[i] * frames[i].world_from_camera.Inverse());
  }
  WorldCorrection correction;
  correction.moves = true;
  correction.corrections = {frames.front().index, std::move(of_indices)};
  correction.new_from_old_now = correction.corrections.At(frames.back().index);
  poses_.Move(correction.corrections);
  ++counts_.corrections;
  poses_.RecalibrateEdges(before);
  return correction;
}

}  // namespace surfit
