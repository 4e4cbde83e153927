#include "surfit/poses/pose_store.h"

#include <algorithm>
#include <utility>

namespace surfit {
namespace {

LoopRecord RecordOf(const PoseGraphEdge& edge, const std::vector<KeyframeLink>& keyframes) {
  LoopRecord record;
  record.source_frame = keyframes[edge.b].frame;
  record.target_frame = keyframes[edge.a].frame;
  record.attempt.proposal.source = static_cast<int>(edge.b);
  record.attempt.proposal.target = static_cast<int>(edge.a);
  record.attempt.verdict.reason = GlobalRegistrationReason::kAccepted;
  record.attempt.verdict.target_from_source = edge.a_from_b;
  record.is_kept = true;
  return record;
}

}  // namespace

void Recalibrate(const std::vector<Rigid3d>& world_from_keyframe_before,
                 const std::vector<Rigid3d>& world_from_keyframe_after,
                 std::vector<PoseGraphEdge>* edges) {
  const std::vector<Rigid3d>&before = world_from_keyframe_before,
        &after = world_from_keyframe_after;
  for (PoseGraphEdge& edge : *edges) {
    const Rigid3d error = before[edge.b].Inverse() * before[edge.a] * edge.a_from_b;
    edge.a_from_b = after[edge.a].Inverse() * after[edge.b] * error;
  }
}

PoseStore::PoseStore(StoredPoses state)
    : frames_(std::move(state.frames)),
      keyframes_(std::move(state.keyframes)),
      edges_(std::move(state.edges)) {
  std::size_t frame = 0;
  for (const KeyframeLink& keyframe : keyframes_) {
    while (frames_[frame].index != keyframe.frame) ++frame;
    frame_of_keyframe_.push_back(static_cast<int>(frame));
  }
  std::size_t loop = 0;
  for (std::size_t i = 0; i < edges_.size(); ++i) {
    if (edges_[i].b < state.settled_keyframes) graph_edges_.push_back(i);
    if (!edges_[i].loop) continue;
    loops_.push_back(RecordOf(edges_[i], keyframes_));
    loops_.back().in_graph = state.loops_in_graph[loop++];
  }
}

std::vector<bool> PoseStore::loops_in_graph() const {
  std::vector<bool> in_graph;
  for (const LoopRecord& loop : loops_) {
    if (loop.attempt.verdict.accepted()) in_graph.push_back(loop.in_graph);
  }
  return in_graph;
}

Trajectory PoseStore::trajectory() const {
  Trajectory trajectory;
  for (const PosedFrame& frame : frames_) {
    trajectory.push_back({frame.stamp_s, frame.world_from_camera});
  }
  return trajectory;
}

const PosedFrame& PoseStore::FrameAt(int frame_index) const {
  return *std::lower_bound(frames_.begin(), frames_.end(), frame_index,
                           [](const PosedFrame& frame, int index) { return frame.index < index; });
}

int PoseStore::ParentOf(int keyframe) const {
  const int parent = keyframes_[keyframe].parent_frame;
  return parent == KeyframeLink::kNone ? KeyframeLink::kNone : FrameAt(parent).keyframe;
}

std::vector<Rigid3d> PoseStore::KeyframePoses() const {
  std::vector<Rigid3d> poses;
  for (const int frame : frame_of_keyframe_) poses.push_back(frames_[frame].world_from_camera);
  return poses;
}

int PoseStore::submap_count() const {
  int count = 0;
  for (const KeyframeLink& keyframe : keyframes_) count = std::max(count, keyframe.submap + 1);
  return count;
}

// Each pass propagates connections over the loops. One pass per submap is sufficient.
std::size_t PoseStore::CountDisconnectedSubmaps() const {
  const auto submap_at = [&](int frame_index) {
    return keyframes_[FrameAt(frame_index).keyframe].submap;
  };
  std::vector<bool> connected(static_cast<std::size_t>(submap_count()), false);
  if (!connected.empty()) connected[0] = true;
  for (std::size_t pass = 0; pass < connected.size(); ++pass) {
    for (const LoopRecord& loop : loops_) {
      if (!loop.in_graph) continue;
      const int a = submap_at(loop.source_frame), b = submap_at(loop.target_frame);
      if (connected[a] || connected[b]) connected[a] = connected[b] = true;
    }
  }
  return static_cast<std::size_t>(std::count(connected.begin(), connected.end(), false));
}

void PoseStore::AddFrame(int index, double stamp_s, const Rigid3d& world_from_camera, int segment) {
  frames_.push_back(
      {index, stamp_s, world_from_camera, static_cast<int>(keyframes_.size()) - 1, segment});
}

void PoseStore::MakeKeyframe(int parent) {
  KeyframeLink link;
  link.frame = frames_.back().index;
  if (parent == KeyframeLink::kNone) {
    link.submap = submap_count();
  } else {
    link.parent_frame = FrameOf(parent).index;
    link.submap = keyframes_[parent].submap;
  }
  frames_.back().keyframe = static_cast<int>(keyframes_.size());
  frame_of_keyframe_.push_back(static_cast<int>(frames_.size()) - 1);
  keyframes_.push_back(link);
}

void PoseStore::AddLoop(LoopRecord record, const std::optional<PoseGraphEdge>& edge) {
  if (edge) {
    graph_edges_.push_back(edges_.size());
    edges_.push_back(*edge);
  }
  loops_.push_back(std::move(record));
}

void PoseStore::SetLoopsInGraph(const std::vector<bool>& in_graph) {
  std::size_t loop = 0;
  for (LoopRecord& record : loops_) {
    if (record.attempt.verdict.accepted()) record.in_graph = in_graph[loop++];
  }
}

PoseGraph PoseStore::Snapshot() {
  std::vector<bool> is_ordered(edges_.size(), false);
  for (const std::size_t i : graph_edges_) is_ordered[i] = true;
  std::vector<std::size_t> added;
  for (std::size_t i = 0; i < edges_.size(); ++i) {
    if (!is_ordered[i]) added.push_back(i);
  }
  std::stable_sort(added.begin(), added.end(),
                   [&](std::size_t i, std::size_t j) { return edges_[i].b < edges_[j].b; });
  graph_edges_.insert(graph_edges_.end(), added.begin(), added.end());
  PoseGraph graph;
  for (const int frame : frame_of_keyframe_) {
    graph.poses.push_back({frames_[frame].index, frames_[frame].world_from_camera, false});
  }
  for (const std::size_t i : graph_edges_) graph.edges.push_back(edges_[i]);
  return graph;
}

void PoseStore::Move(const FrameCorrections& corrections) {
  for (PosedFrame& frame : frames_) {
    frame.world_from_camera = corrections.At(frame.index) * frame.world_from_camera;
  }
}

}  // namespace surfit
