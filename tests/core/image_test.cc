#include "surfit/core/image.h"

#include <gtest/gtest.h>

namespace surfit::testing {
namespace {

TEST(Image, IsRowMajorAndContiguous) {
  Image<int> image(3, 2, 7);
  image(2, 1) = 5;
  EXPECT_EQ(image.size(), 6u);
  EXPECT_EQ(image[5], 5);
  EXPECT_EQ(image.row(1)[2], 5);
  EXPECT_EQ(image[0], 7);
}

TEST(Image, ComparesSizeAndPixels) {
  EXPECT_EQ(Image<int>(3, 2, 7), Image<int>(3, 2, 7));
  EXPECT_FALSE(Image<int>(3, 2, 7) == Image<int>(2, 3, 7));
  EXPECT_FALSE(Image<int>(3, 2, 7) == Image<int>(3, 2, 8));
}

}  // namespace
}  // namespace surfit::testing
