#include <gtest/gtest.h>

#include "registration/simulated_views.h"
#include "surfit/core/parallel.h"
#include "surfit/registration/far_registration.h"

namespace surfit {
namespace {

using testing::SimulatedColoredViews;

constexpr double kDegree = M_PI / 180;
// On the coarsest level a pixel is 1 / 33 rad, 1.7 degrees; half of it is what we ask for.
constexpr double kHalfAPixel = 0.87 * kDegree;

// Seen from the same place, turned by 10 degrees.
const SimulatedColoredViews& TurnedViews() {
  static const auto* const views = new SimulatedColoredViews(testing::MakeTurnedViews(
      70, Rigid3d(QuaternionExp<double>({0.05, 0.16, -0.05}), Eigen::Vector3d::Zero()), 12));
  return *views;
}

Rigid3d Align(const SimulatedColoredViews& views, const Rigid3d& start) {
  return AlignRotation(
      {views.source.pyramid, views.source.color, views.target.pyramid, views.target.color}, start);
}

double AngleTo(const Rigid3d& pose, const SimulatedColoredViews& views) {
  return RotationAngle(pose.rotation.conjugate() * views.target_from_source.rotation);
}

TEST(AlignRotation, FindsATurnOfTenDegrees) {
  EXPECT_GT(AngleTo(Rigid3d(), TurnedViews()), 10 * kDegree);
  const Rigid3d pose = Align(TurnedViews(), Rigid3d());
  EXPECT_LT(AngleTo(pose, TurnedViews()), kHalfAPixel);
  EXPECT_EQ(pose.translation.norm(), 0);
}

TEST(AlignRotation, GoesByShapesWithoutColors) {
  SimulatedColoredViews views = TurnedViews();
  views.target.color = {};
  EXPECT_LT(AngleTo(Align(views, Rigid3d()), views), kHalfAPixel);
}

TEST(AlignRotation, StaysWhereNothingIsSeen) {
  const Image<Rgb8> none;
  const Rigid3d start(QuaternionExp<double>({0.1, 0, 0}), {1, 2, 3});
  EXPECT_EQ(AlignRotation({{}, none, {}, none}, start).Matrix(), start.Matrix());
}

TEST(AlignRotation, IsTheSameAtAnyNumberOfThreads) {
  const ThreadLimit one(1);
  const Rigid3d alone = Align(TurnedViews(), Rigid3d());
  const ThreadLimit four(4);
  EXPECT_EQ(Align(TurnedViews(), Rigid3d()).Matrix(), alone.Matrix());
}

}  // namespace
}  // namespace surfit
