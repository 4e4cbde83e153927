#include "pictures/axes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

namespace surfit {
namespace {

using ::testing::DoubleEq;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

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

class TrajectoryAxesTest : public ::testing::TestWithParam<Eigen::Vector3d> {};

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
                         ::testing::Values(Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(-1, 0, 0),
                                           Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(0, -1, 0),
                                           Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(0, 0, -1)));

TEST(ChooseTrajectoryAxes, TheSideShowsTheLongerWay) {
  EXPECT_EQ(ChooseTrajectoryAxes({0, -1, 0}, {1, 9, 2})[1].horizontal, 2);
  EXPECT_EQ(ChooseTrajectoryAxes({0, -1, 0}, {3, 9, 2})[1].horizontal, 0);
}

TEST(RoundTicks, AreOneTwoOrFiveTimesPowersOfTenApart) {
  EXPECT_THAT(RoundTicks({-0.31, 0.52}, 5), ElementsAre(-0.2, 0, 0.2, 0.4));
  EXPECT_THAT(RoundTicks({10, 0}, 5), ElementsAre(0, 2, 4, 6, 8, 10));
  EXPECT_THAT(RoundTicks({3, 3}, 5), IsEmpty());
  EXPECT_EQ(TickText(RoundTicks({0, 0.3}, 3)[3]), "0.3");
  EXPECT_EQ(TickText(RoundTicks({-0.1, 1}, 3)[0]), "0");
}

TEST(LogarithmicTicks, ArePowersOfTenOrMoreWhereTheseAreFew) {
  EXPECT_THAT(LogarithmicTicks(0.05, 200),
              ElementsAre(DoubleEq(0.1), DoubleEq(1), DoubleEq(10), DoubleEq(100)));
  EXPECT_THAT(LogarithmicTicks(1, 30), ElementsAre(1, 2, 5, 10, 20));
}

TEST(DrawAxes, MapTheirRangesToTheBox) {
  constexpr Rgb8 kPaper = {255, 255, 255}, kRed = {250, 0, 10};
  Image<Rgb8> image(300, 200, kPaper);
  const Axes axes{{100, 50, 200, 150}, {{0, 10}, {5, -5}}, "title", "x", "y"};
  DrawAxes(&image, axes);
  // A quarter below the top edge, which is -5.
  DrawLine(&image, {axes.At(1, -2.5), axes.At(9, -2.5)}, kRed, 3);
  EXPECT_EQ(image(150, 75), kRed);
  EXPECT_EQ(image(150, 135), kPaper);
  EXPECT_NE(image(100, 100), kPaper);  // the frame
}

}  // namespace
}  // namespace surfit
