#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "io/files/places_file.h"
#include "surfit/loop_closure/loop_closure.h"
#include "surfit/optimization/pose_graph.h"

namespace surfit {

struct GraphFragment {
  RunPlaces places;  // in the world frame of the fragment; features and images are not used
  std::vector<Rigid3d> solved;            // world_from_camera of the keyframes; empty: disconnected
  std::vector<PoseGraphEdge> kept_loops;  // inlier loop closures within the fragment
};

// Accepted link between two keyframes, by positions of fragments and keyframes.
struct GraphLink {
  std::size_t source = 0, target = 0;
  int source_keyframe = 0, target_keyframe = 0;
  Rigid3d target_from_source;
  Matrix6d information = Matrix6d::Zero();  // from the verification
  double overlap_ratio = 0;
  bool is_rejected = false;  // outlier, or link of a disconnected fragment
};

// Pose graph of the keyframes of all fragments.
class ScanGraph {
 public:
  // `fragments` contains std::nullopt for missing fragments, and `recordings` the recording of each
  // fragment. Consecutive fragments of a recording share frames.
  ScanGraph(std::vector<std::optional<RunPlaces>> fragments, std::vector<int> recordings,
            std::vector<GraphLink> links, const LoopOptions& options);

  // Returns false if the solver fails.
  bool Solve();

  // std::nullopt: missing fragment.
  const std::vector<std::optional<GraphFragment>>& fragments() const { return fragments_; }
  const std::vector<GraphLink>& links() const { return links_; }
  // Residual of a link at the optimised poses; std::nullopt for a disconnected fragment.
  std::optional<Rigid3d> Residual(const GraphLink& link) const;
  bool IsDisconnected(std::size_t fragment) const {
    return fragments_[fragment] && fragments_[fragment]->solved.empty();
  }
  // Poses of all frames of a recording in the largest part, ascending. In frames that two fragments
  // share, the poses are blended.
  std::vector<PosedFrame> Frames(int recording) const;

 private:
  struct Connection {
    std::size_t a = 0, b = 0;
    Rigid3d a_from_b;
    std::optional<PoseGraphEdge> joint;  // edge of a shared frame; keyframes by position
    std::size_t link = 0;                // position of the link, without `joint`
  };

  std::vector<Connection> Connections() const;
  std::optional<Connection> Joint(std::size_t a, std::size_t b) const;
  // Returns the connected part of each fragment. `world_from_fragment` chains the connections that
  // join two parts, and ignores the other connections.
  std::vector<int> Parts(const std::vector<Connection>& connections,
                         std::vector<Rigid3d>* world_from_fragment) const;
  int LargestPart(const std::vector<int>& parts) const;

  std::vector<std::optional<GraphFragment>> fragments_;
  std::vector<int> recordings_;
  std::vector<GraphLink> links_;
  LoopOptions options_;
};

}  // namespace surfit
