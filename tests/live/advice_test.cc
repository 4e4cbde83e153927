#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "live/live_fixture.h"

namespace surfit {
namespace {

std::vector<std::string> Kinds(const LiveFixture& live, const Rigid3d* before = nullptr) {
  std::vector<std::string> kinds;
  for (const Advice& advice : Advise(live.Frame(), before)) {
    EXPECT_FALSE(advice.text.empty());
    kinds.push_back(advice.kind);
  }
  return kinds;
}

using testing::ElementsAre;
using testing::IsEmpty;

TEST(Advice, IsEmptyForGoodFrames) {
  LiveFixture live;
  const Rigid3d before = live.report_.world_from_camera;
  live.report_.world_from_camera.translation.x() = 0.01;
  EXPECT_THAT(Kinds(live, &before), IsEmpty());
  EXPECT_THAT(Kinds(live), IsEmpty());
}

TEST(Advice, ReportsLostFrames) {
  LiveFixture live;
  live.report_.state = FrameState::kLost;
  const Rigid3d before;
  EXPECT_THAT(Kinds(live, &before), ElementsAre("lost"));
}

// The image is 160 px wide with a focal length of 140 px. It moves by 5 % of its width for a
// rotation of 0.057 rad, or a translation of 0.114 m at a depth of 2 m.
TEST(Advice, ReportsFastMotion) {
  LiveFixture live;
  const Rigid3d before;
  for (const double x : {0.108, 0.121}) {
    live.report_.world_from_camera.translation.x() = x;
    EXPECT_EQ(Kinds(live, &before).size(), x > 0.114 ? 1u : 0u) << x;
  }
  live.report_.world_from_camera = Rigid3d();
  for (const double angle : {0.054, 0.06}) {
    live.report_.world_from_camera.rotation =
        Eigen::Quaterniond(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitY()));
    EXPECT_EQ(Kinds(live, &before).size(), angle > 0.057 ? 1u : 0u) << angle;
  }
  EXPECT_THAT(Kinds(live, &before), ElementsAre("too_fast"));
}

TEST(Advice, ReportsCloseSurfaces) {
  LiveFixture live;
  live.frame_.depth_m = Image<float>(160, 120, 0.4f);
  EXPECT_THAT(Kinds(live), ElementsAre("too_close"));
}

TEST(Advice, ReportsMissingDepth) {
  LiveFixture live;
  for (int v = 0; v < 90; ++v) std::fill_n(live.frame_.depth_m.row(v), 160, 0.f);
  EXPECT_THAT(Kinds(live), ElementsAre("little_depth"));
  live.frame_.depth_m = Image<float>(160, 120, 0.f);
  EXPECT_THAT(Kinds(live), ElementsAre("little_depth"));
}

TEST(Advice, ReportsWeakGeometryAndMovingObjects) {
  LiveFixture live;
  live.report_.state = FrameState::kDegenerate;
  live.report_.moving_ratio = 0.2;
  EXPECT_THAT(Kinds(live), ElementsAre("little_shape", "moving"));
}

}  // namespace
}  // namespace surfit
