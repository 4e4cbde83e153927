// Whole runs over simulated rooms of the size that sensors have.
#include <gtest/gtest.h>

#include <cstdio>
#include <memory>

#include "slam/simulated_sequence.h"

namespace surfit {
namespace {

class RoomsSweep : public ::testing::TestWithParam<int> {};

// The bound is what Surfit promises of such rooms. Both paths start at the same pose, and nothing
// is aligned, so that the error is no smaller than the ATE.
TEST_P(RoomsSweep, AKinectIsTrackedWithin8MillimetresOver300Frames) {
  constexpr int kCount = 300;
  const PinholeCamera camera{640, 480, 525, 525, 319.5, 239.5, {}};
  const auto seed = static_cast<std::uint64_t>(GetParam());
  const Scene scene = MakeScene("room", seed);
  std::vector<Rigid3d> truth;
  testing::SlamRun run;
  std::unique_ptr<Slam> slam;
  for (const StampedPose& pose : MakePath(scene, kCount, seed)) {
    const int index = static_cast<int>(truth.size());
    truth.push_back(pose.world_from_camera);
    RgbdFrame frame = RenderFrame(scene, camera, pose.world_from_camera, index, pose.stamp_s);
    frame.depth_m = KinectDepth(frame.depth_m, camera, (seed << 32) + index);
    if (!slam) slam = std::make_unique<Slam>(DepthSensor{camera, {}}, SlamOptions(), truth[0]);
    run.reports.push_back(slam->Process(frame));
    EXPECT_NE(run.reports.back().state, FrameState::kLost) << index;
  }
  const double rms_m = testing::ErrorsOf(run, truth).rms_m;
  std::printf("room %d: %.2f mm\n", GetParam(), 1e3 * rms_m);
  EXPECT_LE(rms_m, 0.008);
}

INSTANTIATE_TEST_SUITE_P(Seeds, RoomsSweep, ::testing::Values(1, 2, 3, 4, 5));

}  // namespace
}  // namespace surfit
