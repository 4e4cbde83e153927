#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "surfit/geometry/rigid3.h"
#include "surfit/geometry/trajectory.h"
#include "surfit/mapping/move_map.h"
#include "surfit/optimization/pose_graph.h"
#include "surfit/registration/global_registration.h"

namespace surfit {

// Frames with poses, keyframes, pose graph edges and loop records, and the store that owns them.
// Depends on optimization and mapping, not on tracking, loop closure and calibration.

struct PosedFrame {
  int index = 0;
  double stamp_s = 0;
  Rigid3d world_from_camera;  // with all corrections so far
  int keyframe = 0;           // position of the last keyframe, or of this frame if it is a keyframe
  int segment = 0;            // trajectory segment: relocalisation starts a new number
};

// Keyframe, by frame indices.
struct KeyframeLink {
  int frame = 0;
  int parent_frame = kNone;  // keyframe at the other end of the odometry or relocalisation edge
  int submap = 0;

  static constexpr int kNone = -1;
};

// Loop candidate: two keyframes that may show the same place.
struct LoopCandidate {
  int source = 0, target = 0;  // positions of the later and the earlier keyframe
  double similarity = 0;       // by place recognition; 0: proposed by pose
  std::optional<Rigid3d> target_from_source_prior;  // by the estimated poses of near keyframes
};

// Loop candidate with its verification.
struct LoopVerification {
  LoopCandidate proposal;
  GlobalRegistrationResult verdict;
};

// Loop candidate with its place in the pose graph.
struct LoopRecord {
  int source_frame = 0, target_frame = 0;
  LoopVerification attempt;
  bool in_graph = false;  // verified, and no outlier of the last optimisation
  bool is_kept = false;   // from a saved state: only pair, pose and acceptance are valid
};

// Saved content of a store.
struct StoredPoses {
  std::vector<PosedFrame> frames;       // by ascending index, not empty
  std::vector<KeyframeLink> keyframes;  // by ascending frame; parents precede their children
  std::vector<PoseGraphEdge> edges;     // between keyframe positions
  std::vector<bool> loops_in_graph;     // per loop edge: no outlier
  std::size_t settled_keyframes = 0;    // number of keyframes with a completed search for loops
};

// Changes the measurements of edges with their keyframe poses, so that the residuals of all edges
// are unchanged. Both vectors have one pose per keyframe.
void Recalibrate(const std::vector<Rigid3d>& world_from_keyframe_before,
                 const std::vector<Rigid3d>& world_from_keyframe_after,
                 std::vector<PoseGraphEdge>* edges);

// Owns frames, keyframes, edges and loop records. Background tasks of loop closure and calibration
// work on snapshots; their results are applied here. Indices and saved states are not checked.
// References are valid until the next change. Not thread-safe.
class PoseStore {
 public:
  PoseStore() = default;
  explicit PoseStore(StoredPoses state);

  const std::vector<PosedFrame>& frames() const { return frames_; }
  const std::vector<KeyframeLink>& keyframes() const { return keyframes_; }
  // Odometry, and verified loops including outliers.
  const std::vector<PoseGraphEdge>& edges() const { return edges_; }
  const std::vector<LoopRecord>& loops() const { return loops_; }
  std::vector<bool> loops_in_graph() const;  // per verified loop
  Trajectory trajectory() const;

  // Frame of a keyframe, given its position.
  const PosedFrame& FrameOf(int keyframe) const { return frames_[frame_of_keyframe_[keyframe]]; }
  // Position of the parent, or KeyframeLink::kNone.
  int ParentOf(int keyframe) const;
  std::vector<Rigid3d> KeyframePoses() const;
  // Positions of keyframes in frames().
  const std::vector<int>& frame_of_keyframe() const { return frame_of_keyframe_; }

  int submap_count() const;
  // Number of submaps that no loop connects to the first submap.
  std::size_t CountDisconnectedSubmaps() const;

  // Adds a frame with a larger index than all frames before. It belongs to the last keyframe.
  void AddFrame(int index, double stamp_s, const Rigid3d& world_from_camera, int segment);
  // Makes the last frame a keyframe. Without a parent (KeyframeLink::kNone) it begins a submap.
  void MakeKeyframe(int parent);
  void AddEdge(const PoseGraphEdge& edge) { edges_.push_back(edge); }
  // Adds a candidate. `edge` is the edge of a verified loop.
  void AddLoop(LoopRecord record, const std::optional<PoseGraphEdge>& edge);
  // Marks the outliers of an optimisation, per verified loop.
  void SetLoopsInGraph(const std::vector<bool>& in_graph);

  // Snapshot of the pose graph for a task of loop closure. Its edges precede all later edges, so
  // that the sums of the optimisation do not depend on the duration of tasks.
  PoseGraph Snapshot();

  void Move(const FrameCorrections& corrections);
  // Moves the edges after a calibration has moved the frames.
  void RecalibrateEdges(const std::vector<Rigid3d>& world_from_keyframe_before) {
    Recalibrate(world_from_keyframe_before, KeyframePoses(), &edges_);
  }

 private:
  const PosedFrame& FrameAt(int frame_index) const;

  std::vector<PosedFrame> frames_;
  std::vector<KeyframeLink> keyframes_;
  std::vector<int> frame_of_keyframe_;
  std::vector<PoseGraphEdge> edges_;
  std::vector<std::size_t> graph_edges_;  // positions of the edges in the order of snapshots
  std::vector<LoopRecord> loops_;
};

}  // namespace surfit
