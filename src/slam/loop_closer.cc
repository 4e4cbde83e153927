#include "slam/loop_closer.h"

#include <algorithm>
#include <utility>

#include "core/trace.h"
#include "slam/edge_information.h"
#include "surfit/loop_closure/place_index.h"

namespace surfit {
namespace {

LoopFinder OwnFinder(const FindLoopsOptions& options) {
  return [options](int source, const std::vector<Keyframe>& keyframes, const PlaceIndex& index) {
    return FindLoops(source, keyframes, index, options);
  };
}

std::vector<bool> LoopsInGraph(const PoseGraph& graph, const PoseGraphSummary& summary) {
  std::vector<bool> in_graph;
  for (std::size_t i = 0; i < graph.edges.size(); ++i) {
    if (!graph.edges[i].loop) continue;
    in_graph.push_back(
        !std::binary_search(summary.outlier_edges.begin(), summary.outlier_edges.end(), i));
  }
  return in_graph;
}

}  // namespace

PoseGraphEdge LoopEdge(const LoopAttempt& attempt, const EdgeNoise& noise) {
  PoseGraphEdge edge;
  edge.a = static_cast<std::size_t>(attempt.proposal.target);
  edge.b = static_cast<std::size_t>(attempt.proposal.source);
  edge.a_from_b = attempt.verdict.target_from_source;
  edge.information = LoopInformation(attempt.verdict.information, noise);
  edge.loop = true;
  return edge;
}

void Recalibrate(const std::vector<Rigid3d>& before, const std::vector<Rigid3d>& after,
                 std::vector<PoseGraphEdge>* edges) {
  for (PoseGraphEdge& edge : *edges) {
    const Rigid3d error = before[edge.b].Inverse() * before[edge.a] * edge.a_from_b;
    edge.a_from_b = after[edge.a].Inverse() * after[edge.b] * error;
  }
}

LoopCloser::LoopCloser(const LoopOptions& options, LoopFinder finder, bool always_beside)
    : options_(options),
      finder_(finder ? std::move(finder) : OwnFinder(options.find)),
      index_(options.places),
      task_(always_beside) {}

void LoopCloser::GoOnFrom(std::vector<Keyframe> keyframes, std::vector<PoseGraphEdge> edges) {
  for (Keyframe& keyframe : keyframes) {
    const int k = static_cast<int>(keyframes_.size());
    if (!keyframe.view.empty()) index_.Add(k, keyframe.view);
    Add(std::move(keyframe));
  }
  graph_.edges = std::move(edges);
  LimitKeyframes(options_.max_view_bytes, &keyframes_, &index_);
}

void LoopCloser::Start(LoopTask task) {
  task_.Start(options_.delay_frames,
              [this, started = std::move(task)]() mutable { return Run(std::move(started)); });
}

LoopOutcome LoopCloser::Run(LoopTask task) {
  const TraceSlice slice("close_loops");
  LoopOutcome outcome;
  const std::size_t loops_before = graph_.edges.size();
  std::size_t odometry_edges = 0;
  const int first = static_cast<int>(keyframes_.size());
  for (NewKeyframe& added : task.added) {
    odometry_edges += added.edges.size();
    added.keyframe.view = added.view();
    graph_.edges.insert(graph_.edges.end(), added.edges.begin(), added.edges.end());
    Add(std::move(added.keyframe));
  }
  SetPoses(task.world_from_keyframe);
  for (int k = first; k < static_cast<int>(keyframes_.size()); ++k) {
    if (!keyframes_[k].view.empty()) TryLoops(k, &outcome);
  }
  outcome.given_up_views = LimitKeyframes(options_.max_view_bytes, &keyframes_, &index_).size();
  if (graph_.edges.size() > loops_before + odometry_edges) Optimise(&outcome);
  return outcome;
}

void LoopCloser::Add(Keyframe keyframe) {
  graph_.poses.push_back({keyframe.frame_index, keyframe.world_from_camera, false});
  keyframes_.push_back(std::move(keyframe));
}

void LoopCloser::SetPoses(const std::vector<Rigid3d>& world_from_keyframe) {
  for (std::size_t k = 0; k < keyframes_.size(); ++k) {
    keyframes_[k].world_from_camera = graph_.poses[k].world_from_pose = world_from_keyframe[k];
  }
}

void LoopCloser::TryLoops(int source, LoopOutcome* outcome) {
  for (LoopAttempt& attempt : finder_(source, keyframes_, index_)) {
    attempt.proposal.source = source;
    const bool accepted = attempt.verdict.accepted();
    outcome->attempts.push_back({keyframes_[source].frame_index,
                                 keyframes_[attempt.proposal.target].frame_index, attempt,
                                 accepted});
    if (accepted) graph_.edges.push_back(LoopEdge(attempt, options_.noise));
  }
  index_.Add(source, keyframes_[source].view);
}

// From odometry each time, so that no former error of judgement remains.
void LoopCloser::Optimise(LoopOutcome* outcome) const {
  PoseGraph graph = graph_;
  const PoseGraphSummary summary = OptimizePoseGraph(options_.graph, &graph);
  if (!summary.Succeeded()) return;
  outcome->optimised = true;
  outcome->loops_in_graph = LoopsInGraph(graph, summary);
  for (const PoseGraphPose& pose : graph.poses) {
    outcome->world_from_keyframe.push_back(pose.world_from_pose);
  }
}

void LoopCloser::Recalibrate(const std::vector<Rigid3d>& before,
                             const std::vector<Rigid3d>& after) {
  surfit::Recalibrate(before, after, &graph_.edges);
}

Relocalization LoopCloser::Find(const ColoredView& view,
                                const std::vector<Rigid3d>& world_from_keyframe) {
  task_.Wait();
  const TraceSlice slice("relocalize");
  for (std::size_t k = 0; k < keyframes_.size(); ++k) {
    keyframes_[k].world_from_camera = world_from_keyframe[k];
  }
  return Relocalize(MakePlaceView(view.pyramid, view.color, options_.views), keyframes_, index_,
                    options_.relocalize);
}

}  // namespace surfit
