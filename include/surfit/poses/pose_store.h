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

// Poses, keyframes, pose graph edges and loop records, and the store that owns them.

// Frame with a pose.
struct PosedFrame {
  int index = 0;
  double stamp_s = 0;         // RgbdFrame::stamp_s
  Rigid3d world_from_camera;  // latest estimate
  int keyframe = 0;           // position of its keyframe: itself, or the last keyframe before
  int segment = 0;            // trajectory segment; relocalisation or a new submap starts one
};

// Keyframe and its parent, by frame indices.
struct KeyframeLink {
  int frame = 0;
  int parent_frame = kNone;  // keyframe at the other end of the odometry or relocalisation edge
  int submap = 0;

  static constexpr int kNone = -1;
};

// Keyframe pair that may be a loop closure.
struct LoopCandidate {
  int source = 0, target = 0;  // positions of the later and the earlier keyframe
  double similarity = 0;       // similarity by place recognition; 0: candidate by pose
  // Estimate before verification. std::nullopt: the estimated poses are not near, see FindLoops().
  std::optional<Rigid3d> target_from_source_prior;
};

// Candidate with its verification. Transforms map the camera of the source keyframe to that of the
// target keyframe.
struct LoopVerification {
  LoopCandidate proposal;
  GlobalRegistrationResult verdict;
};

// Verified candidate and its state in the pose graph.
struct LoopRecord {
  int source_frame = 0, target_frame = 0;
  LoopVerification attempt;
  bool in_graph = false;  // verified, and no outlier of the last optimisation
  // from a saved state: only the frames, the pose and the acceptance are valid
  bool is_kept = false;
  bool is_relocalization = false;  // edge of a relocalisation; not from a loop finder
};

// Content of a store, to save and restore it.
struct StoredPoses {
  std::vector<PosedFrame> frames;       // by ascending index, not empty
  std::vector<KeyframeLink> keyframes;  // by ascending frame; parents precede their children
  std::vector<PoseGraphEdge> edges;     // edge indices are keyframe positions
  std::vector<bool> loops_in_graph;     // per loop edge: no outlier
  std::size_t settled_keyframes = 0;    // number of keyframes with a completed loop search
};

// Moves edge measurements with their keyframes, so that all residuals are unchanged up to rounding.
// Both vectors have one pose per keyframe.
void Recalibrate(const std::vector<Rigid3d>& world_from_keyframe_before,
                 const std::vector<Rigid3d>& world_from_keyframe_after,
                 std::vector<PoseGraphEdge>* edges);

// Owns frames, keyframes, edges and loop records. Background tasks use snapshots, and their results
// are applied here. A keyframe position is an index of keyframes(). Indices and saved states are
// not checked. References are valid until the next change. Not thread-safe.
class PoseStore {
 public:
  PoseStore() = default;
  explicit PoseStore(StoredPoses state);

  const std::vector<PosedFrame>& frames() const { return frames_; }
  const std::vector<KeyframeLink>& keyframes() const { return keyframes_; }
  // Odometry, and verified loops and relocalisations including outliers.
  const std::vector<PoseGraphEdge>& edges() const { return edges_; }
  const std::vector<LoopRecord>& loops() const { return loops_; }
  std::vector<bool> loops_in_graph() const;  // per loop edge: true if it is no outlier
  // Poses of all frames.
  Trajectory trajectory() const;

  // Frame of the keyframe at a position.
  const PosedFrame& FrameOf(int keyframe) const { return frames_[frame_of_keyframe_[keyframe]]; }
  // Position of the parent; KeyframeLink::kNone without parent.
  int ParentOf(int keyframe) const;
  // world_from_camera of each keyframe.
  std::vector<Rigid3d> KeyframePoses() const;
  // Per keyframe: index of its frame in frames().
  const std::vector<int>& frame_of_keyframe() const { return frame_of_keyframe_; }

  // Number of submaps, at least 1 after the first keyframe.
  int submap_count() const;
  // KeyframeLink::submap of each keyframe.
  std::vector<int> SubmapOfKeyframe() const;
  // Piece of each keyframe. A piece is a set of keyframes that parents and loops in the graph
  // connect. Poses of different pieces are not comparable. Pieces are numbered by their first
  // keyframe.
  std::vector<int> PieceOfKeyframe() const;
  // Piece of the first keyframe of each submap.
  std::vector<int> PieceOfSubmap() const;
  // Returns the number of pieces without the first piece.
  std::size_t CountDisconnectedSubmaps() const;

  // Adds a frame of the last keyframe. Call MakeKeyframe() directly after the first frame. Its
  // index must be larger than all previous indices.
  void AddFrame(int index, double stamp_s, const Rigid3d& world_from_camera, int segment);
  // Makes the last frame a keyframe. `parent` is a keyframe position. KeyframeLink::kNone: starts a
  // submap.
  void MakeKeyframe(int parent);
  // Adds an odometry edge between keyframe positions.
  void AddEdge(const PoseGraphEdge& edge) { edges_.push_back(edge); }
  // Adds the edge of a relocalisation, with its loop record. PoseGraphEdge::loop must be true.
  void AddRelocalization(LoopRecord record, const PoseGraphEdge& edge);
  // Adds a verified or rejected candidate. `edge`: required for verified loops, std::nullopt for
  // rejected candidates.
  void AddLoop(LoopRecord record, const std::optional<PoseGraphEdge>& edge);
  // Sets the outliers of an optimisation: one flag per verified loop, false for outliers.
  void SetLoopsInGraph(const std::vector<bool>& in_graph);

  // Snapshot of the pose graph for a loop task. Its edges precede all later edges, so that results
  // do not depend on the duration of tasks. Pose ids are frame indices, and no pose is fixed.
  PoseGraph Snapshot();

  // Applies corrections of the world frame to all poses. Measurements of edges do not change.
  void Move(const FrameCorrections& corrections);
  // Call after a calibration has moved the frames. See Recalibrate().
  void RecalibrateEdges(const std::vector<Rigid3d>& world_from_keyframe_before) {
    Recalibrate(world_from_keyframe_before, KeyframePoses(), &edges_);
  }

 private:
  const PosedFrame& FrameAt(int frame_index) const;
  void AddLoopEdge(const PoseGraphEdge& edge);

  std::vector<PosedFrame> frames_;
  std::vector<KeyframeLink> keyframes_;
  std::vector<int> frame_of_keyframe_;
  std::vector<PoseGraphEdge> edges_;
  std::vector<std::size_t> graph_edges_;  // edge indices in the order of snapshots
  std::vector<LoopRecord> loops_;
  std::vector<std::size_t> loop_of_edge_;  // per edge: position in loops_; only of loop edges
};

}  // namespace surfit
