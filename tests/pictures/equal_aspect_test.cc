#include "pictures/equal_aspect.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "pictures/trajectory_axes.h"

namespace surfit {
namespace {

TEST(EqualAspect, WidensTheOtherAxisToTheSameScale) {
  const AxisRanges ranges = EqualAspect({{0, 9}, {4, 6}}, 500, 200);
  // 9 m fill 90 % of 500 pixels: 2 cm a pixel, so 10 m by 4 m about the same centre.
  EXPECT_DOUBLE_EQ(ranges.x.begin, -0.5);
  EXPECT_DOUBLE_EQ(ranges.x.end, 9.5);
  EXPECT_DOUBLE_EQ(ranges.y.begin, 3);
  EXPECT_DOUBLE_EQ(ranges.y.end, 7);
}

TEST(EqualAspect, KeepsTheDirectionOfATurnedAxis) {
  const AxisRanges ranges = EqualAspect({{0, 1}, {9, 0}}, 100, 100);
  EXPECT_DOUBLE_EQ(ranges.y.begin, 9.5);
  EXPECT_DOUBLE_EQ(ranges.y.end, -0.5);
  EXPECT_DOUBLE_EQ(ranges.x.begin, -4.5);
  EXPECT_DOUBLE_EQ(ranges.x.end, 5.5);
}

TEST(EqualAspect, OfAPointIsAMillimetre) {
  const AxisRanges ranges = EqualAspect({{2, 2}, {3, 3}}, 100, 50);
  EXPECT_NEAR(ranges.y.end - ranges.y.begin, 1e-3 / 0.9, 1e-12);
  EXPECT_NEAR(ranges.x.end - ranges.x.begin, 2e-3 / 0.9, 1e-12);
}

class TrajectoryAxesTest : public testing::TestWithParam<Eigen::Vector3d> {};

TEST_P(TrajectoryAxesTest, ViewsAreUprightAndNotMirrored) {
  const Eigen::Vector3d up = GetParam();
  const Eigen::Vector3d tilted_up = (up + Eigen::Vector3d(0.2, -0.3, 0.1)).normalized();
  const auto [above, side] = ChooseTrajectoryAxes(tilted_up, {1, 2, 3});
  const auto page_up = [](const ShownAxes& shown) -> Eigen::Vector3d {
    return (shown.vertical_downward ? -1 : 1) * Eigen::Vector3d::Unit(shown.vertical);
  };
  EXPECT_EQ(Eigen::Vector3d::Unit(above.horizontal).cross(page_up(above)), up);
  EXPECT_EQ(page_up(side), up);
  EXPECT_NE(side.horizontal, side.vertical);
}

INSTANTIATE_TEST_SUITE_P(AllAxes, TrajectoryAxesTest,
                         testing::Values(Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(-1, 0, 0),
                                         Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(0, -1, 0),
                                         Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(0, 0, -1)));

TEST(ChooseTrajectoryAxes, TheSideShowsTheLongerWay) {
  EXPECT_EQ(ChooseTrajectoryAxes({0, -1, 0}, {1, 9, 2})[1].horizontal, 2);
  EXPECT_EQ(ChooseTrajectoryAxes({0, -1, 0}, {3, 9, 2})[1].horizontal, 0);
}

}  // namespace
}  // namespace surfit
