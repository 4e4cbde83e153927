#include <array>
#include <cmath>
#include <deque>
#include <map>

#include "optimization/pose_graph/optimize_pose_graph.h"
#include "registration/solvers/decompositions.h"

namespace surfit {
namespace {

struct LinkedPose {
  std::size_t pose;
  Rigid3d pose_from_neighbour;
  bool loop;
};

std::vector<std::vector<LinkedPose>> NeighboursOf(const PoseGraph& graph) {
  std::vector<std::vector<LinkedPose>> neighbours(graph.poses.size());
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
    result_.roots.assign(graph.poses.size(), false);
  }

  void Hold(std::size_t pose) {
    if (reached_[pose]) return;
    result_.roots[pose] = true;
    Place(pose, graph_.poses[pose].world_from_pose);
  }

  // Chains all reachable poses, along odometry edges first.
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
    for (const LinkedPose& n : neighbours_[pose]) {
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
  std::vector<std::vector<LinkedPose>> neighbours_;
  std::vector<bool> reached_;
  std::deque<Step> open_;
  ChainedPoses result_;
};

// Rotation and translation that move points p_i to q_i with the smallest sum of k |R p_i + t -
// q_i|^2 (Kabsch). In SE(2), the rotation is about z.
Rigid3d FitPoints(const std::vector<Eigen::Vector3d>& p, const std::vector<Eigen::Vector3d>& q,
                  bool planar) {
  Eigen::Vector3d mean_p = Eigen::Vector3d::Zero(), mean_q = mean_p;
  for (std::size_t i = 0; i < p.size(); ++i) mean_p += p[i] / p.size(), mean_q += q[i] / p.size();
  Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < p.size(); ++i) {
    moments += (q[i] - mean_q) * (p[i] - mean_p).transpose();
  }
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  if (planar) {
    const double angle = std::atan2(moments(1, 0) - moments(0, 1), moments(0, 0) + moments(1, 1));
    rotation = Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  } else if (p.size() > 1) {
    rotation = NearestRotation(moments);
  }
  return {rotation, mean_q - rotation * mean_p};
}

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
  ChainedPoses chained = chain.Take();
  PoseSets sets(graph.poses.size());
  for (const PoseGraphEdge& edge : graph.edges) sets.Join(edge.a, edge.b);
  std::vector<bool> has_prior(graph.poses.size(), false);
  for (const PoseGraphPrior& prior : graph.priors) has_prior[sets.Find(prior.pose)] = true;
  for (const PoseGraphPosition& prior : graph.positions) has_prior[sets.Find(prior.pose)] = true;
  for (std::size_t i = 0; i < graph.poses.size(); ++i) {
    chained.component.push_back(sets.Find(i));
    chained.held.push_back(graph.poses[i].fixed ||
                           (chained.roots[i] && !has_prior[chained.component[i]]));
  }
  return chained;
}

void AlignWithPriors(const PoseGraph& graph, const ChainedPoses& chained,
                     std::vector<Rigid3d>* world_from_pose) {
  std::vector<Rigid3d>& poses = *world_from_pose;
  const std::size_t count = poses.size();
  std::vector<bool> is_done(count, false);
  std::vector<Rigid3d> move(count);  // by component
  for (std::size_t i = 0; i < count; ++i) {
    if (graph.poses[i].fixed) is_done[chained.component[i]] = true;
  }
  for (const PoseGraphPrior& prior : graph.priors) {
    const std::size_t component = chained.component[prior.pose];
    if (is_done[component] || prior.information.diagonal().head<3>().isZero(0)) continue;
    is_done[component] = true;
    move[component] =
        prior.world_from_sensor * (poses[prior.pose] * prior.pose_from_sensor).Inverse();
  }
  std::map<std::size_t, std::array<std::vector<Eigen::Vector3d>, 2>> points;
  for (const PoseGraphPosition& position : graph.positions) {
    const std::size_t component = chained.component[position.pose];
    if (is_done[component]) continue;
    points[component][0].push_back(poses[position.pose] * position.sensor_in_pose);
    points[component][1].push_back(position.sensor_in_world);
  }
  for (const auto& [component, pair] : points) {
    move[component] = FitPoints(pair[0], pair[1], graph.planar);
  }
  for (std::size_t i = 0; i < count; ++i) poses[i] = move[chained.component[i]] * poses[i];
}

}  // namespace surfit
