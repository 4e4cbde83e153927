#include "apps/scan/link_truth.h"

#include <gmock/gmock.h>

#include "testing/matchers.h"

namespace surfit::testing {
namespace {

using Eigen::Vector3d;

Rigid3d At(double x) { return {Eigen::Quaterniond::Identity(), {x, 0, 0}}; }

// Frames at 10 Hz. Every fifth frame is a keyframe. The estimated poses do not matter.
RunPlaces PlacesFrom(int first, int frames) {
  RunPlaces places;
  for (int i = first; i < first + frames; ++i) {
    PosedFrame frame;
    frame.index = i;
    frame.stamp_s = 0.1 * i;
    frame.world_from_camera = At(100 + i);
    places.frames.push_back(frame);
    if (i % 5 != 0) continue;
    Keyframe keyframe;
    keyframe.frame_index = i;
    places.keyframes.push_back(keyframe);
  }
  return places;
}

class LinkTruthTest : public ::testing::Test {
 protected:
  LinkTruthTest() {
    for (int i = 0; i < 100; ++i) truth_.push_back({0.1 * i, At(0.02 * i)});
  }
  Trajectory truth_;
  const RunPlaces source_ = PlacesFrom(60, 30), target_ = PlacesFrom(10, 30);
};

// The third keyframe of the source is frame 70. The second keyframe of the target is frame 15.
TEST_F(LinkTruthTest, IsTheErrorOfTheLink) {
  const auto right = ErrorOfLink(truth_, source_, 2, target_, 1, At(0.02 * 55));
  ASSERT_TRUE(right);
  EXPECT_NEAR(right->translation_m, 0, 1e-12);
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.1, Vector3d::UnitY()));
  const auto wrong = ErrorOfLink(truth_, source_, 2, target_, 1,
                                 At(0.02 * 55) * Rigid3d(turn, Vector3d(0, 0.3, 0.4)));
  EXPECT_NEAR(wrong->translation_m, 0.5, 1e-12);
  EXPECT_NEAR(wrong->rotation_deg, 0.1 / kRadPerDeg, 1e-9);
}

TEST_F(LinkTruthTest, IsEmptyWithoutGroundTruth) {
  truth_.resize(65);  // before the first keyframe of the source
  EXPECT_TRUE(ErrorOfLink(truth_, source_, 0, target_, 1, At(0)));
  EXPECT_FALSE(ErrorOfLink(truth_, source_, 2, target_, 1, At(0)));
  EXPECT_FALSE(ErrorOfLink({}, source_, 0, target_, 1, At(0)));
}

TEST(UpdateMaximum, KeepsTheLargerError) {
  std::optional<PoseError> worst;
  UpdateMaximum(std::nullopt, &worst);
  EXPECT_FALSE(worst);
  UpdateMaximum(PoseError{0.1, 3}, &worst);
  UpdateMaximum(PoseError{0.3, 1}, &worst);
  UpdateMaximum(PoseError{0.2, 9}, &worst);
  UpdateMaximum(std::nullopt, &worst);
  EXPECT_EQ(worst->translation_m, 0.3);
  EXPECT_EQ(worst->rotation_deg, 1);
}

}  // namespace
}  // namespace surfit::testing
