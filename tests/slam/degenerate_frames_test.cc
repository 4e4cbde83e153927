#include <gtest/gtest.h>

#include <cstddef>
#include <utility>

#include "slam/simulated_sequence.h"

namespace surfit::testing {
namespace {

// A corridor with walls, floor and ceiling along one axis. The floor is a checkerboard.
const SimulatedSequence& Corridor() {
  static const SimulatedSequence corridor = Simulate("corridor", 4, 25, Sensor::kKinect);
  return corridor;
}

// Noise of normals must not pass for structure. Some views contain the end of the corridor.
TEST(DegenerateFrames, AreReportedInCorridor) {
  SimulatedSequence bare = Corridor();
  for (RgbdFrame& frame : bare.frames) frame.color = {};
  for (const SimulatedSequence* corridor : {&Corridor(), &std::as_const(bare)}) {
    const SlamRun run = RunSlam(*corridor, SlamOptions(), corridor->world_from_camera[0]);
    int degenerate = 0;
    for (const FrameReport& report : run.reports) {
      const bool is_degenerate = report.state == FrameState::kDegenerate;
      EXPECT_EQ(is_degenerate, !report.icp.degenerate_directions.empty()) << report.index;
      degenerate += is_degenerate;
    }
    EXPECT_GE(degenerate, 15);
  }
}

// Registration of the first frames with depth alone put their colours at wrong places, which later
// frames then followed.
TEST(DegenerateFrames, FollowTextureFromTheFirstMotion) {
  const SlamRun run = RunSlam(Corridor(), SlamOptions(), Corridor().world_from_camera[0]);
  EXPECT_LT(ErrorsOf(run, Corridor().world_from_camera).max_m, 0.02);
  for (std::size_t i = 1; i < run.reports.size(); ++i) {
    EXPECT_GT(run.reports[i].icp.intensity_count, 0) << i;
  }
}

// With a longer map period, fewer frames are weakly constrained, and half of the rows are used.
TEST(DegenerateFrames, FollowTextureInAHurry) {
  const SimulatedSequence& corridor = Corridor();
  SlamOptions options;
  Slam slam({corridor.camera, {}}, options, corridor.world_from_camera[0]);
  slam.SetMapPeriod(8 * options.map_period);
  for (std::size_t i = 0; i < corridor.frames.size(); ++i) {
    const FrameReport report = slam.Process(corridor.frames[i]);
    ASSERT_TRUE(report.HasPose()) << i;
    EXPECT_LT(
        (corridor.world_from_camera[i].Inverse() * report.world_from_camera).translation.norm(),
        0.02)
        << i;
  }
}

}  // namespace
}  // namespace surfit::testing
