#include "loop_closure/loop_closer.h"

#include <algorithm>
#include <limits>
#include <memory>
#include <mutex>
#include <utility>

#include "core/trace.h"
#include "loop_closure/edge_information.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

// Without loop closure, finds loops between submaps only.
LoopFinder DefaultFinder(const LoopOptions& loops) {
  FindLoopsOptions options = loops.find;
  if (!loops.enabled) options.min_gap = std::numeric_limits<int>::max();
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

// Computes a view at the first call, then releases the source data. Two threads can compute the
// same view at the same time: a wait for a thread of lower priority would take longer.
class LazyView {
 public:
  LazyView(ColoredView source, const InverseDepthField& field, const PlaceViewOptions& options)
      : source_(std::make_shared<ColoredView>(std::move(source))),
        field_(field),
        options_(options) {}

  PlaceView Get() {
    std::shared_ptr<const ColoredView> source;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (!source_) return view_;
      source = source_;
    }
    PlaceView view = MakePlaceView(source->pyramid, source->color, options_);
    view.field = field_;
    const std::lock_guard<std::mutex> lock(mutex_);
    view_ = view;
    source_.reset();
    return view;
  }

 private:
  std::mutex mutex_;
  std::shared_ptr<const ColoredView> source_;
  InverseDepthField field_;
  PlaceViewOptions options_;
  PlaceView view_;
};

}  // namespace

PoseGraphEdge LoopEdge(const LoopVerification& attempt, const EdgeNoise& noise) {
  PoseGraphEdge edge;
  edge.a = static_cast<std::size_t>(attempt.proposal.target);
  edge.b = static_cast<std::size_t>(attempt.proposal.source);
  edge.a_from_b = attempt.verdict.target_from_source;
  edge.information = LoopInformation(attempt.verdict.information, noise);
  edge.loop = true;
  return edge;
}

LoopCloser::LoopCloser(const LoopOptions& options, LoopFinder finder, bool always_in_background)
    : options_(options),
      finder_(finder ? std::move(finder) : DefaultFinder(options)),
      index_(options.places),
      task_(always_in_background) {}

void LoopCloser::AddSettled(std::vector<Keyframe> keyframes) {
  keyframes_ = std::move(keyframes);
  for (std::size_t k = 0; k < keyframes_.size(); ++k) {
    if (!keyframes_[k].view.empty()) index_.Add(static_cast<int>(k), keyframes_[k].view);
  }
  LimitKeyframes(options_.max_view_bytes, &keyframes_, &index_);
  RecalibrateViews(0);
}

// Views with different calibrations would give wrong loop closures.
void LoopCloser::RecalibrateViews(int first) {
  if (!calibration_) return;
  ParallelFor(first, static_cast<int>(keyframes_.size()), 1, [&](int begin, int end) {
    for (int k = begin; k < end; ++k) Recalibrate(*calibration_, &keyframes_[k].view);
  });
}

void LoopCloser::UseCalibration(const std::optional<DepthCalibration>& calibration) {
  calibration_ = calibration;
  RecalibrateViews(0);
}

void LoopCloser::Start(LoopTask task) {
  task_.Start(options_.delay_frames,
              [this, started = std::move(task)]() mutable { return Run(std::move(started)); });
}

LoopOutcome LoopCloser::Run(LoopTask task) {
  const TraceSlice slice("close_loops");
  LoopOutcome outcome;
  const int first = static_cast<int>(keyframes_.size());
  for (const KeyframeForLoops& added : task.added) {
    keyframes_.push_back({added.frame_index, added.stamp_s, {}, added.view()});
  }
  RecalibrateViews(first);
  for (std::size_t k = 0; k < keyframes_.size(); ++k) {
    keyframes_[k].world_from_camera = task.graph.poses[k].world_from_pose;
    keyframes_[k].piece = task.piece_of_keyframe[k];
  }
  const std::size_t edges_before = task.graph.edges.size();
  for (int k = first; k < static_cast<int>(keyframes_.size()); ++k) {
    if (!keyframes_[k].view.empty()) TryLoops(k, &task.graph, &outcome);
  }
  outcome.removed_views = LimitKeyframes(options_.max_view_bytes, &keyframes_, &index_).size();
  if (task.graph.edges.size() > edges_before) Optimise(std::move(task.graph), &outcome);
  return outcome;
}

void LoopCloser::TryLoops(int source, PoseGraph* graph, LoopOutcome* outcome) {
  for (LoopVerification& attempt : finder_(source, keyframes_, index_)) {
    attempt.proposal.source = source;
    const bool accepted = attempt.verdict.accepted();
    outcome->attempts.push_back({keyframes_[source].frame_index,
                                 keyframes_[attempt.proposal.target].frame_index, attempt,
                                 accepted});
    if (accepted) graph->edges.push_back(LoopEdge(attempt, options_.noise));
  }
  index_.Add(source, keyframes_[source].view);
}

void LoopCloser::Optimise(PoseGraph graph, LoopOutcome* outcome) const {
  const PoseGraphSummary summary = OptimizePoseGraph(options_.graph, &graph);
  if (!summary.Succeeded()) return;
  outcome->optimised = true;
  outcome->loops_in_graph = LoopsInGraph(graph, summary);
  for (const PoseGraphPose& pose : graph.poses) {
    outcome->world_from_keyframe.push_back(pose.world_from_pose);
  }
}

Relocalization LoopCloser::Find(const ColoredView& view, int rank,
                                const std::vector<Rigid3d>& world_from_keyframe) {
  task_.Wait();
  const TraceSlice slice("relocalize");
  for (std::size_t k = 0; k < keyframes_.size(); ++k) {
    keyframes_[k].world_from_camera = world_from_keyframe[k];
  }
  RelocalizeOptions options = options_.relocalize;
  options.max_candidates = 1;
  options.first_candidate = rank;
  return Relocalize(MakePlaceView(view.pyramid, view.color, options_.views), keyframes_, index_,
                    options);
}

GlobalRegistrationResult LoopCloser::RegisterTo(const ColoredView& earlier,
                                                const ColoredView& view) const {
  const TraceSlice slice("register_to_last");
  PlaceView views[2];
  ParallelFor(0, 2, 1, [&](int k, int) {
    const ColoredView& made = k == 0 ? view : earlier;
    views[k] = MakePlaceView(made.pyramid, made.color, options_.views);
  });
  return VerifyLoop(views[0], views[1], options_.relocalize.verify);
}

ViewOfKeyframe ViewOf(ColoredView source, const InverseDepthField& field,
                      const PlaceViewOptions& options) {
  auto made = std::make_shared<LazyView>(std::move(source), field, options);
  return [made] { return made->Get(); };
}

}  // namespace surfit
