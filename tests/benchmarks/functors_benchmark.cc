// Evaluates all functors with autodiff (with Jacobians), and residuals only: as one reduced batch
// of 280,000 points, and as separate Ceres cost functions.
#include <benchmark/benchmark.h>
#include <ceres/autodiff_cost_function.h>

#include <memory>

#include "cost_functions/pose_prior.h"
#include "cost_functions/random_functors.h"
#include "cost_functions/relative_pose.h"
#include "surfit/core/parallel.h"

namespace surfit::testing {
namespace {

constexpr int kPoints = 280000;

Rigid3d Start() { return {QuaternionExp<double>({0.01, -0.02, 0.01}), {0.02, -0.01, 0.01}}; }

// Evaluates a cost at the initial pose, with or without Jacobians of each block.
void Evaluate(const ceres::CostFunction& cost, bool with_jacobian, benchmark::State& state) {
  const PoseBlock pose = AsBlock(Start());
  const std::size_t blocks = cost.parameter_block_sizes().size();
  const std::vector<const double*> parameters(blocks, pose.data());
  std::vector<double> residuals(cost.num_residuals());
  std::vector<std::vector<double>> jacobians(blocks,
                                             std::vector<double>(kPoseSize * residuals.size()));
  std::vector<double*> rows;
  for (auto& jacobian : jacobians) rows.push_back(jacobian.data());
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        cost.Evaluate(parameters.data(), residuals.data(), with_jacobian ? rows.data() : nullptr));
    benchmark::ClobberMemory();
  }
}

template <typename Functor, typename S>
void Batch(benchmark::State& state) {
  const ThreadLimit limit(static_cast<int>(state.range(1)));
  static const auto* const functors =
      new std::vector<Functor>(RandomFunctors<Functor>(kPoints, Rigid3d(), 0.005, 1));
  const ReducedBatch<Functor, S> cost(
      Definition<Functor>(), BatchData<Functor, S>::FromFunctors(*functors), RobustKernel());
  Evaluate(cost, state.range(0) != 0, state);
}

template <typename Functor>
void OnePoint(benchmark::State& state) {
  const auto functors = RandomFunctors<Functor>(1, Rigid3d(), 0.005, 1);
  const std::unique_ptr<ceres::CostFunction> cost(PerPointCost(functors[0]));
  Evaluate(*cost, state.range(0) != 0, state);
}

void OnePosePrior(benchmark::State& state) {
  const ceres::AutoDiffCostFunction<PosePrior, 6, kPoseSize> cost(
      new PosePrior(Rigid3d(), PoseInformation::Identity()));
  Evaluate(cost, state.range(0) != 0, state);
}

void OneRelativePose(benchmark::State& state) {
  const ceres::AutoDiffCostFunction<RelativePose, 6, kPoseSize, kPoseSize> cost(
      new RelativePose(Rigid3d(), PoseInformation::Identity()));
  Evaluate(cost, state.range(0) != 0, state);
}

void BatchArguments(benchmark::internal::Benchmark* benchmark) {
  benchmark->ArgNames({"jacobian", "threads"})
      ->ArgsProduct({{0, 1}, {1, 2}})
      ->UseRealTime()
      ->Unit(benchmark::kMillisecond);
}

void OneArguments(benchmark::internal::Benchmark* benchmark) {
  benchmark->ArgName("jacobian")->Arg(0)->Arg(1);
}

#define SURFIT_BENCHMARK_FUNCTOR(Functor)                            \
  BENCHMARK_TEMPLATE(Batch, Functor, float)->Apply(BatchArguments);  \
  BENCHMARK_TEMPLATE(Batch, Functor, double)->Apply(BatchArguments); \
  BENCHMARK_TEMPLATE(OnePoint, Functor)->Apply(OneArguments)
SURFIT_BENCHMARK_FUNCTOR(PointToPoint);
SURFIT_BENCHMARK_FUNCTOR(PointToPlane);
SURFIT_BENCHMARK_FUNCTOR(SymmetricPointToPlane);
SURFIT_BENCHMARK_FUNCTOR(PlaneToPlane);
SURFIT_BENCHMARK_FUNCTOR(Photometric);
#undef SURFIT_BENCHMARK_FUNCTOR
BENCHMARK(OnePosePrior)->Apply(OneArguments);
BENCHMARK(OneRelativePose)->Apply(OneArguments);

}  // namespace
}  // namespace surfit::testing
