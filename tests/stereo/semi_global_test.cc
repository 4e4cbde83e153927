#include "finishing/stereo/semi_global.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "testing/pixels.h"

namespace surfit::testing {
namespace {

constexpr int kWidth = 60, kHeight = 40;

// Labels of a slanted plane.
float LabelAt(int u, int v) {
  return 40.3f + 0.4f * static_cast<float>(u) - 0.2f * static_cast<float>(v);
}

bool HasCosts(int u, int v) { return u >= 5 || v >= 5; }

// Columns without texture: all labels have the same cost.
bool IsUniform(int u) { return u >= 25 && u < 35; }

CostVolume NoisyPlane() {
  Image<std::uint8_t> pixels(kWidth, kHeight, 0);
  for (const auto [u, v] : PixelsOf(pixels)) pixels(u, v) = HasCosts(u, v) ? 1 : 0;
  CostVolume volume(pixels);
  std::mt19937 random(1);
  std::uniform_int_distribution<int> noise(0, 60);
  for (const auto [u, v] : PixelsOf(pixels)) {
    if (volume.IndexOf(u, v) == CostVolume::kNone) continue;
    std::uint8_t* const costs = volume.Costs(volume.IndexOf(u, v));
    for (int d = 0; d < CostVolume::kLabels; ++d) {
      const float distance = std::abs(static_cast<float>(d) - LabelAt(u, v));
      const int cost = static_cast<int>(std::min(120.f, 30 * distance)) + noise(random);
      costs[d] = static_cast<std::uint8_t>(IsUniform(u) ? 20 : cost);
    }
  }
  return volume;
}

TEST(SemiGlobal, FindsTheLabelsOfAPlaneInNoise) {
  const Image<float> labels = BestLabels(NoisyPlane(), Image<std::uint8_t>(kWidth, kHeight, 100));
  double squares = 0;
  int count = 0;
  for (const auto [u, v] : PixelsOf(labels)) {
    if (!HasCosts(u, v)) {
      EXPECT_EQ(labels(u, v), -1);
    } else if (!IsUniform(u)) {
      squares += std::pow(labels(u, v) - LabelAt(u, v), 2);
      ++count;
    }
  }
  EXPECT_LT(std::sqrt(squares / count), 0.5);
}

TEST(SemiGlobal, InterpolatesWithoutTexture) {
  const Image<float> labels = BestLabels(NoisyPlane(), Image<std::uint8_t>(kWidth, kHeight, 100));
  for (const auto [u, v] : PixelsOf(labels)) {
    if (!HasCosts(u, v) || !IsUniform(u)) continue;
    EXPECT_NEAR(labels(u, v), LabelAt(u, v), 4) << u << " " << v;
  }
}

}  // namespace
}  // namespace surfit::testing
