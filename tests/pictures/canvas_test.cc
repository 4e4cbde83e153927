#include "output/pictures/canvas.h"

#include <gmock/gmock.h>

#include <Eigen/Geometry>

#include "output/pictures/axes.h"
#include "output/pictures/map_views.h"
#include "testing/matchers.h"
#include "testing/pixels.h"

namespace surfit::testing {
namespace {

using ::testing::DoubleEq;

constexpr Rgb8 kPaper = {255, 255, 255};
constexpr Rgb8 kRed = {250, 0, 10};

TEST(DrawLine, PassesThroughTheGivenPixels) {
  Image<Rgb8> image(60, 40, kPaper);
  DrawLine(&image, {{10, 12}, {50, 12}}, kRed, 3);
  // The line is three pixels high: the middle row is fully covered.
  for (int u = 11; u <= 49; ++u) EXPECT_EQ(image(u, 12), kRed) << u;
  EXPECT_EQ(image(30, 9), kPaper);
  EXPECT_EQ(image(30, 15), kPaper);
  EXPECT_EQ(image(5, 12), kPaper);
  EXPECT_EQ(image(55, 12), kPaper);
}

TEST(DrawDisc, IsCentredAndRound) {
  Image<Rgb8> image(41, 41, kPaper);
  DrawDisc(&image, {20, 20}, 10, kRed);
  for (const auto& [u, v] : {std::pair(20, 20), std::pair(11, 20), std::pair(20, 29)}) {
    EXPECT_EQ(image(u, v), kRed) << u << " " << v;
  }
  for (const auto& [u, v] : {std::pair(8, 20), std::pair(20, 32), std::pair(12, 12)}) {
    EXPECT_EQ(image(u, v), kPaper) << u << " " << v;
  }
}

TEST(FillBox, FillsTheGivenPixelsWithinTheImage) {
  Image<Rgb8> image(10, 10, kPaper);
  FillBox(&image, {7, 3, 20, 4}, kRed);
  EXPECT_EQ(std::count(image.begin(), image.end(), kRed), 3 * 2);
  EXPECT_EQ(image(7, 3), kRed);
  EXPECT_EQ(image(9, 4), kRed);
}

struct Ink {
  int left = 1 << 30, right = -1, top = 1 << 30, bottom = -1, count = 0;
};

Ink InkOf(const Image<Rgb8>& image) {
  Ink ink;
  for (const auto [u, v] : PixelsOf(image)) {
    if (image(u, v).r >= 128) continue;
    ink.left = std::min(ink.left, u), ink.right = std::max(ink.right, u);
    ink.top = std::min(ink.top, v), ink.bottom = std::max(ink.bottom, v);
    ++ink.count;
  }
  return ink;
}

TEST(DrawText, AlignsLeftCentreAndRight) {
  for (const double height_px : {12, 18, 40}) {
    for (const double justify : {0., 0.5, 1.}) {
      SCOPED_TRACE(::testing::Message() << height_px << " " << justify);
      Image<Rgb8> image(400, 80, kPaper);
      const TextStyle style = {height_px, justify};
      DrawText(&image, {200, 40}, "HEXH", style);
      const Ink ink = InkOf(image);
      const double left = 200 - justify * TextWidth("HEXH", style);
      EXPECT_GT(ink.count, 50);
      EXPECT_NEAR(ink.left, left, 1 + height_px / 8);
      EXPECT_NEAR(ink.right, left + TextWidth("HEXH", style), 1 + height_px / 4);
      EXPECT_NEAR(0.5 * (ink.top + ink.bottom), 40, 1);  // capitals have no descenders
      EXPECT_NEAR(ink.bottom - ink.top, 0.75 * height_px, 2);
    }
  }
}

TEST(DrawText, ClipsAtTheImageBorder) {
  for (const PixelPoint at : {PixelPoint{-30, 10}, {90, -2}, {95, 22}, {500, 500}}) {
    Image<Rgb8> image(100, 20, kPaper);
    EXPECT_NO_THROW(DrawText(&image, at, "surfel"));
  }
}

TEST(PictureSheet, CellsAreTheMeansOfFinerPixels) {
  PictureSheet sheet(2, 2);
  Image<Rgb8> finer(1600, 1200, {10, 20, 30});
  finer(0, 0) = {14, 20, 30};
  finer(1, 1) = {16, 20, 30};       // (14 + 16 + 10 + 10) / 4 = 12.5, rounded up
  finer(1599, 1199) = {10, 0, 30};  // (0 + 3 * 20) / 4
  sheet.SetCell(3, finer);
  const Image<Rgb8>& image = *sheet.image();
  EXPECT_EQ(image.width(), 2 * 800 + 8);
  EXPECT_EQ(image.height(), 76 + 2 * (600 + 34));
  EXPECT_EQ(image(808, 710), (Rgb8{13, 20, 30}));
  EXPECT_EQ(image(809, 710), (Rgb8{10, 20, 30}));
  EXPECT_EQ(image(1607, 1309), (Rgb8{10, 15, 30}));
  EXPECT_EQ(image(807, 710), PictureSheet::kPaper);
  EXPECT_EQ(image(808, 709), PictureSheet::kPaper);
}

TEST(EqualAspect, WidensTheOtherAxisToTheSameScale) {
  const AxisRanges ranges = EqualAspect({{0, 9}, {4, 6}}, 500, 200);
  // 9 m fill 90 % of 500 pixels: 2 cm per pixel, so 10 m by 4 m with the same centre.
  EXPECT_DOUBLE_EQ(ranges.x.begin, -0.5);
  EXPECT_DOUBLE_EQ(ranges.x.end, 9.5);
  EXPECT_DOUBLE_EQ(ranges.y.begin, 3);
  EXPECT_DOUBLE_EQ(ranges.y.end, 7);
}

TEST(EqualAspect, KeepsTheDirectionOfAReversedAxis) {
  const AxisRanges ranges = EqualAspect({{0, 1}, {9, 0}}, 100, 100);
  EXPECT_DOUBLE_EQ(ranges.y.begin, 9.5);
  EXPECT_DOUBLE_EQ(ranges.y.end, -0.5);
  EXPECT_DOUBLE_EQ(ranges.x.begin, -4.5);
  EXPECT_DOUBLE_EQ(ranges.x.end, 5.5);
}

TEST(EqualAspect, HasAMinimumRangeOfAMillimetre) {
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

TEST(ChooseTrajectoryAxes, SideViewShowsTheLongerAxis) {
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

TEST(LogarithmicTicks, ArePowersOfTenOrDenserForSmallRanges) {
  EXPECT_THAT(LogarithmicTicks(0.05, 200),
              ElementsAre(DoubleEq(0.1), DoubleEq(1), DoubleEq(10), DoubleEq(100)));
  EXPECT_THAT(LogarithmicTicks(1, 30), ElementsAre(1, 2, 5, 10, 20));
}

TEST(DrawAxes, MapTheirRangesToTheBox) {
  Image<Rgb8> image(300, 200, kPaper);
  const Axes axes{{100, 50, 200, 150}, {{0, 10}, {5, -5}}, "title", "x", "y"};
  DrawAxes(&image, axes);
  // y = -2.5 is a quarter of the height below the top edge, which is y = -5.
  DrawLine(&image, {axes.At(1, -2.5), axes.At(9, -2.5)}, kRed, 3);
  EXPECT_EQ(image(150, 75), kRed);
  EXPECT_EQ(image(150, 135), kPaper);
  EXPECT_NE(image(100, 100), kPaper);  // the frame
}

}  // namespace
}  // namespace surfit::testing
