// Optimises a generated pose graph, or the pose graph of a file, with Surfit and with Ceres.
// Ceres is used as in its examples: one residual block with autodiff per edge, and separate blocks
// for position and quaternion. Prints costs and CPU time per iteration.
//
//   pose_graph_time sphere|torus|grid SIZE [MAX_RATIO [ITERATIONS [REPEATS]]]
//   pose_graph_time FILE.g2o
//
// SIZE: number of poses per turn and of turns, or poses along each side of the grid. ITERATIONS:
// maximum of each solver. REPEATS: number of runs, of which the fastest is used; default 3. The
// exit code is 1 if the costs differ, or if the time ratio of Surfit to Ceres is above MAX_RATIO.

#include <ceres/ceres.h>

#include <ctime>
#include <iostream>
#include <string>

#include "surfit/core/error.h"
#include "surfit/io/g2o.h"
#include "surfit/optimization/pose_graph.h"
#include "testing/pose_graphs.h"

namespace surfit::testing {
namespace {

struct Bounds {
  double max_ratio = HUGE_VAL;
  int iterations = PoseGraphOptions().max_iterations;
  int repeats = 3;
};

struct Outcome {
  double cost = 0;
  int iterations = 0;
  double cpu_s = 0;

  double PerIteration() const { return cpu_s / std::max(1, iterations); }
};

double CpuSeconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

// Error of SquaredError(), from positions and quaternions.
struct PlainEdge {
  explicit PlainEdge(const PoseGraphEdge& edge)
      : b_from_a(edge.a_from_b.Inverse()), root(edge.information.llt().matrixU()) {}

  template <typename T>
  bool operator()(const T* t_a, const T* q_a, const T* t_b, const T* q_b, T* residuals) const {
    using Quaternion = Eigen::Quaternion<T>;
    const Rigid3<T> a{Quaternion(q_a), Eigen::Matrix<T, 3, 1>(t_a)};
    const Rigid3<T> b{Quaternion(q_b), Eigen::Matrix<T, 3, 1>(t_b)};
    const Rigid3<T> error = a.Inverse() * b * b_from_a.template cast<T>();
    Eigen::Map<Eigen::Matrix<T, 6, 1>> r(residuals);
    r << QuaternionLog<T>(error.rotation), error.translation;
    r.applyOnTheLeft(root.template cast<T>());
    return true;
  }

  Rigid3d b_from_a;
  Eigen::Matrix<double, 6, 6> root;
};

Outcome SolvePlainly(PoseGraph graph, const PoseGraphOptions& options) {
  ceres::Problem problem;
  auto* manifold = new ceres::EigenQuaternionManifold;
  for (const PoseGraphEdge& edge : graph.edges) {
    Rigid3d &a = graph.poses[edge.a].world_from_pose, &b = graph.poses[edge.b].world_from_pose;
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<PlainEdge, 6, 3, 4, 3, 4>(new PlainEdge(edge)), nullptr,
        a.translation.data(), a.rotation.coeffs().data(), b.translation.data(),
        b.rotation.coeffs().data());
    problem.SetManifold(a.rotation.coeffs().data(), manifold);
    problem.SetManifold(b.rotation.coeffs().data(), manifold);
  }
  Rigid3d& first = graph.poses[0].world_from_pose;
  problem.SetParameterBlockConstant(first.translation.data());
  problem.SetParameterBlockConstant(first.rotation.coeffs().data());
  ceres::Solver::Options o;
  o.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  o.max_num_iterations = options.max_iterations;
  o.function_tolerance = options.min_relative_cost_change;
  o.gradient_tolerance = o.parameter_tolerance = 0;
  ceres::Solver::Summary summary;
  const double start = CpuSeconds();
  ceres::Solve(o, &problem, &summary);
  return {Cost(graph), static_cast<int>(summary.iterations.size()) - 1, CpuSeconds() - start};
}

Outcome SolveByUs(PoseGraph graph, const PoseGraphOptions& options) {
  const double start = CpuSeconds();
  const PoseGraphSummary summary = OptimizePoseGraph(options, &graph);
  return {summary.final_cost, static_cast<int>(summary.iterations.size()) - 1,
          CpuSeconds() - start};
}

PoseGraph MakeGraph(const std::string& kind, int size) {
  if (kind == "sphere") return MakeSphere(size, size).graph;
  if (kind == "torus") return MakeTorus(size, size).graph;
  if (kind == "grid") return MakeGrid(size).graph;
  throw InputError("the kind must be sphere, torus or grid");
}

void Print(const char* name, const Outcome& o) {
  std::cout << name << ": cost " << o.cost << ", " << o.iterations << " iterations, "
            << 1000 * o.PerIteration() << " ms each" << std::endl;
}

// Both solvers start from the poses of chordal initialisation.
int Run(const PoseGraph& given, const Bounds& bounds) {
  PoseGraphOptions options;
  PoseGraph graph = given;
  PoseGraphOptions initialize_only = options;
  initialize_only.max_iterations = 1;
  OptimizePoseGraph(initialize_only, &graph);
  std::cout << graph.poses.size() << " poses, " << graph.edges.size() << " edges, cost "
            << Cost(given) << " as given" << std::endl;
  std::cout.precision(12);
  options.start = "given";
  options.max_iterations = bounds.iterations;
  Outcome plain = SolvePlainly(graph, options), ours = SolveByUs(graph, options);
  for (int repeat = 1; repeat < bounds.repeats;
       ++repeat) {  // alternates the solvers, so that other load affects both
    plain.cpu_s = std::min(plain.cpu_s, SolvePlainly(graph, options).cpu_s);
    ours.cpu_s = std::min(ours.cpu_s, SolveByUs(graph, options).cpu_s);
  }
  Print("plain Ceres", plain);
  Print("Surfit", ours);
  const double ratio = ours.PerIteration() / plain.PerIteration();
  std::cout << "Surfit / plain Ceres per iteration: " << ratio << std::endl;
  const bool same = std::abs(ours.cost - plain.cost) <= 1e-6 * plain.cost;
  if (!same) std::cout << "the costs differ" << std::endl;
  return same && ratio <= bounds.max_ratio ? 0 : 1;
}

}  // namespace
}  // namespace surfit::testing

int main(int argc, char** argv) try {
  surfit::testing::Bounds bounds;
  if (argc == 2) return surfit::testing::Run(surfit::ReadG2o(argv[1]).graph, bounds);
  if (argc < 3 || argc > 6) throw surfit::InputError("one argument is needed, or two to five");
  if (argc > 3) bounds.max_ratio = std::stod(argv[3]);
  if (argc > 4) bounds.iterations = std::stoi(argv[4]);
  if (argc > 5) bounds.repeats = std::stoi(argv[5]);
  return surfit::testing::Run(surfit::testing::MakeGraph(argv[1], std::stoi(argv[2])), bounds);
} catch (const std::exception& error) {
  std::cerr << "error: " << error.what() << std::endl;
  return 1;
}
