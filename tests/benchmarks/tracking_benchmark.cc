#include <benchmark/benchmark.h>

#include "registration/icp/icp_level.h"
#include "surfit/core/parallel.h"
#include "surfit/frame/preprocess.h"
#include "surfit/registration/association.h"
#include "surfit/simulation/camera_path.h"
#include "surfit/simulation/render.h"
#include "surfit/simulation/scene.h"

namespace surfit::testing {
namespace {

PinholeCamera FullCamera() { return {640, 480, 525, 525, 319.5, 239.5, {}}; }

const Image<float>& RoomDepth() {
  static const Image<float> depth_m = [] {
    const Scene scene = MakeScene("room");
    return RenderFrame(scene, FullCamera(), MakePath(scene, 1, 1)[0].world_from_camera).depth_m;
  }();
  return depth_m;
}

void Threads(benchmark::internal::Benchmark* benchmark) {
  benchmark->ArgName("threads")->Arg(1)->Arg(2)->UseRealTime()->Unit(benchmark::kMillisecond);
}

void Preprocess(benchmark::State& state) {
  const Image<float>& depth_m = RoomDepth();
  const ThreadLimit limit(static_cast<int>(state.range(0)));
  for (auto _ : state) {
    benchmark::DoNotOptimize(PreprocessDepth(depth_m, {FullCamera(), {}}, PreprocessOptions()));
  }
}
BENCHMARK(Preprocess)->Apply(Threads);

Rigid3d Motion() { return {QuaternionExp<double>({0.005, -0.01, 0.002}), {0.01, 0.005, -0.01}}; }

const FrameLevel& RoomLevel() {
  static const FramePyramid view =
      PreprocessDepth(RoomDepth(), {FullCamera(), {}}, PreprocessOptions());
  return view.levels[0];
}

ProjectiveAssociation Projective() {
  return {RoomLevel(), RoomLevel(), AssociationGates(), ErrorModel(), NeededNormals::kBoth};
}

// Correspondences of the finest level, without sums.
void FindPairs(const Association& association, benchmark::State& state) {
  const ThreadLimit limit(static_cast<int>(state.range(0)));
  for (auto _ : state) {
    const auto finder = association.At(Motion());
    ParallelFor(0, association.block_count(), 8, [&](int begin, int end) {
      PairBuffer pairs;
      pairs.SetCapacity(association.block_capacity());
      for (int block = begin; block < end; ++block) {
        benchmark::DoNotOptimize(finder->Find(block, 0, &pairs));
      }
    });
  }
}

void FindProjectivePairs(benchmark::State& state) { FindPairs(Projective(), state); }

// Nearest neighbours with existing trees. All iterations except the first start from the last
// matches.
void FindNearestPairs(benchmark::State& state) {
  const SearchablePoints points(PointSetOf(RoomLevel(), ErrorModel()));
  FindPairs(KdTreeAssociation(points, points, {}), state);
}

// List of correspondences, for all solvers except closed_form_ldlt and closed_form_lu.
void CollectProjectivePairs(benchmark::State& state) {
  const ProjectiveAssociation association = Projective();
  const ThreadLimit limit(static_cast<int>(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(association.Collect(Motion()));
}

// Sums the closed-form rows of known correspondences, with the robust kernel of tracking.
void LinearizeRows(benchmark::State& state, ResidualType residual) {
  const PairBuffer pairs = Projective().Collect(Motion());
  const ThreadLimit limit(static_cast<int>(state.range(0)));
  for (auto _ : state) {
    benchmark::DoNotOptimize(Linearize(pairs, residual, ErrorModel().kernel));
  }
  state.counters["pairs"] = pairs.size;
}

// Sums the rows and finds the correspondences in one pass.
void LinearizeProjective(benchmark::State& state, ResidualType residual) {
  const ProjectiveAssociation association = Projective();
  const ThreadLimit limit(static_cast<int>(state.range(0)));
  for (auto _ : state) {
    benchmark::DoNotOptimize(Linearize(association, Motion(), residual, ErrorModel().kernel));
  }
}

BENCHMARK(FindProjectivePairs)->Apply(Threads);
BENCHMARK(FindNearestPairs)->Apply(Threads);
BENCHMARK(CollectProjectivePairs)->Apply(Threads);
#define SURFIT_BENCHMARK_RESIDUAL(name, type)                   \
  BENCHMARK_CAPTURE(LinearizeRows, name, type)->Apply(Threads); \
  BENCHMARK_CAPTURE(LinearizeProjective, name, type)->Apply(Threads)
SURFIT_BENCHMARK_RESIDUAL(point_to_point, ResidualType::kPointToPoint);
SURFIT_BENCHMARK_RESIDUAL(point_to_plane, ResidualType::kPointToPlane);
SURFIT_BENCHMARK_RESIDUAL(symmetric_point_to_plane, ResidualType::kSymmetricPointToPlane);
SURFIT_BENCHMARK_RESIDUAL(plane_to_plane, ResidualType::kPlaneToPlane);
#undef SURFIT_BENCHMARK_RESIDUAL

}  // namespace
}  // namespace surfit::testing
