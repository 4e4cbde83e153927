#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "io/files/places_file.h"
#include "surfit/loop_closure/loop_closure.h"
#include "surfit/optimization/pose_graph.h"

namespace surfit {

// A fragment of a scan in the graph.
struct GraphFragment {
  RunPlaces places;             // in a world of its own; features and images are not needed
  std::vector<Rigid3d> solved;  // world_from_camera of its keyframes; empty if it is apart
  std::vector<PoseGraphEdge> kept_loops;  // of its own edges those that fit all others
};

// A verified pair of keyframes that was accepted, by positions of fragments and of their keyframes.
struct GraphLink {
  std::size_t source = 0, target = 0;
  int source_keyframe = 0, target_keyframe = 0;
  Rigid3d target_from_source;
  Matrix6d information = Matrix6d::Zero();  // the verdict's
  double overlap_share = 0;
  bool is_left_out = false;  // it does not fit the others, or joins what is apart
};

// The pose graph over the keyframes of all fragments.
class ScanGraph {
 public:
  // With each fragment's recording: neighbours of one share frames.
  ScanGraph(std::vector<std::optional<RunPlaces>> fragments, std::vector<int> recordings,
            std::vector<GraphLink> links, const LoopOptions& options);

  // False where the solver gave up.
  bool Solve();

  // Nothing for a fragment that is missing.
  const std::vector<std::optional<GraphFragment>>& fragments() const { return fragments_; }
  const std::vector<GraphLink>& links() const { return links_; }
  // By how much a link's measurement misses the poses of its keyframes; nothing if one is apart.
  std::optional<Rigid3d> Residual(const GraphLink& link) const;
  bool IsApart(std::size_t fragment) const {
    return fragments_[fragment] && fragments_[fragment]->solved.empty();
  }
  // All frames of a recording that are in the largest part, ascending. Between two neighbours the
  // pose goes from one's to the other's over the frames that they share.
  std::vector<PosedFrame> Frames(int recording) const;

 private:
  // How two fragments' worlds lie to each other.
  struct Connection {
    std::size_t a = 0, b = 0;
    Rigid3d a_from_b;
    std::optional<PoseGraphEdge>
        joint;             // by shared frames: keyframes by their fragments' positions
    std::size_t link = 0;  // else
  };

  std::vector<Connection> Connections() const;
  std::optional<Connection> Joint(std::size_t a, std::size_t b) const;
  // Of each fragment, its part: connections that come first count first.
  std::vector<int> Parts(const std::vector<Connection>& connections,
                         std::vector<Rigid3d>* world_from_fragment) const;
  int LargestPart(const std::vector<int>& parts) const;

  std::vector<std::optional<GraphFragment>> fragments_;
  std::vector<int> recordings_;
  std::vector<GraphLink> links_;
  LoopOptions options_;
};

}  // namespace surfit
