#include "io/depth/depth_encoding.h"

#include "io/checks/recording_warnings.h"
#include "io/slanted_depth.h"
#include "testing/matchers.h"

namespace surfit::testing {
namespace {

constexpr int kFar = 2500;  // mm

std::vector<FrameImages> FirstImages(const std::function<RawDepth(int)>& depth_of) {
  std::vector<FrameImages> images;
  for (int i = 0; i < 4; ++i) images.push_back({depth_of(i), {}, "depth.png", ""});
  return images;
}

RgbdCamera CameraOf(double units_per_metre) {
  RgbdCamera camera;
  camera.depth_units_per_metre = units_per_metre;
  return camera;
}

// Detects the encoding of the images, decodes the first image and returns it.
Image<std::uint16_t> Decoded(const std::vector<FrameImages>& images, double units_per_metre,
                             std::vector<std::string>* warnings) {
  const DepthEncoding encoding = DetectDepthEncoding(images, CameraOf(units_per_metre), warnings);
  RawDepth depth = images[0].depth;
  DecodeDepth(encoding, &depth);
  return std::get<Image<std::uint16_t>>(depth);
}

TEST(DepthEncoding, IsPlainForCountsAndFloats) {
  std::vector<std::string> warnings;
  const auto counts = FirstImages([](int i) { return SlantedDepth(i); });
  for (const double units : {1000., 5000., 6553.5})
    EXPECT_TRUE(DetectDepthEncoding(counts, CameraOf(units), &warnings).IsPlain());
  const auto floats = FirstImages([](int i) {
    Image<float> metres(kSlantedWidth, kSlantedHeight);
    for (std::size_t k = 0; k < metres.size(); ++k) metres[k] = 0.001f * SlantedDepth(i)[k];
    return metres;
  });
  EXPECT_TRUE(DetectDepthEncoding(floats, CameraOf(5000), &warnings).IsPlain());
  EXPECT_THAT(warnings, ::testing::IsEmpty());
}

TEST(DepthEncoding, CorrectsSwappedBytes) {
  const auto images = FirstImages([](int i) {
    return Changed(SlantedDepth(i), [](int count) { return count << 8 | count >> 8; });
  });
  std::vector<std::string> warnings;
  EXPECT_EQ(Decoded(images, 1000, &warnings), SlantedDepth(0));
  EXPECT_THAT(warnings, ElementsAre(Names("depth.png", "bytes")));
}

// Depth in steps of `step` counts, with equal values in columns of 10 px.
Image<std::uint16_t> Stairs(int frame, int step) {
  Image<std::uint16_t> depth(kSlantedWidth, kSlantedHeight);
  for (int v = 0; v < kSlantedHeight; ++v) {
    for (int u = 0; u < kSlantedWidth; ++u)
      depth(u, v) = static_cast<std::uint16_t>(12000 + 3 * frame + step * (u / 10 + v % 7));
  }
  return depth;
}

TEST(DepthEncoding, CorrectsSwappedBytesOfWallsAndCoarseSteps) {
  for (const int step : {1, 20, 100}) {
    const auto images = FirstImages([&](int i) {
      return Changed(Stairs(i, step), [](int count) { return count << 8 | count >> 8; });
    });
    std::vector<std::string> warnings;
    EXPECT_EQ(Decoded(images, 5000, &warnings), Stairs(0, step)) << step;
    EXPECT_THAT(warnings, ElementsAre(Names("depth.png", "bytes")));
    warnings.clear();
    EXPECT_TRUE(DetectDepthEncoding(FirstImages([&](int i) { return Stairs(i, step); }),
                                    CameraOf(5000), &warnings)
                    .IsPlain());
  }
}

TEST(DepthEncoding, KeepsImagesOfEightBitsInTheHighByte) {
  const auto images = FirstImages(
      [](int i) { return Changed(SlantedDepth(i), [](int count) { return (count >> 4) << 8; }); });
  std::vector<std::string> warnings;
  EXPECT_TRUE(DetectDepthEncoding(images, CameraOf(16000), &warnings).IsPlain());
}

TEST(DepthEncoding, CorrectsRotatedBits) {
  const auto images = FirstImages([](int i) {
    return Changed(SlantedDepth(i), [](int count) { return count << 3 | count >> 13; });
  });
  std::vector<std::string> warnings;
  EXPECT_EQ(Decoded(images, 1000, &warnings), SlantedDepth(0));
  EXPECT_THAT(warnings, ElementsAre(Names("depth.png", "rotated", 3)));
  // With this scale, the counts are plausible.
  warnings.clear();
  EXPECT_TRUE(DetectDepthEncoding(images, CameraOf(8000), &warnings).IsPlain());
}

TEST(DepthEncoding, ConvertsFloatsInMillimetres) {
  const auto images = FirstImages([](int i) {
    Image<float> depth(kSlantedWidth, kSlantedHeight);
    for (std::size_t k = 0; k < depth.size(); ++k) depth[k] = SlantedDepth(i)[k];
    return depth;
  });
  std::vector<std::string> warnings;
  RawDepth depth = images[0].depth;
  DecodeDepth(DetectDepthEncoding(images, CameraOf(1000), &warnings), &depth);
  EXPECT_FLOAT_EQ(std::get<Image<float>>(depth)[0], 1.5f);
  EXPECT_THAT(warnings, ElementsAre(Names("depth.png", "mm")));
}

TEST(DepthEncoding, ReadsAFarPlaneAsMissing) {
  const auto images = FirstImages([](int i) {
    return Changed(SlantedDepth(i), [](int count) { return std::min(count, kFar); });
  });
  std::vector<std::string> warnings;
  const Image<std::uint16_t> decoded = Decoded(images, 1000, &warnings);
  const Image<std::uint16_t> true_depth = SlantedDepth(0);
  for (std::size_t k = 0; k < decoded.size(); ++k)
    ASSERT_EQ(decoded[k], true_depth[k] < kFar ? true_depth[k] : 0) << k;
  EXPECT_THAT(warnings, ElementsAre(Names("depth.png", 2500, 2.5)));
}

// The camera sees the far plane in half of the images.
TEST(DepthEncoding, ReadsAFarPlaneInTwoImagesAsMissing) {
  constexpr int kFirst = 2;
  const auto depth_of = [](int i) {
    return Changed(SlantedDepth(20 * i), [i](int count) {
      return i < kFirst ? std::min(count, kFar - 1 - count % 100) : std::min(count, kFar);
    });
  };
  const auto images = FirstImages(depth_of);
  std::vector<std::string> warnings;
  const DepthEncoding encoding = DetectDepthEncoding(images, CameraOf(1000), &warnings);
  EXPECT_EQ(encoding.fill_value.value_or(0), kFar);
  EXPECT_THAT(warnings, ElementsAre(Names("depth.png", 2500, 2.5, "%")));
}

// The camera faces a wall in one image only.
TEST(DepthEncoding, KeepsAFrequentValueOfOneImage) {
  const auto images = FirstImages([](int i) {
    return Changed(SlantedDepth(i), [i](int count) {
      return i == 2 ? std::min(count, kFar) : std::min(count, kFar - 1 - count % 100);
    });
  });
  std::vector<std::string> warnings;
  EXPECT_TRUE(DetectDepthEncoding(images, CameraOf(1000), &warnings).IsPlain());
}

// A static camera cannot show whether a value is a surface.
TEST(DepthEncoding, KeepsAFrequentValueOfAStaticCamera) {
  const auto images = FirstImages([](int) {
    return Changed(SlantedDepth(0), [](int count) { return std::min(count, 2500); });
  });
  std::vector<std::string> warnings;
  EXPECT_TRUE(DetectDepthEncoding(images, CameraOf(1000), &warnings).IsPlain());
}

TEST(FarDepthWarning, NamesTheRatioBeyondTheLimit) {
  const auto images = FirstImages(
      [](int i) { return Changed(SlantedDepth(i), [](int count) { return 5 * count; }); });
  EXPECT_FALSE(FarDepthWarning(images, CameraOf(5000), 8));
  EXPECT_THAT(FarDepthWarning(images, CameraOf(1000), 8).value_or(""), Names("max_depth_m", 8));
}

TEST(DepthScaleWarning, DoesNotClaimAnotherScaleIfTheScaleIsGiven) {
  const Image<std::uint16_t> depth(10, 10, 1800);
  EXPECT_THAT(DepthScaleWarning(depth, 10000, "d.png", true).value_or(""),
              ::testing::AllOf(Names("d.png", 0.18, 10000, 1000, 1.8),
                               ::testing::Not(::testing::HasSubstr("likely"))));
}

}  // namespace
}  // namespace surfit::testing
