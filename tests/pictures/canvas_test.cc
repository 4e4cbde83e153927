#include "pictures/canvas.h"

#include <gtest/gtest.h>

#include "pictures/map_views.h"

namespace surfit {
namespace {

constexpr Rgb8 kPaper = {255, 255, 255};
constexpr Rgb8 kRed = {250, 0, 10};

TEST(DrawLine, PassesThroughThePixelsItNames) {
  Image<Rgb8> image(60, 40, kPaper);
  DrawLine(&image, {{10, 12}, {50, 12}}, kRed, 3);
  // Three pixels high, so that the middle row and the ends' inner pixels are wholly covered.
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

TEST(FillBox, FillsTheNamedPixelsAndWhatIsInTheImageOfThem) {
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
  for (int v = 0; v < image.height(); ++v) {
    for (int u = 0; u < image.width(); ++u) {
      if (image(u, v).r >= 128) continue;
      ink.left = std::min(ink.left, u), ink.right = std::max(ink.right, u);
      ink.top = std::min(ink.top, v), ink.bottom = std::max(ink.bottom, v);
      ++ink.count;
    }
  }
  return ink;
}

TEST(DrawText, BeginsIsCentredOrEndsAtItsPoint) {
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
      EXPECT_NEAR(0.5 * (ink.top + ink.bottom), 40, 1);  // capitals: nothing below the line
      EXPECT_NEAR(ink.bottom - ink.top, 0.75 * height_px, 2);
    }
  }
}

TEST(DrawText, LeavesOutWhatLiesOutsideTheImage) {
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

}  // namespace
}  // namespace surfit
