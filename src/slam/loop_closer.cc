#include "slam/loop_closer.h"

#include <algorithm>
#include <utility>

#include "slam/edge_information.h"
#include "surfit/core/trace.h"
#include "surfit/places/place_index.h"

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

LoopCloser::LoopCloser(const LoopOptions& options, LoopFinder finder)
    : options_(options),
      finder_(finder ? std::move(finder) : OwnFinder(options.find)),
      index_(options.places) {}

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
    Add(std::move(added));
  }
  SetPoses(task.world_from_keyframe);
  for (int k = first; k < static_cast<int>(keyframes_.size()); ++k) TryLoops(k, &outcome);
  outcome.given_up_views = LimitKeyframes(options_.max_view_bytes, &keyframes_, &index_).size();
  if (graph_.edges.size() > loops_before + odometry_edges) Optimise(&outcome);
  return outcome;
}

void LoopCloser::Add(NewKeyframe added) {
  added.keyframe.view = MakePlaceView(added.view.pyramid, added.view.color, options_.views);
  graph_.poses.push_back({added.keyframe.frame_index, added.keyframe.world_from_camera, false});
  graph_.edges.insert(graph_.edges.end(), added.edges.begin(), added.edges.end());
  keyframes_.push_back(std::move(added.keyframe));
}

void LoopCloser::SetPoses(const std::vector<Rigid3d>& world_from_keyframe) {
  for (std::size_t k = 0; k < keyframes_.size(); ++k) {
    keyframes_[k].world_from_camera = graph_.poses[k].world_from_pose = world_from_keyframe[k];
  }
}

void LoopCloser::TryLoops(int source, LoopOutcome* outcome) {
  for (const LoopAttempt& attempt : finder_(source, keyframes_, index_)) {
    const FarVerdict& verdict = attempt.verdict;
    outcome->attempts.push_back({keyframes_[source].frame_index,
                                 keyframes_[attempt.proposal.target].frame_index, attempt,
                                 verdict.accepted()});
    if (!verdict.accepted()) continue;
    PoseGraphEdge edge;
    edge.a = static_cast<std::size_t>(attempt.proposal.target);
    edge.b = static_cast<std::size_t>(source);
    edge.a_from_b = verdict.target_from_source;
    edge.information = LoopInformation(verdict.information, options_.noise);
    edge.loop = true;
    graph_.edges.push_back(edge);
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

// What an edge has measured differs from its keyframes' poses by as much as before.
void LoopCloser::Recalibrate(const std::vector<Rigid3d>& before,
                             const std::vector<Rigid3d>& after) {
  for (PoseGraphEdge& edge : graph_.edges) {
    const Rigid3d error = before[edge.b].Inverse() * before[edge.a] * edge.a_from_b;
    edge.a_from_b = after[edge.a].Inverse() * after[edge.b] * error;
  }
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
