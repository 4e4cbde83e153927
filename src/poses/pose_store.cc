#include "surfit/poses/pose_store.h"

#include <algorithm>
#include <numeric>
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
  record.is_relocalization = keyframes[edge.b].parent_frame == record.target_frame;
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
    loop_of_edge_.resize(i + 1);
    loop_of_edge_[i] = loops_.size();
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

std::vector<int> PoseStore::SubmapOfKeyframe() const {
  std::vector<int> submaps;
  for (const KeyframeLink& keyframe : keyframes_) submaps.push_back(keyframe.submap);
  return submaps;
}

// The root of a set is its first keyframe.
std::vector<int> PoseStore::PieceOfKeyframe() const {
  std::vector<int> root(keyframes_.size());
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&](int k) {
    while (root[k] != k) k = root[k] = root[root[k]];
    return k;
  };
  const auto join = [&](int a, int b) {
    const int root_a = find(a), root_b = find(b);
    root[std::max(root_a, root_b)] = std::min(root_a, root_b);
  };
  std::vector<bool> is_apart(keyframes_.size(), false);  // from its parent
  for (const LoopRecord& loop : loops_) {
    const int source = FrameAt(loop.source_frame).keyframe;
    if (loop.in_graph) join(source, FrameAt(loop.target_frame).keyframe);
    if (!loop.in_graph && loop.is_relocalization) is_apart[source] = true;
  }
  for (int k = 0; k < static_cast<int>(keyframes_.size()); ++k) {
    const int parent = ParentOf(k);
    if (parent != KeyframeLink::kNone && !is_apart[k]) join(k, parent);
  }
  std::vector<int> piece(keyframes_.size());
  int count = 0;
  for (int k = 0; k < static_cast<int>(keyframes_.size()); ++k) {
    piece[k] = root[k] == k ? count++ : piece[find(k)];
  }
  return piece;
}

std::vector<int> PoseStore::PieceOfSubmap() const {
  const std::vector<int> piece_of_keyframe = PieceOfKeyframe();
  std::vector<int> pieces;
  for (std::size_t k = 0; k < keyframes_.size(); ++k) {
    if (keyframes_[k].submap == static_cast<int>(pieces.size())) {
      pieces.push_back(piece_of_keyframe[k]);
    }
  }
  return pieces;
}

std::size_t PoseStore::CountDisconnectedSubmaps() const {
  const std::vector<int> pieces = PieceOfKeyframe();
  return pieces.empty() ? 0 : *std::max_element(pieces.begin(), pieces.end());
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
    AddLoopEdge(*edge);
  }
  loops_.push_back(std::move(record));
}

// The edge joins the next snapshot. A running optimisation has no flag for this edge.
void PoseStore::AddRelocalization(LoopRecord record, const PoseGraphEdge& edge) {
  AddLoopEdge(edge);
  loops_.push_back(std::move(record));
}

// The record of the edge is the next one in loops_.
void PoseStore::AddLoopEdge(const PoseGraphEdge& edge) {
  loop_of_edge_.resize(edges_.size() + 1);
  loop_of_edge_.back() = loops_.size();
  edges_.push_back(edge);
}

void PoseStore::SetLoopsInGraph(const std::vector<bool>& in_graph) {
  std::size_t loop = 0;
  for (const std::size_t i : graph_edges_) {
    if (edges_[i].loop) loops_[loop_of_edge_[i]].in_graph = in_graph[loop++];
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
