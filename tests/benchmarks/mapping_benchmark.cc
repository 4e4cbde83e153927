#include <benchmark/benchmark.h>

#include "surfit/core/parallel.h"
#include "surfit/frame/preprocess.h"
#include "surfit/mapping/fusion.h"
#include "surfit/mapping/model_renderer.h"
#include "surfit/simulation/camera_path.h"
#include "surfit/simulation/render.h"
#include "surfit/simulation/scenes.h"
#include "surfit/simulation/sensor.h"

namespace surfit {
namespace {

// A map of about 500,000 surfels, made from frames of a simulated room, and the next frame.
struct MappedRoom {
  static constexpr int kFrames = 20;
  PinholeCamera camera{640, 480, 525, 525, 319.5, 239.5, {}};
  SurfelMap map;
  RgbdFrame next;
  FrameLevel next_surface;
  Rigid3d world_from_next;

  MappedRoom() {
    const Scene scene = MakeScene("room", 1);
    const Trajectory path = MakePath(scene, kFrames + 1, 1);
    Fusion fusion({});
    for (next.index = 0;; ++next.index) {
      world_from_next = path[next.index].world_from_camera;
      Rendering image = Render(scene, camera, world_from_next);
      next.depth_m = KinectDepth(image.depth_m, camera, next.index);
      next.color = std::move(image.color);
      next_surface = PreprocessDepth(next.depth_m, camera, {}).levels[0];
      if (next.index == kFrames) return;
      fusion.Fuse(next, next_surface, world_from_next, &map);
    }
  }
};

const MappedRoom& Room() {
  static const auto* const room = new MappedRoom;
  return *room;
}

void ModelRendererRender(benchmark::State& state) {
  const MappedRoom& room = Room();
  const ThreadLimit limit(static_cast<int>(state.range(0)));
  ModelRenderer renderer({});
  for (auto _ : state) {
    benchmark::DoNotOptimize(renderer.Render(room.map, room.camera, room.world_from_next));
  }
  state.counters["surfels"] = static_cast<double>(room.map.size());
}
BENCHMARK(ModelRendererRender)
    ->ArgName("threads")
    ->Arg(1)
    ->Arg(2)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

// The same frame into a copy of the map each time; copying is not counted.
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
BENCHMARK(FusionFuse)
    ->ArgName("threads")
    ->Arg(1)
    ->Arg(2)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

// The same view and frame where the map goes on elsewhere, to so many millions of surfels: the time
// must not follow these.
void FrameInALargeMap(benchmark::State& state) {
  const MappedRoom& room = Room();
  SurfelMap map = room.map;
  Surfel far = map[map.Ids().front()];
  far.confidence = FusionOptions().lasting_confidence;
  const auto count = static_cast<std::size_t>(state.range(0)) * 1000000;
  const Eigen::Vector3f from = room.world_from_next.translation.cast<float>();
  const Eigen::Vector3f backwards = -room.world_from_next.rotation.matrix().col(2).cast<float>();
  for (int i = 0; map.size() < count; ++i) {
    const Eigen::Vector3f wall(static_cast<float>(i / 4000 % 4000), static_cast<float>(i % 4000),
                               0);
    far.position_in_world = from + 20 * backwards + 0.005f * wall;
    map.Append(far);
  }
  ModelRenderer renderer({});
  Fusion fusion({});
  for (auto _ : state) {
    benchmark::DoNotOptimize(renderer.Render(map, room.camera, room.world_from_next));
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
}  // namespace surfit
