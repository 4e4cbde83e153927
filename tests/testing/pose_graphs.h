#pragma once

#include <cmath>
#include <random>
#include <vector>

#include "surfit/optimization/pose_graph.h"
#include "testing/random_pose.h"

namespace surfit::testing {

// Standard deviations of the measurement noise, per component.
struct GraphNoise {
  double rotation_rad = 0.005;
  double translation_m = 0.01;
};

// A pose graph with true poses. Its poses are chained noisy odometry.
struct TrueGraph {
  PoseGraph graph;
  std::vector<Rigid3d> truth;
};

// Noisy measurement of true pose b in pose a. It is a loop unless b is a + 1.
inline PoseGraphEdge MeasuredEdge(const TrueGraph& graph, std::size_t a, std::size_t b,
                                  const GraphNoise& noise, std::mt19937_64* rng) {
  std::normal_distribution<double> normal;
  Eigen::Matrix<double, 6, 1> error, sigmas;
  sigmas << Eigen::Vector3d::Constant(noise.rotation_rad),
      Eigen::Vector3d::Constant(noise.translation_m);
  for (int i = 0; i < 6; ++i) error[i] = sigmas[i] * normal(*rng);
  PoseGraphEdge edge;
  edge.a = a;
  edge.b = b;
  edge.a_from_b = LeftIncrement<double>(error, graph.truth[a].Inverse() * graph.truth[b]);
  edge.information = sigmas.cwiseAbs2().cwiseInverse().asDiagonal();
  edge.loop = b != a + 1;
  return edge;
}

// Adds odometry edges along the true poses, and sets the poses to the odometry. The first pose is
// exact. Requires at least one true pose.
inline void AddOdometry(const GraphNoise& noise, std::mt19937_64* rng, TrueGraph* graph) {
  graph->graph.poses.resize(graph->truth.size());
  graph->graph.poses[0].world_from_pose = graph->truth[0];
  for (std::size_t i = 0; i < graph->truth.size(); ++i) {
    graph->graph.poses[i].id = static_cast<std::int64_t>(i);
    if (i == 0) continue;
    graph->graph.edges.push_back(MeasuredEdge(*graph, i - 1, i, noise, rng));
    graph->graph.poses[i].world_from_pose =
        graph->graph.poses[i - 1].world_from_pose * graph->graph.edges.back().a_from_b;
  }
}

// A pose at `place` with the x axis along `way` and the z axis close to `up`.
inline Rigid3d PoseAlong(const Eigen::Vector3d& place, const Eigen::Vector3d& way,
                         const Eigen::Vector3d& up) {
  Eigen::Matrix3d rotation;
  rotation.col(0) = way.normalized();
  rotation.col(1) = up.cross(way).normalized();
  rotation.col(2) = rotation.col(0).cross(rotation.col(1));
  return {rotation, place};
}

// A spiral on a sphere of radius 100 m, like create_sphere of g2o. Loop edges connect each pose to
// the pose of the previous turn.
inline TrueGraph MakeSphere(int turns, int poses_per_turn, const GraphNoise& noise = {}) {
  std::mt19937_64 rng(1);
  TrueGraph graph;
  const int count = turns * poses_per_turn;
  for (int i = 0; i < count; ++i) {
    const double longitude = 2 * M_PI * i / poses_per_turn;
    const double latitude = M_PI * ((i + 0.5) / count - 0.5);
    const Eigen::Vector3d out(std::cos(latitude) * std::cos(longitude),
                              std::cos(latitude) * std::sin(longitude), std::sin(latitude));
    graph.truth.push_back(
        PoseAlong(100 * out, {-std::sin(longitude), std::cos(longitude), 0}, out));
  }
  AddOdometry(noise, &rng, &graph);
  for (int i = poses_per_turn; i < count; ++i) {
    graph.graph.edges.push_back(MeasuredEdge(graph, i - poses_per_turn, i, noise, &rng));
  }
  return graph;
}

// A spiral on a torus with radii 10 m and 4 m, with the noise of a hand-held sensor.
inline TrueGraph MakeTorus(int turns, int poses_per_turn, const GraphNoise& noise = {0.05, 0.1}) {
  std::mt19937_64 rng(2);
  TrueGraph graph;
  const int count = turns * poses_per_turn;
  for (int i = 0; i < count; ++i) {
    const double small = 2 * M_PI * i / poses_per_turn, large = 2 * M_PI * i / count;
    const Eigen::Vector3d radial(std::cos(large), std::sin(large), 0);
    const Eigen::Vector3d out =
        std::cos(small) * radial + std::sin(small) * Eigen::Vector3d::UnitZ();
    const Eigen::Vector3d way =
        -std::sin(small) * radial + std::cos(small) * Eigen::Vector3d::UnitZ();
    graph.truth.push_back(PoseAlong(10 * radial + 4 * out, way, out));
  }
  AddOdometry(noise, &rng, &graph);
  for (int i = poses_per_turn; i < count; ++i) {
    graph.graph.edges.push_back(MeasuredEdge(graph, i - poses_per_turn, i, noise, &rng));
  }
  return graph;
}

// A path through size^3 grid points at 1 m spacing. Loop edges connect all neighbours.
inline TrueGraph MakeGrid(int size, const GraphNoise& noise = {0.05, 0.1}) {
  std::mt19937_64 rng(3);
  TrueGraph graph;
  std::vector<std::size_t> pose_at(size * size * size);
  const auto index = [&](int x, int y, int z) { return (z * size + y) * size + x; };
  for (int z = 0; z < size; ++z) {
    for (int j = 0; j < size; ++j) {
      const int y = z % 2 == 0 ? j : size - 1 - j;
      const bool back = (z * size + j) % 2 == 1;
      for (int i = 0; i < size; ++i) {
        const int x = back ? size - 1 - i : i;
        pose_at[index(x, y, z)] = graph.truth.size();
        graph.truth.push_back(
            PoseAlong({1. * x, 1. * y, 1. * z}, {back ? -1. : 1., 0, 0}, Eigen::Vector3d::UnitZ()));
      }
    }
  }
  AddOdometry(noise, &rng, &graph);
  const auto join = [&](std::size_t p, std::size_t q) {
    const auto [a, b] = std::minmax(p, q);
    if (b > a + 1) graph.graph.edges.push_back(MeasuredEdge(graph, a, b, noise, &rng));
  };
  for (int z = 0; z < size; ++z) {
    for (int y = 0; y < size; ++y) {
      for (int x = 0; x < size; ++x) {
        const std::size_t here = pose_at[index(x, y, z)];
        if (x + 1 < size) join(here, pose_at[index(x + 1, y, z)]);
        if (y + 1 < size) join(here, pose_at[index(x, y + 1, z)]);
        if (z + 1 < size) join(here, pose_at[index(x, y, z + 1)]);
      }
    }
  }
  return graph;
}

// Adds loops between random poses with random measurements of up to 0.5 rad and 1 m, until they are
// at least this ratio of all loops. Requires `share` < 1, an edge, and more than 10 poses. Returns
// the indices of these edges.
inline std::vector<std::size_t> PlantWrongLoops(double share, TrueGraph* graph) {
  std::mt19937_64 rng(4);
  std::size_t loops = 0;
  for (const PoseGraphEdge& edge : graph->graph.edges) loops += edge.loop;
  std::uniform_int_distribution<std::size_t> any(0, graph->truth.size() - 1);
  std::vector<std::size_t> planted;
  while (planted.size() < share / (1 - share) * loops) {
    const auto [a, b] = std::minmax({any(rng), any(rng)});
    if (b < a + 10) continue;
    PoseGraphEdge edge = graph->graph.edges.back();
    edge.a = a;
    edge.b = b;
    edge.a_from_b = RandomPose(0.5, 1, &rng);
    edge.loop = true;
    planted.push_back(graph->graph.edges.size());
    graph->graph.edges.push_back(edge);
  }
  return planted;
}

}  // namespace surfit::testing
