#include "optimization/chained_poses.h"

#include <deque>

namespace surfit {
namespace {

// An edge as seen from one of its ends.
struct Neighbour {
  std::size_t pose;
  Rigid3d pose_from_neighbour;
  bool loop;
};

std::vector<std::vector<Neighbour>> NeighboursOf(const PoseGraph& graph) {
  std::vector<std::vector<Neighbour>> neighbours(graph.poses.size());
  for (const PoseGraphEdge& edge : graph.edges) {
    neighbours[edge.a].push_back({edge.b, edge.a_from_b, edge.loop});
    neighbours[edge.b].push_back({edge.a, edge.a_from_b.Inverse(), edge.loop});
  }
  return neighbours;
}

class Chain {
 public:
  explicit Chain(const PoseGraph& graph)
      : graph_(graph), neighbours_(NeighboursOf(graph)), reached_(graph.poses.size(), false) {
    result_.world_from_pose.resize(graph.poses.size());
    result_.held.assign(graph.poses.size(), false);
  }

  void Hold(std::size_t pose) {
    if (reached_[pose]) return;
    result_.held[pose] = true;
    Place(pose, graph_.poses[pose].world_from_pose);
  }

  // Goes on from where poses are, odometry first.
  void Spread() {
    while (!open_.empty()) {
      const auto [pose, world_from_pose] = open_.front();
      open_.pop_front();
      if (!reached_[pose]) Place(pose, world_from_pose);
    }
  }

  ChainedPoses Take() { return std::move(result_); }

 private:
  void Place(std::size_t pose, const Rigid3d& world_from_pose) {
    reached_[pose] = true;
    result_.world_from_pose[pose] = world_from_pose;
    for (const Neighbour& n : neighbours_[pose]) {
      if (reached_[n.pose]) continue;
      const Step step{n.pose, world_from_pose * n.pose_from_neighbour};
      n.loop ? open_.push_back(step) : open_.push_front(step);
    }
  }

  struct Step {
    std::size_t pose;
    Rigid3d world_from_pose;
  };
  const PoseGraph& graph_;
  std::vector<std::vector<Neighbour>> neighbours_;
  std::vector<bool> reached_;
  std::deque<Step> open_;
  ChainedPoses result_;
};

}  // namespace

ChainedPoses ChainPoses(const PoseGraph& graph) {
  Chain chain(graph);
  for (std::size_t i = 0; i < graph.poses.size(); ++i) {
    if (graph.poses[i].fixed) chain.Hold(i);
  }
  for (std::size_t i = 0; i < graph.poses.size(); ++i) {
    chain.Spread();
    chain.Hold(i);
  }
  chain.Spread();
  return chain.Take();
}

}  // namespace surfit
