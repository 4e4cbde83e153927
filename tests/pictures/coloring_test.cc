#include <gtest/gtest.h>

#include <cmath>

#include "output/pictures/canvas.h"

namespace surfit::testing {
namespace {

// End colours of viridis (van der Walt and Smith 2015): (0.267, 0.005, 0.329) and (0.993, 0.906,
// 0.144), in 8 bits with a rounding error of 1.
void ExpectNear(Rgb8 color, int r, int g, int b) {
  EXPECT_NEAR(color.r, r, 1);
  EXPECT_NEAR(color.g, g, 1);
  EXPECT_NEAR(color.b, b, 1);
}

TEST(ColorScale, EndsAtTheColorsOfViridis) {
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

TEST(ColorScale, IsTheLowEndForOneValueAndNan) {
  EXPECT_EQ(ColorScale(3, 3, false).Position(3), 0);
  EXPECT_EQ(ColorScale(1, 3, false).Position(std::nan("")), 0);
}

TEST(DrawColorBar, RunsFromLowToHighColor) {
  for (const bool logarithmic : {false, true}) {
    Image<Rgb8> image(300, 80, {255, 255, 255});
    const ColorScale scale(1, 50, logarithmic);
    DrawColorBar(&image, scale, {50, 10, 250, 30});
    // Inside the frame, away from ticks. Adjacent columns differ by one of 200 steps.
    const Rgb8 low = image(53, 20), high = image(247, 20);
    ExpectNear(low, scale.ColorAt(0.015).r, scale.ColorAt(0.015).g, scale.ColorAt(0.015).b);
    ExpectNear(high, scale.ColorAt(0.985).r, scale.ColorAt(0.985).g, scale.ColorAt(0.985).b);
  }
}

TEST(Dimmed, ScalesEachComponent) {
  EXPECT_EQ(Dimmed({200, 102, 255}, 0.5f), (Rgb8{100, 51, 128}));
  EXPECT_EQ(Dimmed({200, 101, 255}, 1), (Rgb8{200, 101, 255}));
}

SurfelMap TwoSurfels() {
  SurfelMap map;
  Surfel surfel;
  surfel.color = {10, 20, 30};
  surfel.normal_in_world = {0, 0, -1};
  surfel.confidence = 0.5f;
  surfel.last_seen = 7;
  map.Append(surfel);
  surfel.normal_in_world = {0.6f, -0.8f, 0};
  surfel.confidence = 50;
  surfel.last_seen = 57;
  map.Append(surfel);
  return map;
}

TEST(SurfelColoring, ColorIsTheColorOfTheSurfel) {
  const SurfelMap map = TwoSurfels();
  EXPECT_EQ(ColorByColor(map).color_of(0), (Rgb8{10, 20, 30}));
}

TEST(SurfelColoring, NormalIsHalfOfOnePlusN) {
  const SurfelMap map = TwoSurfels();
  const SurfelColoring coloring = ColorByNormal(map);
  // 255 (1 + n) / 2: 127.5 rounds up, 1.6 * 127.5 = 204, and 0.2 * 127.5 = 25.5 rounds to 25 or 26,
  // because 0.8 is not exact in single precision.
  EXPECT_EQ(coloring.color_of(0), (Rgb8{128, 128, 0}));
  const Rgb8 second = coloring.color_of(1);
  EXPECT_EQ(second.r, 204);
  EXPECT_NEAR(second.g, 25.5, 0.5);
  EXPECT_EQ(second.b, 128);
}

TEST(SurfelColoring, ConfidenceSpansTheRangeOfTheMapLogarithmically) {
  const SurfelMap map = TwoSurfels();
  const SurfelColoring coloring = ColorByConfidence(map);
  EXPECT_FLOAT_EQ(coloring.scale->low(), 0.5);
  EXPECT_FLOAT_EQ(coloring.scale->high(), 50);
  EXPECT_TRUE(coloring.scale->logarithmic());
  EXPECT_EQ(coloring.color_of(0), coloring.scale->ColorAt(0));
  EXPECT_EQ(coloring.color_of(1), coloring.scale->ColorAt(1));
}

TEST(SurfelColoring, ConfidenceOfZeroHasAScale) {
  SurfelMap map = TwoSurfels();
  map.block(0).SetConfidence(0, 0);
  map.block(0).SetConfidence(1, 200);
  const SurfelColoring coloring = ColorByConfidence(map);
  EXPECT_FLOAT_EQ(coloring.scale->low(), 0.02);  // four decades
  map.block(0).SetConfidence(1, 0);
  EXPECT_FLOAT_EQ(ColorByConfidence(map).scale->low(), 0.01);
  EXPECT_FLOAT_EQ(ColorByConfidence(map).scale->high(), 1);
}

TEST(SurfelColoring, LastSeenSpansTheFrames) {
  const SurfelMap map = TwoSurfels();
  const SurfelColoring coloring = ColorByLastSeen(map);
  EXPECT_EQ(coloring.scale->low(), 7);
  EXPECT_EQ(coloring.scale->high(), 57);
  EXPECT_EQ(coloring.color_of(0), coloring.scale->ColorAt(0));
  EXPECT_EQ(coloring.color_of(1), coloring.scale->ColorAt(1));
}

}  // namespace
}  // namespace surfit::testing
