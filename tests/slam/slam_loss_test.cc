#include <gtest/gtest.h>

#include <vector>

#include "mapping/same_map.h"
#include "slam/ideal_room.h"
#include "surfit/slam/slam.h"
#include "testing/matchers.h"

namespace surfit {
namespace {

using testing::Blank;
using testing::ExpectSameMap;
using testing::IdealRoom;
using testing::kPixelAt2m;
using testing::kPixelRad;
using testing::RigidNear;
using testing::Sensor;
using testing::SimulatedSequence;
using testing::SimulateRoom;

TEST(Slam, ALostFrameIsNotFusedAndTrackingGoesOnFromTheLastGoodPose) {
  const SimulatedSequence& room = IdealRoom();
  for (const char* tracking : {"frame_to_model", "frame_to_frame"}) {
    SlamOptions options;
    options.tracking = tracking;
    Slam slam({room.camera, {}}, options, room.world_from_camera[0]);
    for (int i = 0; i < 8; ++i) slam.Process(room.frames[i]);
    const SurfelMap before = slam.map();
    for (int i = 8; i < 10; ++i) {  // the second of them repeats the first: it is no less lost
      const FrameReport lost = slam.Process(Blank(i));
      EXPECT_EQ(lost.state, FrameState::kLost);
      EXPECT_EQ(lost.icp.termination, Termination::kTooFewInliers);
      EXPECT_EQ(lost.fusion.input_points, 0);
    }
    ExpectSameMap(slam.map(), before);
    for (int i = 10; i < 14; ++i) {
      const FrameReport report = slam.Process(room.frames[i]);
      EXPECT_EQ(report.state, FrameState::kTracked) << tracking << i;
      EXPECT_THAT(report.world_from_camera,
                  RigidNear(room.world_from_camera[i], kPixelAt2m, kPixelRad));
    }
  }
}

// A ball close by instead of the room.
TEST(Slam, APlaceThatDoesNotMatchIsLost) {
  const SimulatedSequence& room = IdealRoom();
  const Scene elsewhere = MakeScene("sphere");
  Slam slam({room.camera, {}}, SlamOptions(), {});
  for (int i = 0; i < 4; ++i) slam.Process(room.frames[i]);
  const SurfelMap before = slam.map();
  Eigen::Matrix3d along_y;
  along_y << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  const Rigid3d pose(along_y, Eigen::Vector3d(0, 1.1, 1));  // 0.4 m before the ball
  const FrameReport report = slam.Process(RenderFrame(elsewhere, room.camera, pose, 4));
  EXPECT_EQ(report.state, FrameState::kLost);
  ExpectSameMap(slam.map(), before);
  EXPECT_EQ(slam.Process(room.frames[5]).state, FrameState::kTracked);
}

// 50 frames left out: 0.6 m and 22 degrees, beyond what tracking follows.
TEST(Slam, FindsAFrameAgainAfterAJump) {
  const SimulatedSequence room = SimulateRoom(12, 122, Sensor::kIdeal);
  for (const char* tracking : {"frame_to_model", "frame_to_frame"}) {
    for (const char* initialize : {"identity", "features"}) {
      SlamOptions options;
      options.tracking = tracking;
      options.initialize = initialize;
      Slam slam({room.camera, {}}, options, room.world_from_camera[68]);
      for (int i = 68; i < 71; ++i) slam.Process(room.frames[i]);
      const SurfelMap before = slam.map();
      const FrameReport report = slam.Process(room.frames[120]);
      if (options.initialize == "identity") {
        EXPECT_EQ(report.state, FrameState::kLost) << tracking;
        ExpectSameMap(slam.map(), before);
      } else {
        EXPECT_EQ(report.state, FrameState::kTracked) << tracking;
        EXPECT_TRUE(report.found_again);
        EXPECT_THAT(report.world_from_camera,
                    RigidNear(room.world_from_camera[120], kPixelAt2m, kPixelRad));
        const FrameReport next = slam.Process(room.frames[121]);
        EXPECT_EQ(next.state, FrameState::kTracked) << tracking;
        EXPECT_FALSE(next.found_again);
      }
    }
  }
}

// The way from the last good frame over lost ones is many frames long: it must not be expected
// again for the next. The second run expects no motion at all.
TEST(Slam, AfterALossNoMotionIsExpected) {
  const SimulatedSequence& room = IdealRoom();
  std::vector<double> first_losses;
  for (const char* motion_model : {"constant_velocity", "constant_pose"}) {
    SlamOptions options;
    options.motion_model = motion_model;
    Slam slam({room.camera, {}}, options, {});
    for (int i = 0; i < 4; ++i) slam.ProcessAt(room.frames[i], room.world_from_camera[i]);
    for (int i = 4; i < 8; ++i) slam.Process(Blank(i));
    EXPECT_EQ(slam.Process(room.frames[8]).state, FrameState::kTracked);
    first_losses.push_back(slam.Process(room.frames[9]).icp.iterations.at(0).average_loss);
  }
  EXPECT_EQ(first_losses[0], first_losses[1]);
}

// A Kinect needs some frames until it measures: they must not become an empty map that nothing can
// ever be tracked against.
TEST(Slam, StartsWithTheFirstFrameThatHasDepth) {
  const SimulatedSequence& room = IdealRoom();
  Slam slam({room.camera, {}}, SlamOptions(), room.world_from_camera[2]);
  EXPECT_EQ(slam.Process(Blank(0)).state, FrameState::kLost);
  EXPECT_EQ(slam.Process(Blank(1)).state, FrameState::kLost);
  EXPECT_EQ(slam.map().size(), 0u);
  const FrameReport first = slam.Process(room.frames[2]);
  EXPECT_EQ(first.state, FrameState::kFirst);
  EXPECT_EQ(first.world_from_camera.Matrix(), room.world_from_camera[2].Matrix());
  EXPECT_EQ(slam.Process(room.frames[3]).state, FrameState::kTracked);
}

}  // namespace
}  // namespace surfit
