#include "pictures/surfel_coloring.h"

#include <gtest/gtest.h>

namespace surfit {
namespace {

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

TEST(SurfelColoring, ColorIsTheSurfelsOwn) {
  const SurfelMap map = TwoSurfels();
  EXPECT_EQ(ColorByColor(map).color_of(0), (Rgb8{10, 20, 30}));
}

TEST(SurfelColoring, NormalIsHalfOfOnePlusN) {
  const SurfelMap map = TwoSurfels();
  const SurfelColoring coloring = ColorByNormal(map);
  // 255 (1 + n) / 2: 127.5 is rounded up; 1.6 * 127.5 = 204; 0.2 * 127.5 = 25.5, rounded up but for
  // the single precision of 0.8.
  EXPECT_EQ(coloring.color_of(0), (Rgb8{128, 128, 0}));
  const Rgb8 second = coloring.color_of(1);
  EXPECT_EQ(second.r, 204);
  EXPECT_NEAR(second.g, 25.5, 0.5);
  EXPECT_EQ(second.b, 128);
}

TEST(SurfelColoring, ConfidenceSpansTheMapsRangeLogarithmically) {
  const SurfelMap map = TwoSurfels();
  const SurfelColoring coloring = ColorByConfidence(map);
  EXPECT_FLOAT_EQ(coloring.scale->low(), 0.5);
  EXPECT_FLOAT_EQ(coloring.scale->high(), 50);
  EXPECT_TRUE(coloring.scale->logarithmic());
  EXPECT_EQ(coloring.color_of(0), coloring.scale->ColorAt(0));
  EXPECT_EQ(coloring.color_of(1), coloring.scale->ColorAt(1));
}

TEST(SurfelColoring, ConfidenceOfZeroHasAScaleToo) {
  SurfelMap map = TwoSurfels();
  float* const confidence = map.block(0).confidence;
  confidence[0] = 0;
  confidence[1] = 1e6f;
  const SurfelColoring coloring = ColorByConfidence(map);
  EXPECT_FLOAT_EQ(coloring.scale->low(), 100);  // four decades
  confidence[1] = 0;
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
}  // namespace surfit
