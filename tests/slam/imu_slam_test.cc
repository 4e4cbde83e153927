// Slam with an inertial sensor, on rendered frames.
#include <gmock/gmock.h>

#include <vector>

#include "surfit/core/parallel.h"
#include "surfit/simulation/camera_path.h"
#include "surfit/simulation/render.h"
#include "surfit/slam/slam.h"
#include "testing/matchers.h"

namespace surfit::testing {
namespace {

constexpr int kFrames = 50, kGapBegin = 36, kGapEnd = 45;

struct InertialRoom {
  Scene scene = MakeScene("room", 4);
  Trajectory path = MakePath(scene, kFrames, 4);
  PinholeCamera camera = {160, 120, 131, 131, 79.5, 59.5, {}};
  ImuRecording imu;

  InertialRoom() {
    ImuSimulation simulation;
    simulation.seed = 4;
    imu.samples = SimulateImu(SmoothPath(path), simulation);
    imu.read_from = "simulation";
    imu.calibration.rotation_sigma_rad = 0.005;
  }

  // Poses of the frames. Frames of the gap have no depth.
  std::vector<FrameReport> Run(bool with_imu, ImuReport* report,
                               std::vector<Slam::BridgedFrame>* bridged = nullptr) const {
    Slam slam({camera, {}}, SlamOptions(), path[0].world_from_camera);
    if (with_imu) slam.UseImu(imu);
    std::vector<FrameReport> reports;
    for (int i = 0; i < kFrames; ++i) {
      RgbdFrame frame = RenderFrame(scene, camera, path[i].world_from_camera, i, path[i].stamp_s);
      // One pixel differs, so that blind frames are no duplicates.
      if (i >= kGapBegin && i < kGapEnd) {
        frame.depth_m = Image<float>(camera.width, camera.height);
        frame.depth_m(i, 0) = 1;
      }
      reports.push_back(slam.Process(frame));
    }
    *report = slam.imu_report();
    slam.Finish();
    if (bridged) *bridged = slam.bridged_frames();
    return reports;
  }
};

TEST(SlamWithImu, BridgesFramesWithoutDepth) {
  const InertialRoom room;
  ImuReport imu;
  const std::vector<FrameReport> reports = room.Run(true, &imu);
  EXPECT_EQ(imu.off_reason, "");
  EXPECT_EQ(imu.starts, 1);
  for (int i = kGapBegin; i < kGapEnd; ++i) EXPECT_FALSE(reports[i].HasPose()) << i;
  // The first view after the gap needs no confirmation by the next frame.
  for (int i = kGapEnd; i < kFrames; ++i) {
    ASSERT_TRUE(reports[i].HasPose()) << i;
    EXPECT_FALSE(reports[i].found_by_search) << i;
    EXPECT_THAT(reports[i].world_from_camera, RigidNear(room.path[i].world_from_camera, 0.02, 0.01))
        << i;
  }
  ASSERT_EQ(imu.bridges.size(), 1u);
  EXPECT_EQ(imu.bridges[0].frame, kGapEnd);
  EXPECT_LT(imu.bridges[0].correction_m, 0.05);
}

TEST(SlamWithImu, BlindFramesHavePosesAfterTheLastFrame) {
  const InertialRoom room;
  ImuReport imu;
  std::vector<Slam::BridgedFrame> bridged;
  room.Run(true, &imu, &bridged);
  ASSERT_EQ(bridged.size(), static_cast<std::size_t>(kGapEnd - kGapBegin));
  for (int i = 0; i < kGapEnd - kGapBegin; ++i) {
    EXPECT_EQ(bridged[i].index, kGapBegin + i);
    EXPECT_EQ(bridged[i].before, kGapBegin - 1);
    const Rigid3d truth = room.path[kGapBegin - 1].world_from_camera.Inverse() *
                          room.path[kGapBegin + i].world_from_camera;
    EXPECT_THAT(bridged[i].before_from_camera, RigidNear(truth, 0.005, 0.003)) << i;
  }
  room.Run(false, &imu, &bridged);
  EXPECT_TRUE(bridged.empty());
}

TEST(SlamWithImu, ResultIsTheSameForOneAndTwoThreads) {
  const InertialRoom room;
  ImuReport imu;
  std::vector<FrameReport> one, two;
  {
    const ThreadLimit limit(1);
    one = room.Run(true, &imu);
  }
  {
    const ThreadLimit limit(2);
    two = room.Run(true, &imu);
  }
  for (int i = 0; i < kFrames; ++i) {
    EXPECT_EQ(one[i].state, two[i].state) << i;
    if (one[i].HasPose()) {
      EXPECT_EQ(one[i].world_from_camera, two[i].world_from_camera) << i;
    }
  }
}

}  // namespace
}  // namespace surfit::testing
