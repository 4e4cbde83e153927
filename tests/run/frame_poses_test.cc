#include "finishing/frame_poses.h"

#include <gmock/gmock.h>

#include "surfit/frame/preprocess.h"
#include "surfit/mapping/fusion.h"
#include "surfit/simulation/render.h"
#include "testing/matchers.h"

namespace surfit::testing {
namespace {

Rigid3d Moved(const Rigid3d& pose, double rad, double m) {
  Rigid3d::Vector6 increment;
  increment << rad, -rad, rad, -m, m, m;
  return pose * LeftIncrement<double>(increment, Rigid3d());
}

// A map of one frame of a room.
class FramePosesInARoom : public ::testing::Test {
 protected:
  void SetUp() override {
    frame_ = RenderFrame(scene_, sensor_.camera, truth_);
    const FramePyramid pyramid = PreprocessDepth(frame_.depth_m, sensor_, {});
    Fusion(FusionOptions()).Fuse(frame_, pyramid.levels.front(), truth_, &map_);
  }

  FinalPose Registered(const Rigid3d& world_from_camera) {
    const PosedSequence known = {sequence_, slam_, trajectory_, frames_, left_out_, moving_, {}};
    return FramePoses(known, sensor_, map_)
        .Register({frame_, frame_.depth_m, CameraMotion(), world_from_camera});
  }

  const Scene scene_ = MakeScene("room", 1);
  const Rigid3d truth_ = MakePath(scene_, 1, 1).front().world_from_camera;
  const DepthSensor sensor_ = {{640, 480, 520, 520, 319.5, 239.5, {}}, {}};
  const SequenceOptions sequence_ = {};
  SlamOptions slam_;
  const Trajectory trajectory_ = {};
  const std::vector<int> frames_ = {};
  const std::set<int> left_out_ = {};
  const std::map<int, Image<std::uint8_t>> moving_ = {};
  RgbdFrame frame_;
  SurfelMap map_;
};

TEST_F(FramePosesInARoom, CorrectsAPose) {
  const FinalPose pose = Registered(Moved(truth_, 0.004, 0.004));
  EXPECT_THAT(pose.world_from_camera, RigidNear(truth_, 0.001, 0.002));
  EXPECT_THAT(pose.world_from_color, RigidNear(pose.world_from_camera, 1e-12, 1e-12));
  EXPECT_LT(pose.cost_after, 0.5 * pose.cost_before);
}

TEST_F(FramePosesInARoom, KeepsAPoseThatTheImagesContradict) {
  const Rigid3d moved = Moved(truth_, 0.03, 0.01);
  const FinalPose pose = Registered(moved);
  EXPECT_EQ(pose.cost_before, 0);
  EXPECT_THAT(pose.world_from_camera, RigidNear(moved, 0, 0));
}

TEST_F(FramePosesInARoom, ReplacesTheSolverWithoutAPrior) {
  slam_.icp.solver = "svd";
  EXPECT_THAT(Registered(Moved(truth_, 0.004, 0.004)).world_from_camera,
              RigidNear(truth_, 0.001, 0.002));
}

TEST_F(FramePosesInARoom, IsNotRegisteredWithoutTexture) {
  for (Rgb8& pixel : frame_.color) pixel = {90, 90, 90};
  EXPECT_EQ(Registered(Moved(truth_, 0.004, 0.004)).cost_before, 0);
}

TEST_F(FramePosesInARoom, IsRegisteredByColourAloneWithoutDepth) {
  for (float& z : frame_.depth_m) z = 0;
  const FinalPose pose = Registered(Moved(truth_, 0.004, 0.004));
  EXPECT_LT(pose.cost_after, 0.5 * pose.cost_before);
}

Trajectory AtRest(int frames) {
  Trajectory trajectory;
  for (int i = 0; i < frames; ++i) trajectory.push_back({0.1 * i, Rigid3d()});
  return trajectory;
}

FinalPose At(double x_m, double cost_after) {
  const Rigid3d pose(Eigen::Quaterniond::Identity(), {x_m, 0, 0});
  return {pose, pose, 1, cost_after};
}

TEST(WithFinalPoses, MovesFramesWithoutColourWithTheirNeighbours) {
  const Trajectory moved =
      WithFinalPoses(AtRest(4), {At(0.01, 0.9), std::nullopt, At(0.03, 0.9), std::nullopt});
  EXPECT_NEAR(moved[0].world_from_camera.translation.x(), 0.01, 1e-12);
  EXPECT_NEAR(moved[1].world_from_camera.translation.x(), 0.02, 1e-12);
  EXPECT_NEAR(moved[2].world_from_camera.translation.x(), 0.03, 1e-12);
  EXPECT_NEAR(moved[3].world_from_camera.translation.x(), 0.03, 1e-12);
}

TEST(WithFinalPoses, KeepsNearlyExactPoses) {
  for (const double cost_after : {0.995, 1.}) {
    const Trajectory kept = WithFinalPoses(AtRest(2), {At(0.01, cost_after), At(0.01, cost_after)});
    EXPECT_EQ(kept[0].world_from_camera.translation.x(), 0);
  }
  EXPECT_EQ(WithFinalPoses(AtRest(2), {std::nullopt, std::nullopt}).size(), 2u);
}

}  // namespace
}  // namespace surfit::testing
