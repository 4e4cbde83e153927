#include <benchmark/benchmark.h>

#include "benchmarks/mapped_room.h"
#include "surfit/core/parallel.h"
#include "surfit/mapping/fusion.h"
#include "surfit/mapping/model_renderer.h"

namespace surfit::testing {
namespace {

const MappedRoom& Room() {
  static const auto* const room = new MappedRoom;
  return *room;
}

void Threads(benchmark::internal::Benchmark* benchmark) {
  benchmark->ArgName("threads")->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();
}

void ModelRendererRender(benchmark::State& state) {
  const MappedRoom& room = Room();
  const ThreadLimit limit(static_cast<int>(state.range(0)));
  ModelRenderer renderer({});
  for (auto _ : state) {
    benchmark::DoNotOptimize(renderer.Render(room.map, {room.camera, {}}, room.world_from_next));
  }
  state.counters["surfels"] = static_cast<double>(room.map.size());
}
BENCHMARK(ModelRendererRender)->Apply(Threads);

// Fuses the same frame into a copy of the map. Copying is not timed.
void FusionFuse(benchmark::State& state) {
  const MappedRoom& room = Room();
  const ThreadLimit limit(static_cast<int>(state.range(0)));
  Fusion fusion({});
  for (auto _ : state) {
    state.PauseTiming();
    SurfelMap map = room.map;
    state.ResumeTiming();
    benchmark::DoNotOptimize(fusion.Fuse(room.next, room.next_surface, room.world_from_next, &map));
  }
  state.counters["surfels"] = static_cast<double>(room.map.size());
}
BENCHMARK(FusionFuse)->Apply(Threads);

// Renders and fuses the same frame in maps with millions of additional surfels behind the camera.
// The time must not depend on these surfels.
void FrameInALargeMap(benchmark::State& state) {
  const MappedRoom& room = Room();
  SurfelMap map = room.map;
  room.GrowElsewhere(static_cast<std::size_t>(state.range(0)) * 1000000, &map);
  ModelRenderer renderer({});
  Fusion fusion({});
  for (auto _ : state) {
    benchmark::DoNotOptimize(renderer.Render(map, {room.camera, {}}, room.world_from_next));
    benchmark::DoNotOptimize(fusion.Fuse(room.next, room.next_surface, room.world_from_next, &map));
  }
  state.counters["surfels"] = static_cast<double>(map.size());
}
BENCHMARK(FrameInALargeMap)
    ->ArgName("millions")
    ->Arg(1)
    ->Arg(10)
    ->Iterations(20)
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace surfit::testing
