#include <gtest/gtest.h>

#include "mapping/same_map.h"
#include "surfit/core/parallel.h"
#include "surfit/frame/preprocess.h"
#include "surfit/mapping/fusion.h"
#include "surfit/simulation/camera_path.h"
#include "surfit/simulation/render.h"
#include "surfit/simulation/scene.h"

namespace surfit {
namespace {

TEST(FusionThreads, MapsAreTheSameBitForBitAtAnyNumberOfThreads) {
  const PinholeCamera camera{160, 120, 131, 131, 79.5, 59.5, {}};
  const Scene scene = MakeScene("room", 1);
  const Trajectory path = MakePath(scene, 5, 1);
  std::vector<RgbdFrame> frames;
  std::vector<FramePyramid> pyramids;
  for (int i = 0; i < 5; ++i) {
    frames.push_back(RenderFrame(scene, camera, path[i].world_from_camera, i));
    pyramids.push_back(PreprocessDepth(frames.back().depth_m, {camera, {}}, {}));
  }
  std::vector<SurfelMap> maps;
  for (const int threads : {1, 2, 4}) {
    const ThreadLimit limit(threads);
    Fusion fusion({});
    SurfelMap map;
    for (int i = 0; i < 5; ++i) {
      fusion.Fuse(frames[i], pyramids[i].levels[0], path[i].world_from_camera, &map);
    }
    maps.push_back(map);
  }
  // More than a few cells, so that threads share the work.
  EXPECT_GT(maps[0].cell_count(), 10);
  testing::ExpectSameMap(maps[1], maps[0]);
  testing::ExpectSameMap(maps[2], maps[0]);
}

}  // namespace
}  // namespace surfit
