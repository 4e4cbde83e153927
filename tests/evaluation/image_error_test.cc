#include "apps/evaluate/image_error.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core.hpp>
#include <random>

namespace surfit::testing {
namespace {

// Pattern with noise, so that two images have common structure.
Image<Rgb8> Pattern(int width, int height, int noise, int seed) {
  std::mt19937_64 rng(seed);
  std::uniform_int_distribution<int> error(-noise, noise);
  Image<Rgb8> image(width, height);
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const auto byte = [&](double phase) {
        const double value = 120 + 90 * std::sin(0.35 * u + phase) * std::cos(0.2 * v);
        return static_cast<std::uint8_t>(std::clamp(static_cast<int>(value) + error(rng), 0, 255));
      };
      image(u, v) = {byte(0), byte(1), byte(2)};
    }
  }
  return image;
}

PixelMask AllOf(const Image<Rgb8>& image) { return {image.width(), image.height(), 1}; }

cv::Mat AsMat(const Image<Rgb8>& image) {
  return {image.height(), image.width(), CV_8UC3, const_cast<Rgb8*>(image.data())};
}

std::array<double, 3> Channels(Rgb8 color) { return {1. * color.r, 1. * color.g, 1. * color.b}; }

// SSIM formula at one pixel, with sums over the window in double precision.
double SimilarityAt(const Image<Rgb8>& x, const Image<Rgb8>& y, int u, int v) {
  const auto mirrored = [](int i, int size) {
    return i < 0 ? -i : i >= size ? 2 * size - 2 - i : i;
  };
  double mean = 0;
  for (int c = 0; c < 3; ++c) {
    double w = 0, sx = 0, sy = 0, sxx = 0, syy = 0, sxy = 0;
    for (int dv = -5; dv <= 5; ++dv) {
      for (int du = -5; du <= 5; ++du) {
        const int at_u = mirrored(u + du, x.width()), at_v = mirrored(v + dv, x.height());
        const double weight = std::exp(-(du * du + dv * dv) / (2 * 1.5 * 1.5));
        const double a = Channels(x(at_u, at_v))[c], b = Channels(y(at_u, at_v))[c];
        w += weight, sx += weight * a, sy += weight * b;
        sxx += weight * a * a, syy += weight * b * b, sxy += weight * a * b;
      }
    }
    sx /= w, sy /= w;
    const double vx = sxx / w - sx * sx, vy = syy / w - sy * sy, xy = sxy / w - sx * sy;
    const double c1 = 2.55 * 2.55, c2 = 7.65 * 7.65;
    mean += (2 * sx * sy + c1) * (2 * xy + c2) / ((sx * sx + sy * sy + c1) * (vx + vy + c2)) / 3;
  }
  return mean;
}

TEST(Psnr, AgreesWithOpenCv) {
  const Image<Rgb8> image = Pattern(61, 40, 25, 1), reference = Pattern(61, 40, 0, 2);
  EXPECT_NEAR(Psnr(image, reference, AllOf(image)), cv::PSNR(AsMat(image), AsMat(reference)), 1e-9);
}

TEST(Psnr, UsesPixelsOfMaskOnly) {
  Image<Rgb8> image(4, 2, {10, 20, 30});
  const Image<Rgb8> reference = image;
  image(0, 0) = {200, 200, 200};
  image(1, 0) = {13, 20, 30};
  PixelMask mask = AllOf(image);
  mask(0, 0) = 0;
  // One difference of 3 among the 21 values of 7 pixels.
  EXPECT_NEAR(Psnr(image, reference, mask), 10 * std::log10(255. * 255 / (9. / 21)), 1e-9);
  EXPECT_EQ(CountOf(mask), 7u);
}

TEST(Psnr, IsLimitedForEqualImages) {
  const Image<Rgb8> image = Pattern(20, 20, 5, 3);
  EXPECT_EQ(Psnr(image, image, AllOf(image)), kMaxPsnr_db);
  EXPECT_EQ(Psnr(image, image, PixelMask(20, 20, 0)), 0);
  // The smallest possible difference in an image of half a million pixels is limited as well.
  Image<Rgb8> large(1000, 500), changed(1000, 500);
  changed(3, 4).g = 1;
  EXPECT_EQ(Psnr(changed, large, AllOf(large)), kMaxPsnr_db);
  Image<Rgb8> small(10, 10), other(10, 10);
  other(3, 4).g = 1;
  EXPECT_NEAR(Psnr(other, small, AllOf(small)), 20 * std::log10(255) + 10 * std::log10(300), 1e-9);
}

// Exhaustive search over gains. Between two steps, the PSNR is constant to second order.
TEST(PsnrByGain, IsMaximumOverGains) {
  Image<Rgb8> image = Pattern(61, 40, 25, 1);
  const Image<Rgb8> reference = Pattern(61, 40, 0, 2);
  for (Rgb8& pixel : image) {
    pixel.r = static_cast<std::uint8_t>(0.6 * pixel.r);
    pixel.g = static_cast<std::uint8_t>(0.8 * pixel.g);
  }
  PixelMask mask = AllOf(image);
  for (int u = 0; u < 61; ++u) mask(u, 7) = 0;
  double squares = 0;
  for (int c = 0; c < 3; ++c) {
    double least = 1e12;
    for (double gain = 0.5; gain < 2; gain += 1e-3) {
      double sum = 0;
      for (std::size_t i = 0; i < image.size(); ++i) {
        if (mask[i] != 0)
          sum += std::pow(gain * Channels(image[i])[c] - Channels(reference[i])[c], 2);
      }
      least = std::min(least, sum);
    }
    squares += least;
  }
  const double by_trying = 10 * std::log10(255. * 255 * 3 * CountOf(mask) / squares);
  EXPECT_NEAR(PsnrByGain(image, reference, mask), by_trying, 1e-3);
  EXPECT_GT(by_trying, Psnr(image, reference, mask) + 3);
}

TEST(PsnrByGain, IsLimitedForScaledImages) {
  const Image<Rgb8> dark(10, 10, {20, 30, 40}), light(10, 10, {40, 90, 40}), black(10, 10);
  EXPECT_EQ(PsnrByGain(dark, light, AllOf(dark)), kMaxPsnr_db);
  EXPECT_EQ(PsnrByGain(black, dark, AllOf(dark)), Psnr(black, dark, AllOf(dark)));
  EXPECT_EQ(PsnrByGain(dark, light, PixelMask(10, 10, 0)), 0);
}

// Sums of squares below 2^16 in float have 24 bits, so the variances have an error of 1e-2. C2 is
// 58.
TEST(StructuralSimilarity, AgreesWithFormulaInDoublePrecision) {
  const Image<Rgb8> image = Pattern(37, 29, 40, 4), reference = Pattern(37, 29, 0, 5);
  const Image<float> similarity = StructuralSimilarity(image, reference);
  double least = 1, most = -1;
  for (int v = 0; v < image.height(); ++v) {
    for (int u = 0; u < image.width(); ++u) {
      EXPECT_NEAR(similarity(u, v), SimilarityAt(image, reference, u, v), 1e-3) << u << " " << v;
      least = std::min<double>(least, similarity(u, v));
      most = std::max<double>(most, similarity(u, v));
    }
  }
  EXPECT_LT(least, 0.8);  // the images differ
  EXPECT_GT(most, least + 0.3);
}

TEST(StructuralSimilarity, IsOneForEqualImages) {
  const Image<Rgb8> image = Pattern(30, 20, 5, 6);
  const Image<float> similarity = StructuralSimilarity(image, image);
  EXPECT_NEAR(MeanOf(similarity, AllOf(image)), 1, 1e-6);
  EXPECT_EQ(MeanOf(similarity, PixelMask(30, 20, 0)), 0);
}

}  // namespace
}  // namespace surfit::testing
