#include <benchmark/benchmark.h>

#include "registration/linearize.h"
#include "surfit/core/parallel.h"
#include "surfit/frame/preprocess.h"
#include "surfit/registration/projective_association.h"
#include "surfit/simulation/camera_path.h"
#include "surfit/simulation/render.h"
#include "surfit/simulation/scenes.h"

namespace surfit {
namespace {

PinholeCamera FullCamera() {
  PinholeCamera camera;
  camera.width = 640;
  camera.height = 480;
  camera.fx = camera.fy = 525;
  camera.cx = 319.5;
  camera.cy = 239.5;
  return camera;
}

// Depth of the default room at full resolution.
const Image<float>& RoomDepth() {
  static const Image<float> depth_m = [] {
    const Scene scene = MakeScene("room");
    return RenderFrame(scene, FullCamera(), MakePath(scene, 1, 1)[0].world_from_camera).depth_m;
  }();
  return depth_m;
}

void Preprocess(benchmark::State& state) {
  const Image<float>& depth_m = RoomDepth();
  const ThreadLimit limit(static_cast<int>(state.range(0)));
  for (auto _ : state) {
    benchmark::DoNotOptimize(PreprocessDepth(depth_m, FullCamera(), PreprocessOptions()));
  }
}
BENCHMARK(Preprocess)
    ->ArgName("threads")
    ->Arg(1)
    ->Arg(2)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

// One linearisation on the finest level.
void LinearizeProjective(benchmark::State& state) {
  const FramePyramid view = PreprocessDepth(RoomDepth(), FullCamera(), PreprocessOptions());
  const ProjectiveAssociation association(view.levels[0], view.levels[0], AssociationGates(),
                                          ErrorModel());
  const Rigid3d motion(QuaternionExp<double>({0.005, -0.01, 0.002}), {0.01, 0.005, -0.01});
  const ThreadLimit limit(static_cast<int>(state.range(0)));
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        Linearize(association, motion, ResidualType::kPointToPlane, ErrorModel().kernel));
  }
}
BENCHMARK(LinearizeProjective)
    ->ArgName("threads")
    ->Arg(1)
    ->Arg(2)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace surfit
