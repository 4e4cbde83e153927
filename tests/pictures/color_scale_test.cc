#include "pictures/color_scale.h"

#include <gtest/gtest.h>

#include <cmath>

#include "pictures/color_bar.h"

namespace surfit {
namespace {

// The ends of viridis (van der Walt and Smith 2015): (0.267, 0.005, 0.329) and (0.993, 0.906,
// 0.144), in 8 bits, where rounding may go either way.
void ExpectNear(Rgb8 color, int r, int g, int b) {
  EXPECT_NEAR(color.r, r, 1);
  EXPECT_NEAR(color.g, g, 1);
  EXPECT_NEAR(color.b, b, 1);
}

TEST(ColorScale, EndsAreThoseOfViridis) {
  const ColorScale scale(2, 7, false);
  ExpectNear(scale.ColorOf(2), 68, 1, 84);
  ExpectNear(scale.ColorOf(7), 253, 231, 37);
  EXPECT_EQ(scale.ColorOf(-100), scale.ColorOf(2));
  EXPECT_EQ(scale.ColorOf(100), scale.ColorOf(7));
}

TEST(ColorScale, IsLinearOrLogarithmicBetween) {
  EXPECT_DOUBLE_EQ(ColorScale(2, 6, false).Position(3), 0.25);
  EXPECT_DOUBLE_EQ(ColorScale(0.1, 1000, true).Position(1), 0.25);
}

TEST(ColorScale, OfOneValueAndOfNoNumberIsItsLowEnd) {
  EXPECT_EQ(ColorScale(3, 3, false).Position(3), 0);
  EXPECT_EQ(ColorScale(1, 3, false).Position(std::nan("")), 0);
}

TEST(DrawColorBar, RunsFromTheLowColorToTheHighOne) {
  for (const bool logarithmic : {false, true}) {
    Image<Rgb8> image(300, 80, {255, 255, 255});
    const ColorScale scale(1, 50, logarithmic);
    {
      PlotCanvas canvas(&image);
      DrawColorBar(&canvas, scale, {50, 10, 250, 30});
    }
    // Just inside the frame, away from ticks; neighbouring columns blend, by one step of 200.
    const Rgb8 low = image(53, 20), high = image(247, 20);
    ExpectNear(low, scale.ColorAt(0.015).r, scale.ColorAt(0.015).g, scale.ColorAt(0.015).b);
    ExpectNear(high, scale.ColorAt(0.985).r, scale.ColorAt(0.985).g, scale.ColorAt(0.985).b);
  }
}

}  // namespace
}  // namespace surfit
