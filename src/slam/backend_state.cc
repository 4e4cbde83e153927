// How a backend goes on from what another one has known.

#include <algorithm>
#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

#include "slam/calibrator.h"
#include "slam/loop_closer.h"
#include "surfit/slam/backend.h"
#include "surfit/slam/slam_state.h"

namespace surfit {
namespace {

// The loops of a state that are edges, as far as edges tell.
LoopRecord RecordOf(const PoseGraphEdge& edge, const std::vector<KeyframeLink>& keyframes) {
  LoopRecord record;
  record.source_frame = keyframes[edge.b].frame;
  record.target_frame = keyframes[edge.a].frame;
  record.attempt.proposal.source = static_cast<int>(edge.b);
  record.attempt.proposal.target = static_cast<int>(edge.a);
  record.attempt.verdict.reason = FarReason::kAccepted;
  record.attempt.verdict.target_from_source = edge.a_from_b;
  record.is_kept = true;
  return record;
}

}  // namespace

void Backend::GoOnFrom(SlamState* state, StateUse use) {
  frames_ = std::move(state->frames);
  TakeLinks(state->keyframes);
  edges_ = std::move(state->edges);
  std::size_t loop = 0;
  for (const PoseGraphEdge& edge : edges_) {
    if (!edge.loop) continue;
    loops_.push_back(RecordOf(edge, state->keyframes));
    loops_.back().in_graph = state->loops_in_graph[loop++];
  }
  const PosedFrame& last = frames_[frame_of_keyframe_.back()];
  last_keyframe_ = {last.index, last.stamp_s, last.world_from_camera, state->views.back()};
  const bool goes_on = use == StateUse::kContinue;
  TakeKeyframes(std::move(state->views),
                goes_on ? state->settled_keyframes : frame_of_keyframe_.size());
  if (goes_on && !waiting_.empty()) StartTask();
  if (calibrator_) {
    if (!goes_on) state->calibration_frames.clear();
    calibrator_->GoOnFrom(state->calibration, state->color_latency_s,
                          std::move(state->calibration_frames));
  }
}

void Backend::TakeLinks(const std::vector<KeyframeLink>& links) {
  std::size_t frame = 0;
  for (const KeyframeLink& link : links) {
    while (frames_[frame].index != link.frame) ++frame;
    int parent = KeyframeLink::kNone;
    if (link.parent_frame != KeyframeLink::kNone) {
      const auto at = std::lower_bound(
          links.begin(), links.end(), link.parent_frame,
          [](const KeyframeLink& other, int parent_frame) { return other.frame < parent_frame; });
      parent = static_cast<int>(at - links.begin());
    }
    frame_of_keyframe_.push_back(static_cast<int>(frame));
    parent_of_keyframe_.push_back(parent);
    submap_of_keyframe_.push_back(link.submap);
    submap_ = std::max(submap_, link.submap);
  }
  stretch_ = frames_.back().stretch;
  begins_submap_ = false;
}

// Those that are not settled wait for a task, with their edges of odometry.
void Backend::TakeKeyframes(std::vector<PlaceView> views, std::size_t settled) {
  std::vector<Keyframe> keyframes;
  for (std::size_t k = 0; k < views.size(); ++k) {
    const PosedFrame& frame = frames_[frame_of_keyframe_[k]];
    Keyframe keyframe = {frame.index, frame.stamp_s, frame.world_from_camera, {}};
    if (k < settled) {
      keyframe.view = std::move(views[k]);
      keyframes.push_back(std::move(keyframe));
    } else {
      const auto view = std::make_shared<PlaceView>(std::move(views[k]));
      waiting_.push_back({std::move(keyframe), [view] { return *view; }, {}});
    }
  }
  std::vector<PoseGraphEdge> edges;
  for (const PoseGraphEdge& edge : edges_) {
    if (edge.b < settled) {
      edges.push_back(edge);
    } else {
      waiting_[edge.b - settled].edges.push_back(edge);
    }
  }
  closer_->GoOnFrom(std::move(keyframes), std::move(edges));
}

}  // namespace surfit
