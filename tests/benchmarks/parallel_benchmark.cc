#include <benchmark/benchmark.h>

#include <numeric>
#include <vector>

#include "surfit/core/parallel.h"

namespace surfit::testing {
namespace {

void ParallelSumOfAnImage(benchmark::State& state) {
  constexpr int kPixels = 640 * 480;
  constexpr int kGrain = 640 * 16;
  const std::vector<float> pixels(kPixels, 1.5f);
  const ThreadLimit limit(static_cast<int>(state.range(0)));
  for (auto _ : state) {
    benchmark::DoNotOptimize(ParallelSum(0, kPixels, kGrain, 0.f, [&](int begin, int end) {
      return std::accumulate(pixels.begin() + begin, pixels.begin() + end, 0.f);
    }));
  }
  state.SetItemsProcessed(state.iterations() * kPixels);
}
BENCHMARK(ParallelSumOfAnImage)->ArgName("threads")->Arg(1)->Arg(2)->UseRealTime();

}  // namespace
}  // namespace surfit::testing
