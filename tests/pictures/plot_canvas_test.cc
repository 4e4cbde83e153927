#include "pictures/plot_canvas.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pictures/picture_file.h"

namespace surfit {
namespace {

constexpr Rgb8 kPaper = {255, 255, 255};
constexpr Rgb8 kRed = {250, 0, 10};

TEST(PlotCanvas, KeepsWhatIsInTheImage) {
  Image<Rgb8> image(40, 30, {12, 34, 56});
  image(7, 8) = {200, 100, 50};
  const Image<Rgb8> before = image;
  { PlotCanvas canvas(&image); }
  EXPECT_EQ(image, before);
}

TEST(PlotCanvas, DrawsALineThroughThePixelsItNames) {
  Image<Rgb8> image(60, 40, kPaper);
  {
    PlotCanvas canvas(&image);
    canvas.SetColor(kRed);
    canvas.SetLineWidth(3);
    canvas.Line({10, 50}, {12, 12});
  }
  // Three pixels high, so that the middle row and the ends' inner pixels are wholly covered.
  for (int u = 11; u <= 49; ++u) EXPECT_EQ(image(u, 12), kRed) << u;
  EXPECT_EQ(image(30, 9), kPaper);
  EXPECT_EQ(image(30, 15), kPaper);
  EXPECT_EQ(image(5, 12), kPaper);
  EXPECT_EQ(image(55, 12), kPaper);
}

TEST(PlotCanvas, AxesMapTheirRangesToTheBox) {
  Image<Rgb8> image(300, 200, kPaper);
  {
    PlotCanvas canvas(&image);
    canvas.BeginAxes({{100, 50, 200, 150}, {{0, 10}, {5, -5}}, "title", "x", "y"});
    canvas.SetColor(kRed);
    canvas.SetLineWidth(3);
    canvas.Line({-100, 100}, {-2.5, -2.5});  // a quarter below the top edge, which is -5
  }
  EXPECT_EQ(image(150, 75), kRed);
  EXPECT_EQ(image(150, 125), kPaper);
  EXPECT_EQ(image(250, 75), kPaper);  // clipped
  EXPECT_EQ(image(50, 75), kPaper);
}

TEST(PlotCanvas, TextAndMarkersAppearWhereTheyShould) {
  Image<Rgb8> image(200, 60, kPaper);
  {
    PlotCanvas canvas(&image);
    canvas.Text(100, 30, "surfel");
    canvas.SetColor(kRed);
    canvas.Marker(50, 30, PlotCanvas::MarkerShape::kSquare);
  }
  EXPECT_EQ(image(50, 30), kRed);
  int dark_right = 0, dark_left = 0;
  for (int v = 0; v < 60; ++v) {
    for (int u = 0; u < 200; ++u) {
      if (image(u, v).r < 128) ++(u >= 98 ? dark_right : dark_left);
    }
  }
  EXPECT_GT(dark_right, 50);
  EXPECT_EQ(dark_left, 0);
}

// PLplot knows 100 streams at most: each must be given back.
TEST(PlotCanvas, ManyCanBeUsedOneAfterTheOther) {
  Image<Rgb8> image(20, 20, kPaper);
  for (int i = 0; i < 120; ++i) {
    PlotCanvas canvas(&image);
    canvas.SetColor(kRed);
    canvas.SetLineWidth(3);
    canvas.Line({0, 20}, {10, 10});
  }
  EXPECT_EQ(image(10, 10), kRed);
}

}  // namespace
}  // namespace surfit
