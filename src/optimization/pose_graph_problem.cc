#include <ceres/solver.h>
#include <dlfcn.h>

#include "core/named_values.h"
#include "cost_functions/analytic_relative_pose.h"
#include "optimization/optimize_pose_graph.h"
#include "optimization/pose_graph_names.h"

namespace surfit {
namespace {

// Sets a library's number of threads and returns the former one; 0 where it is not loaded.
int SetThreads(const char* getter, const char* setter, int count) {
  const auto get = reinterpret_cast<int (*)()>(dlsym(RTLD_DEFAULT, getter));
  const auto set = reinterpret_cast<void (*)(int)>(dlsym(RTLD_DEFAULT, setter));
  if (get == nullptr || set == nullptr) return 0;
  const int former = get();
  set(count);
  return former;
}

int SetOpenMpThreads(int count) {
  return SetThreads("omp_get_max_threads", "omp_set_num_threads", count);
}

int SetOpenBlasThreads(int count) {
  return SetThreads("openblas_get_num_threads", "openblas_set_num_threads", count);
}

// While it lives, OpenMP's loops that begin on this thread (CHOLMOD's) and OpenBLAS, where they are
// loaded, use one thread, so that sums have the same order on every machine. Debian's own BLAS
// has one anyway.
class SingleThreadedBlas {
 public:
  SingleThreadedBlas()
      : openmp_threads_(SetOpenMpThreads(1)), openblas_threads_(SetOpenBlasThreads(1)) {}
  ~SingleThreadedBlas() {
    if (openblas_threads_ > 0) SetOpenBlasThreads(openblas_threads_);
    if (openmp_threads_ > 0) SetOpenMpThreads(openmp_threads_);
  }
  SingleThreadedBlas(const SingleThreadedBlas&) = delete;
  SingleThreadedBlas& operator=(const SingleThreadedBlas&) = delete;

 private:
  int openmp_threads_, openblas_threads_;
};

ceres::Problem::Options OwnedByUs() {
  ceres::Problem::Options options;
  options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  return options;
}

ceres::Solver::Options SolverOptions(const PoseGraphOptions& options) {
  ceres::Solver::Options o;
  o.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  o.sparse_linear_algebra_library_type =
      ValueOf("sparse_backend", options.sparse_backend, kSparseBackends);
  o.max_num_iterations = options.max_iterations;
  o.function_tolerance = options.min_relative_cost_change;
  o.gradient_tolerance = 0;  // has units of the information: the cost alone decides
  o.parameter_tolerance = 0;
  o.num_threads = 1;  // with more, Ceres sums costs and gradients in no fixed order
  o.logging_type = ceres::SILENT;
  return o;
}

PoseGraphIteration AsIteration(const ceres::IterationSummary& s, int round) {
  PoseGraphIteration iteration;
  iteration.round = round;
  iteration.cost = s.cost;
  iteration.step_norm = s.step_norm;
  iteration.accepted = s.iteration == 0 || s.step_is_successful;
  iteration.time_ms = 1000 * s.iteration_time_in_seconds;
  return iteration;
}

}  // namespace

PoseGraphProblem::PoseGraphProblem(const PoseGraph& graph,
                                   const std::vector<Rigid3d>& world_from_pose,
                                   const std::vector<bool>& held)
    : poses_(graph.poses.size()),
      losses_(graph.edges.size()),
      graph_(graph),
      problem_(OwnedByUs()) {
  for (std::size_t i = 0; i < poses_.size(); ++i) {
    PoseToBlock(world_from_pose[i], poses_[i].data());
    problem_.AddParameterBlock(poses_[i].data(), kPoseSize, &manifold_);
    if (held[i]) problem_.SetParameterBlockConstant(poses_[i].data());
  }
  for (std::size_t i = 0; i < graph.edges.size(); ++i) {
    const PoseGraphEdge& edge = graph.edges[i];
    auto* cost = new AnalyticRelativePose(edge.a_from_b, edge.information);
    costs_.push_back(cost);
    problem_.AddResidualBlock(cost, edge.loop ? &losses_[i] : nullptr, poses_[edge.a].data(),
                              poses_[edge.b].data());
  }
}

PoseGraphTermination PoseGraphProblem::Minimize(const PoseGraphOptions& options,
                                                double initial_radius, PoseGraphSummary* summary) {
  const SingleThreadedBlas single_threaded;
  ceres::Solver::Summary solved;
  const auto before = poses_;
  ceres::Solver::Options solver_options = SolverOptions(options);
  solver_options.initial_trust_region_radius = initial_radius;
  ceres::Solve(solver_options, &problem_, &solved);
  for (const ceres::IterationSummary& iteration : solved.iterations) {
    summary->iterations.push_back(AsIteration(iteration, summary->round_count));
  }
  ++summary->round_count;
  if (solved.IsSolutionUsable()) {
    return solved.termination_type == ceres::CONVERGENCE ? PoseGraphTermination::kConverged
                                                         : PoseGraphTermination::kMaxIterations;
  }
  poses_ = before;
  return PoseGraphTermination::kFailed;
}

void PoseGraphProblem::SetWeights(const std::vector<double>& weights) {
  for (std::size_t i = 0; i < weights.size(); ++i) losses_[i].weight = weights[i];
}

std::vector<double> PoseGraphProblem::SquaredErrors() const {
  std::vector<double> errors;
  for (std::size_t i = 0; i < costs_.size(); ++i) {
    const PoseGraphEdge& edge = graph_.edges[i];
    const double* blocks[] = {poses_[edge.a].data(), poses_[edge.b].data()};
    Eigen::Matrix<double, 6, 1> residuals;
    costs_[i]->Evaluate(blocks, residuals.data(), nullptr);
    errors.push_back(residuals.squaredNorm());
  }
  return errors;
}

std::vector<Rigid3d> PoseGraphProblem::Poses() const {
  std::vector<Rigid3d> poses;
  for (const auto& block : poses_) poses.push_back(PoseFromBlock(block.data()));
  return poses;
}

}  // namespace surfit
