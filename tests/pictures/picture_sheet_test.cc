#include "pictures/picture_sheet.h"

#include <gtest/gtest.h>

#include "pictures/index_coloring.h"

namespace surfit {
namespace {

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

TEST(Dimmed, ScalesEachComponent) {
  EXPECT_EQ(Dimmed({200, 102, 255}, 0.5f), (Rgb8{100, 51, 128}));
  EXPECT_EQ(Dimmed({200, 101, 255}, 1), (Rgb8{200, 101, 255}));
}

}  // namespace
}  // namespace surfit
