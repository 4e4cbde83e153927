#include <gmock/gmock.h>

#include <random>

#include "io/sequences/recording_warnings.h"
#include "testing/matchers.h"

namespace surfit::testing {
namespace {

const PinholeCamera kCamera = {640, 480, 500, 500, 320, 240, {}};

// Boards with random positions, depths and colours. The colour image is scaled by `scale` about the
// image centre and shifted by `right` pixels.
FrameImages Boards(double scale, int right, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto below = [&](int limit) { return static_cast<int>(random() % limit); };
  FrameImages images;
  Image<std::uint16_t> depth(640, 480, 4000);
  images.color = Image<Rgb8>(640, 480, {90, 90, 90});
  for (int board = 0; board < 12; ++board) {
    const int left = below(560), top = below(400), width = 40 + below(80), height = 40 + below(80);
    const auto z = static_cast<std::uint16_t>(800 + below(2500));
    const Rgb8 color = {static_cast<std::uint8_t>(below(256)),
                        static_cast<std::uint8_t>(below(256)),
                        static_cast<std::uint8_t>(below(256))};
    const auto inside = [&](double u, double v) {
      return u >= left && u < left + width && v >= top && v < top + height;
    };
    for (int v = 0; v < 480; ++v) {
      for (int u = 0; u < 640; ++u) {
        if (inside(u, v)) depth(u, v) = z;
        if (inside((u - right - 320) / scale + 320, (v - 240) / scale + 240)) {
          images.color(u, v) = color;
        }
      }
    }
  }
  images.depth = depth;
  return images;
}

std::string ViolatedCriterion(double scale, int right) {
  std::vector<FrameImages> frames;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) frames.push_back(Boards(scale, right, seed));
  return RegistrationWarning(frames, kCamera).value_or("");
}

TEST(RegistrationWarning, IsEmptyForRegisteredColor) {
  EXPECT_EQ(ViolatedCriterion(1, 0), "");
  EXPECT_EQ(ViolatedCriterion(1, 3), "");  // below the resolution of the cells
}

TEST(RegistrationWarning, NamesScaleAndShiftOfColor) {
  EXPECT_THAT(ViolatedCriterion(1, 20), Names(100, 20));
  EXPECT_THAT(ViolatedCriterion(0.89, 0), Names(89, 0, "445,445,320,240", "color_camera"));
  EXPECT_THAT(ViolatedCriterion(1.12, -12), Names(112, -12));
}

TEST(RegistrationWarning, IsEmptyWithoutColorOrEdges) {
  std::vector<FrameImages> frames = {Boards(1, 20, 1)};
  frames[0].color = {};
  EXPECT_FALSE(RegistrationWarning(frames, kCamera));
  frames[0].color = Image<Rgb8>(640, 480, {1, 2, 3});
  EXPECT_FALSE(RegistrationWarning(frames, kCamera));
  frames = {Boards(1, 20, 1)};
  frames[0].depth = Image<std::uint16_t>(640, 480, 1000);
  EXPECT_FALSE(RegistrationWarning(frames, kCamera));
  EXPECT_FALSE(RegistrationWarning({}, kCamera));
}

}  // namespace
}  // namespace surfit::testing
