// One linearisation and one full solve of point-to-plane residuals: as one reduced block, as one
// Ceres block per point, and in closed form.
#include <benchmark/benchmark.h>

#include "cost_functions/random_functors.h"
#include "registration/icp/icp_level.h"
#include "surfit/registration/pose_solver.h"

namespace surfit::testing {
namespace {

constexpr int kPoints = 280000;

const std::vector<PointToPlane>& Functors() {
  static const auto* const functors =
      new std::vector<PointToPlane>(RandomFunctors<PointToPlane>(kPoints, Rigid3d(), 0.005, 1));
  return *functors;
}

Rigid3d Start() { return {QuaternionExp<double>({0.01, -0.02, 0.01}), {0.02, -0.01, 0.01}}; }

PairBuffer MovedPairs() {
  PairBuffer pairs;
  const Rigid3d pose = Start();
  for (const PointToPlane& functor : Functors()) {
    const auto& d = functor.data;
    const Eigen::Vector3d p = pose * Eigen::Vector3d(d[0], d[1], d[2]);
    const Eigen::Vector3f n(d[6], d[7], d[8]);
    pairs.Add(p.cast<float>(),
              {static_cast<float>(d[3]), static_cast<float>(d[4]), static_cast<float>(d[5])}, n, n,
              static_cast<float>(d[9] * d[9]));
  }
  pairs.SetCapacity(pairs.size);
  return pairs;
}

template <typename S>
ReducedBatch<PointToPlane, S>* MakeReduced() {
  return new ReducedBatch<PointToPlane, S>(
      PointToPlane(), BatchData<PointToPlane, S>::FromFunctors(Functors()), RobustKernel());
}

template <typename S>
void LinearizeReduced(benchmark::State& state) {
  const ThreadLimit limit(static_cast<int>(state.range(0)));
  const std::unique_ptr<ceres::CostFunction> cost(MakeReduced<S>());
  const PoseBlock pose = AsBlock(Start());
  const double* parameters = pose.data();
  double residuals[7], jacobian[49];
  double* jacobians = jacobian;
  for (auto _ : state) cost->Evaluate(&parameters, residuals, &jacobians);
}
BENCHMARK_TEMPLATE(LinearizeReduced, float)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(LinearizeReduced, double)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond);

// Closed form over the same correspondences, moved to the pose.
void LinearizeByHand(benchmark::State& state) {
  const ThreadLimit limit(static_cast<int>(state.range(0)));
  const PairBuffer pairs = MovedPairs();
  for (auto _ : state) {
    benchmark::DoNotOptimize(Linearize(pairs, ResidualType::kPointToPlane, RobustKernel()));
  }
}
BENCHMARK(LinearizeByHand)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond);

template <typename AddBlocks>
void Solve(const AddBlocks& add_blocks, ceres::LinearSolverType type) {
  PoseBlock pose = AsBlock(Start());
  ceres::Problem problem;
  problem.AddParameterBlock(pose.data(), kPoseSize, new LeftPoseManifold);
  add_blocks(&problem, pose.data());
  ceres::Solver::Options options;
  options.linear_solver_type = type;
  options.num_threads = 2;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  benchmark::DoNotOptimize(pose);
}

// Includes building the problem.
void SolveReduced(benchmark::State& state) {
  for (auto _ : state) {
    Solve([](ceres::Problem* problem,
             double* pose) { problem->AddResidualBlock(MakeReduced<float>(), nullptr, pose); },
          ceres::DENSE_QR);
  }
}
BENCHMARK(SolveReduced)->Unit(benchmark::kMillisecond);

void SolvePerPoint(benchmark::State& state) {
  for (auto _ : state) {
    Solve(
        [](ceres::Problem* problem, double* pose) {
          for (const PointToPlane& functor : Functors()) {
            problem->AddResidualBlock(PerPointCost(functor), nullptr, pose);
          }
        },
        static_cast<ceres::LinearSolverType>(state.range(0)));
  }
}
BENCHMARK(SolvePerPoint)
    ->ArgName("linear_solver")
    ->Arg(ceres::DENSE_NORMAL_CHOLESKY)
    ->Arg(ceres::DENSE_QR)
    ->Arg(ceres::SPARSE_NORMAL_CHOLESKY)
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace surfit::testing
