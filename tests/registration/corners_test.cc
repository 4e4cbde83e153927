#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "registration/global/feature_points.h"

namespace surfit::testing {
namespace {

constexpr int kWidth = 160, kHeight = 120;

// Non-periodic pattern, shifted to the right by `shift_px`. Columns from `end` have constant
// brightness.
Image<Rgb8> Pattern(double shift_px, double gain = 1, double offset = 0, int end = kWidth) {
  Image<Rgb8> image(kWidth, kHeight);
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const double x = u - shift_px, y = v;
      const double wave = std::sin(0.31 * x + 0.11 * y) + std::sin(0.23 * y - 0.07 * x) +
                          std::sin(0.017 * x * y / 10 + 0.4 * y);
      const double grey = u < end ? 120 + 30 * wave : 120;
      const auto value =
          static_cast<std::uint8_t>(std::clamp(std::lround(gain * grey + offset), 1L, 255L));
      image(u, v) = {value, value, value};
    }
  }
  return image;
}

CornerTracks TracksOf(const Image<Rgb8>& image) {
  const GreyPyramid grey = MakeGreyPyramid(image);
  return {grey, FindCorners(grey, Image<float>(kWidth, kHeight, 1.f), 100)};
}

Eigen::Vector2f WhereItWas(const CornerTracks::Track& track) { return track.last; }

TEST(CornerTracks, FollowMotionWithBrightnessChange) {
  CornerTracks tracks = TracksOf(Pattern(0));
  const std::size_t count = tracks.Lasting(WhereItWas).size();
  ASSERT_GE(count, 40u);
  double shift_px = 0;
  for (int i = 1; i <= 4; ++i) {
    shift_px += 3.3;
    tracks.Follow(MakeGreyPyramid(Pattern(shift_px, 1 - 0.05 * i, 5 * i)), WhereItWas);
  }
  const std::vector<CornerTracks::Track> lasting = tracks.Lasting(WhereItWas);
  ASSERT_GE(lasting.size(), count / 2);
  int right = 0;
  for (const CornerTracks::Track& track : lasting) {
    const Eigen::Vector2f moved = track.last - track.first;
    right += (moved - Eigen::Vector2f(static_cast<float>(shift_px), 0)).norm() < 0.3f;
  }
  EXPECT_GE(right, 0.9 * static_cast<double>(lasting.size()));
}

TEST(CornerTracks, LoseCornersThatDisappear) {
  CornerTracks tracks = TracksOf(Pattern(0));
  tracks.Follow(MakeGreyPyramid(Pattern(0, 1, 0, kWidth / 2)), WhereItWas);
  for (const CornerTracks::Track& track : tracks.Lasting(WhereItWas)) {
    EXPECT_LT(track.first.x(), kWidth / 2 + 9);
  }
}

// Tiles with a period of 16 px, and a weak pattern that is not periodic.
Image<Rgb8> Tiles(double shift_px) {
  Image<Rgb8> image = Pattern(shift_px, 0.2, 40);
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const double wave = std::sin(2 * M_PI * (u - shift_px) / 16) * std::sin(2 * M_PI * v / 16.);
      const auto value = static_cast<std::uint8_t>(image(u, v).r + std::lround(60 + 60 * wave));
      image(u, v) = {value, value, value};
    }
  }
  return image;
}

TEST(CornerTracks, ThatJumpBetweenTilesReturnToTheExpectedPlace) {
  constexpr float kShift_px = 5, kPeriod_px = 16;
  const GreyPyramid next = MakeGreyPyramid(Tiles(kShift_px));
  const auto at = [](float shift_px) {
    return [shift_px](const CornerTracks::Track& track) {
      return Eigen::Vector2f(track.first + Eigen::Vector2f(shift_px, 0));
    };
  };
  const auto right_ratio = [](const std::vector<CornerTracks::Track>& lasting) {
    EXPECT_GE(lasting.size(), 20u);
    return std::count_if(lasting.begin(), lasting.end(),
                         [](const CornerTracks::Track& track) {
                           return std::abs(track.last.x() - track.first.x() - kShift_px) < 1;
                         }) /
           static_cast<double>(lasting.size());
  };
  CornerTracks jumped = TracksOf(Tiles(0)), right = jumped;
  jumped.Follow(next, at(kShift_px - kPeriod_px));
  EXPECT_LT(right_ratio(jumped.Lasting(WhereItWas)), 0.2);
  EXPECT_GT(right_ratio(jumped.Lasting(at(kShift_px + 0.7f))), 0.9);
  // A wrong expectation does not replace a better match.
  right.Follow(next, at(kShift_px));
  EXPECT_GT(right_ratio(right.Lasting(at(kShift_px - kPeriod_px))), 0.9);
}

TEST(FindCorners, FindsCornersOnlyWithDepthAndTexture) {
  const GreyPyramid grey = MakeGreyPyramid(Pattern(0, 1, 0, kWidth / 2));
  Image<float> depth_m(kWidth, kHeight, 1.f);
  for (int v = 0; v < kHeight / 2; ++v) {
    for (int u = 0; u < kWidth; ++u) depth_m(u, v) = 0;
  }
  const std::vector<Eigen::Vector2f> corners = FindCorners(grey, depth_m, 100);
  ASSERT_GE(corners.size(), 10u);
  for (const Eigen::Vector2f& corner : corners) {
    EXPECT_LE(corner.x(), kWidth / 2 + 1);
    EXPECT_GE(corner.y(), kHeight / 2);
  }
  EXPECT_TRUE(FindCorners(MakeGreyPyramid(Pattern(0, 0, 120)), depth_m, 100).empty());
}

TEST(CornerTracks, AreEmptyForImagesSmallerThanPatch) {
  const GreyPyramid grey = MakeGreyPyramid(Image<Rgb8>(8, 6, Rgb8{90, 90, 90}));
  CornerTracks tracks(grey, {Eigen::Vector2f(4, 3)});
  tracks.Follow(grey, WhereItWas);
  EXPECT_TRUE(tracks.Lasting(WhereItWas).empty());
}

}  // namespace
}  // namespace surfit::testing
