#include "surfit/geometry/inverse_depth_field.h"

#include <gtest/gtest.h>

namespace surfit {
namespace {

const InverseDepthField kField = {{-0.01, 0.02, -0.03, 0.04, 0.05, -0.06}};

TEST(InverseDepthField, IsThePolynomialOfTheRay) {
  const double x = 0.3, y = -0.4;
  EXPECT_NEAR(kField.At(x, y),
              -0.01 + 0.02 * x - 0.03 * y + 0.04 * x * x + 0.05 * x * y - 0.06 * y * y, 1e-15);
}

TEST(InverseDepthField, AddsToInverseDepth) {
  const InverseDepthField offset = {{0.02 / 3}};
  EXPECT_FLOAT_EQ(offset.Corrected(3, 0.1, 0.2), 3 / 1.02);
  EXPECT_EQ(offset.Corrected(0, 0.1, 0.2), 0);
  EXPECT_EQ(InverseDepthField{{-0.5}}.Corrected(3, 0.1, 0.2), 0);  // no positive depth
}

TEST(InverseDepthField, IsTheSameByOtherRays) {
  const double x_scale = 0.9, x_shift = 0.02, y_scale = 1.2, y_shift = -0.1;
  const InverseDepthField other = kField.Substituted(x_scale, x_shift, y_scale, y_shift);
  for (const double x : {-0.5, 0.2}) {
    for (const double y : {-0.3, 0.4}) {
      EXPECT_NEAR(other.At(x, y), kField.At(x_scale * x + x_shift, y_scale * y + y_shift), 1e-15);
    }
  }
}

TEST(InverseDepthField, HasItsValuesAtTheMirroredRays) {
  EXPECT_NEAR(Mirrored(kField).At(0.3, -0.2), kField.At(0.3, 0.2), 1e-15);
}

}  // namespace
}  // namespace surfit
