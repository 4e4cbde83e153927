#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "io/files/places_file.h"
#include "surfit/loop_closure/loop_closure.h"
#include "surfit/optimization/pose_graph.h"

namespace surfit {

// Fragment of a scan before and after the optimisation.
struct GraphFragment {
  RunPlaces places;             // in the world frame of the fragment, without keyframe views
  std::vector<Rigid3d> solved;  // optimised world_from_camera per keyframe; empty: disconnected
  std::vector<PoseGraphEdge> kept_loops;  // inlier loop closures within the fragment
};

// Accepted link between two keyframes, by indices of fragments and keyframes.
struct GraphLink {
  std::size_t source = 0, target = 0;
  int source_keyframe = 0, target_keyframe = 0;
  Rigid3d target_from_source;
  Matrix6d information = Matrix6d::Zero();  // of the left perturbation (1/rad^2, 1/m^2)
  double overlap_ratio = 0;
  bool is_rejected = false;  // outlier, or link to a disconnected fragment
};

// Odometry edge of a fragment that contradicts verified links. The graph does not use the edge.
struct FragmentCut {
  std::size_t fragment = 0;
  std::size_t edge = 0;       // index in RunPlaces::edges
  std::size_t links = 0;      // number of links that are consistent only with the cut
  int before = 0, after = 0;  // frame indices of both keyframes
};

// Pose graph of the keyframes of all fragments. Not thread-safe.
class ScanGraph {
 public:
  // `fragments`: std::nullopt if missing; fragments without keyframes count as missing.
  // `recordings`: index of the recording per fragment. Consecutive fragments of a recording share
  // frames. Both vectors have one value per fragment, in the order of the scan.
  ScanGraph(std::vector<std::optional<RunPlaces>> fragments, std::vector<int> recordings,
            std::vector<GraphLink> links, const LoopOptions& options);

  // Optimises the connected part with the most frames, and rejects outliers. Call once. Returns
  // false, without changes, if the solver fails.
  //
  // Cuts a fragment whose odometry contradicts at least two links that agree. Each interval between
  // the connections of the fragment is tried. The edge with the least information is cut.
  bool Solve();
  // Cuts of Solve(), in the order of the fragments.
  const std::vector<FragmentCut>& cuts() const { return cuts_; }

  // std::nullopt: missing fragment.
  const std::vector<std::optional<GraphFragment>>& fragments() const { return fragments_; }
  const std::vector<GraphLink>& links() const { return links_; }
  // Difference of the measured and the optimised relative pose of a link, in the source camera:
  // measured inverse times optimised. std::nullopt for a disconnected fragment. Call after Solve().
  // Both fragments must exist.
  std::optional<Rigid3d> Residual(const GraphLink& link) const;
  // Returns whether a fragment exists, but is not in the largest part. Call after Solve().
  bool IsDisconnected(std::size_t fragment) const {
    return fragments_[fragment] && fragments_[fragment]->solved.empty();
  }
  // Poses of the frames of a recording in the largest part, in ascending order. Poses of shared
  // frames are blended. Call after Solve(). Empty if all its fragments are disconnected.
  std::vector<PosedFrame> Frames(int recording) const;

 private:
  struct Connection {
    std::size_t a = 0, b = 0;
    Rigid3d a_from_b;
    std::optional<PoseGraphEdge> joint;  // edge by a shared frame, between keyframe indices
    std::size_t link = 0;                // index of the link; only without `joint`
  };

  // Optimised graph of the largest part.
  struct Solution {
    PoseGraph graph;
    std::vector<std::size_t> first_node, first_edge;  // per fragment
    std::vector<bool> is_wrong;                       // per edge: outlier
    std::vector<std::size_t> rejected_links;          // ascending
  };

  std::vector<Connection> Connections() const;
  // Returns std::nullopt if the solver fails.
  std::optional<Solution> SolveWith(const std::vector<FragmentCut>& cuts) const;
  std::vector<FragmentCut> PossibleCuts(const Solution& solution) const;
  // Adds the cut that makes the most links consistent. Returns false without such a cut.
  bool Cut(Solution* solution);
  void Take(const Solution& solution);
  std::optional<Connection> Joint(std::size_t a, std::size_t b) const;
  // `world_from_fragment` receives the poses of the fragments, chained along a spanning forest.
  std::vector<int> Parts(const std::vector<Connection>& connections,
                         std::vector<Rigid3d>* world_from_fragment) const;
  int LargestPart(const std::vector<int>& parts) const;

  std::vector<std::optional<GraphFragment>> fragments_;
  std::vector<int> recordings_;
  std::vector<GraphLink> links_;
  LoopOptions options_;
  std::vector<FragmentCut> cuts_;
};

}  // namespace surfit
