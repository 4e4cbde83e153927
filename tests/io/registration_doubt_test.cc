#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "io/checks/recording_warnings.h"
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

// The shift is beyond the reach of fine cells.
TEST(RegistrationWarning, NamesLargeShiftOfColor) {
  EXPECT_THAT(ViolatedCriterion(1, 80), Names(100, 80));
  EXPECT_THAT(ViolatedCriterion(1, -64), Names(100, -64));
}

TEST(RegistrationWarning, NamesRotationOfColor) {
  std::vector<FrameImages> frames;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    frames.push_back(Boards(1, 0, seed));
    std::reverse(frames.back().color.begin(), frames.back().color.end());
  }
  EXPECT_THAT(RegistrationWarning(frames, kCamera).value_or(""), Names("rotated", 180));
}

RgbdCamera WithColorCamera(const Eigen::Vector3d& translation_m) {
  RgbdCamera camera;
  camera.depth = camera.color = kCamera;
  camera.depth_units_per_metre = 1000;
  camera.color_is_registered = false;
  camera.color_from_depth.translation = translation_m;
  return camera;
}

// Colour of a camera that is 60 mm to the right: points are 60 mm farther left in its view.
FrameImages BoardsOfTwoCameras(std::uint64_t seed) {
  FrameImages images = Boards(1, 0, seed);
  const auto& depth = std::get<Image<std::uint16_t>>(images.depth);
  const Image<Rgb8> registered = images.color;
  Image<std::uint16_t> nearest(640, 480, 65535);
  for (int v = 0; v < 480; ++v) {
    for (int u = 0; u < 640; ++u) {
      const int to = static_cast<int>(std::lround(u - 500 * 60. / depth(u, v)));
      if (to < 0 || depth(u, v) > nearest(to, v)) continue;
      nearest(to, v) = depth(u, v);
      images.color(to, v) = registered(u, v);
    }
  }
  return images;
}

std::string WarningOf(const Eigen::Vector3d& translation_m) {
  std::vector<FrameImages> frames;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) frames.push_back(BoardsOfTwoCameras(seed));
  std::optional<RegistrationFit> fit;
  return ColorCameraWarning(frames, WithColorCamera(translation_m), {}, &fit).value_or("");
}

TEST(ColorCameraWarning, IsEmptyForTheTruePlace) { EXPECT_EQ(WarningOf({-0.06, 0, 0}), ""); }

TEST(ColorCameraWarning, NamesTheInverse) {
  EXPECT_THAT(WarningOf({0.06, 0, 0}), Names("inverse", "color_from_depth"));
}

TEST(ColorCameraWarning, NamesMillimetres) {
  EXPECT_THAT(WarningOf({-60, 0, 0}), Names("mm", 60, "color_from_depth"));
}

TEST(ColorCameraWarning, NamesDepthThatTheCameraDoesNotSee) {
  RgbdCamera turned = WithColorCamera({-0.06, 0, 0});
  turned.color_from_depth.rotation = Eigen::Quaterniond(0, 0, 1, 0);  // it looks backwards
  std::optional<RegistrationFit> fit;
  EXPECT_THAT(ColorCameraWarning({BoardsOfTwoCameras(1)}, turned, {}, &fit).value_or(""),
              Names("sees", 0, "color_from_depth"));
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
  EXPECT_FALSE(RegistrationWarning(std::vector<FrameImages>(), kCamera));
}

}  // namespace
}  // namespace surfit::testing
