#include <gmock/gmock.h>

#include <cmath>

#include "io/checks/recording_warnings.h"
#include "surfit/io/sequence.h"
#include "testing/matchers.h"
#include "testing/sequence_writer.h"

namespace surfit::testing {
namespace {

class OpenSequenceTest : public ::testing::Test {
 protected:
  OpenSequenceTest() {
    WriteTumSequence(folder_, 10);
    options_.path = folder_.path();
  }
  std::vector<int> Indices() {
    std::vector<int> indices;
    for (const auto& result : ReadAll(OpenSequence(options_).get())) {
      EXPECT_EQ(result.frame->color(0, 0).r, result.index);
      indices.push_back(result.index);
    }
    EXPECT_EQ(static_cast<int>(indices.size()), OpenSequence(options_)->info().frame_count);
    return indices;
  }
  template <typename... Parts>
  void ExpectError(const Parts&... names) {
    ExpectInputError([&] { OpenSequence(options_); }, Names(names...));
  }

  TempFolder folder_;
  SequenceOptions options_;
};

TEST_F(OpenSequenceTest, FirstLastAndStrideChooseFrames) {
  options_.first = 2;
  options_.last = 5;
  EXPECT_THAT(Indices(), ElementsAre(2, 3, 4, 5));
  options_.stride = 2;
  EXPECT_THAT(Indices(), ElementsAre(2, 4));
  options_.last = -1;
  options_.stride = 3;
  EXPECT_THAT(Indices(), ElementsAre(2, 5, 8));
  options_.last = 1000;
  EXPECT_THAT(Indices(), ElementsAre(2, 5, 8));
  options_.first = options_.last = 9;
  EXPECT_THAT(Indices(), ElementsAre(9));
}

TEST_F(OpenSequenceTest, NamesACompleteRecordingIfNoFrameIsLeft) {
  options_.first = 10;
  ExpectInputError([&] { OpenSequence(options_); },
                   HasSubstr(options_.path + " is complete: it has 10 frames"));
  options_.first = 11;
  ExpectError("first", 11, 10);
}

// z = 31 px * 0.1 m * 1000 counts per px / 1000 counts.
TEST_F(OpenSequenceTest, DisparitiesReachTheFramesAsDepth) {
  std::string yaml = SmallCameraYaml();
  const std::string units = "depth_units_per_metre: 1000.";
  yaml.replace(yaml.find(units), units.size(),
               "disparity: { focal_px: 31., baseline_m: 0.1, counts_per_px: 1000. }");
  folder_.Write("camera.yaml", yaml);
  const auto source = OpenSequence(options_);
  EXPECT_FLOAT_EQ(source->Next()->frame->depth_m(0, 0), 3.1f);
  EXPECT_THAT(source->info().warnings, IsEmpty());
  EXPECT_THAT(source->info().assumed, Names(0.1));
  options_.depth_units_per_metre = 500;
  EXPECT_FLOAT_EQ(OpenSequence(options_)->Next()->frame->depth_m(0, 0), 2.f);
}

TEST_F(OpenSequenceTest, DownsamplingAndDepthLimitReachTheFrames) {
  options_.rectify.downsample = 4;
  options_.rectify.max_depth_m = 1.002;
  const auto source = OpenSequence(options_);
  EXPECT_EQ(source->info().pinhole.width, 8);
  EXPECT_EQ(source->info().pinhole.height, 6);
  EXPECT_EQ(source->info().pinhole.fx, 31 / 4.);
  const RgbdFrame frame = *source->Next()->frame;
  EXPECT_EQ(frame.depth_m.width(), 8);
  EXPECT_EQ(frame.color.height(), 6);
  EXPECT_FLOAT_EQ(frame.depth_m(0, 0), 1.f);  // counts 1000 + i % 7: 1000, 1004, ...
  EXPECT_EQ(frame.depth_m(1, 0), 0);
}

TEST_F(OpenSequenceTest, RejectsBadOptionsByName) {
  const SequenceOptions good = options_;
  const auto expect = [&](const auto& change, const auto&... names) {
    options_ = good;
    change(&options_);
    ExpectError(names...);
  };
  expect([](auto* o) { o->path = ""; }, "path");
  expect([](auto* o) { o->path = "/nowhere"; }, "/nowhere");
  expect([](auto* o) { o->format = "zip"; }, "format", "zip", "auto", "tum", "icl_nuim");
  expect([](auto* o) { o->camera = "kinect9"; }, "camera", "kinect9");
  expect([](auto* o) { o->first = -1; }, "first", -1);
  expect([](auto* o) { o->first = 10; }, "first", 10);
  expect([](auto* o) { o->last = -2; }, "last", -2);
  expect([](auto* o) { o->first = 5, o->last = 4; }, "last", 4, "first", 5);
  expect([](auto* o) { o->stride = 0; }, "stride", 0);
  expect([](auto* o) { o->rectify.downsample = 17; }, "rectify.downsample", 17);
  expect([](auto* o) { o->rectify.max_depth_m = -1; }, "rectify.max_depth_m", -1);
  expect([](auto* o) { o->depth_units_per_metre = 0; }, "depth_units_per_metre", 0);
  expect([](auto* o) { o->inverse_depth_sigma = 0; }, "inverse_depth_sigma", 0);
  expect([](auto* o) { o->inverse_depth_sigma = std::nan(""); }, "inverse_depth_sigma", "nan");
  expect([](auto* o) { o->frames_per_second = -3; }, "frames_per_second", -3);
  expect([](auto* o) { o->latency_s = 20; }, "latency_s", 20);
  expect([](auto* o) { o->intrinsics = {0, 1, 2, 3}; }, "fx", 0);
  expect([](auto* o) { o->color_from_depth = Rigid3d(); }, "color_from_depth", "color_intrinsics");
  expect([](auto* o) { o->color_intrinsics = {30, -30, 15, 11}; }, "fy");
}

TEST_F(OpenSequenceTest, RejectsUnknownFormatAndListsExpectedFiles) {
  TempFolder empty;
  options_.path = empty.path();
  ExpectInputError([&] { OpenSequence(options_); },
                   Names(empty.path(), "depth.txt", "*.gt.freiburg", "frame-*.depth.png"));
}

TEST_F(OpenSequenceTest, IntrinsicsOverridePresetAndPresetOverridesFolder) {
  EXPECT_EQ(OpenSequence(options_)->info().camera.depth.fx, 31);
  options_.camera = "tum_fr1";
  ExpectError(32, 24, 640, 480);
  options_.intrinsics = {29, 28, 15, 11};
  const SequenceInfo info = OpenSequence(options_)->info();
  EXPECT_EQ(info.camera.depth.fx, 29);
  EXPECT_EQ(info.camera.depth.width, 32);              // size of the images
  EXPECT_EQ(info.camera.depth.distortion[0], 0.2624);  // value of the preset
  EXPECT_EQ(info.camera.depth_units_per_metre, 5000);
  options_.camera = "";
  options_.distortion = {0.01, 0, 0, 0, 0};
  options_.depth_units_per_metre = 2000;
  options_.inverse_depth_sigma = 0.0031;
  const auto source = OpenSequence(options_);
  EXPECT_EQ(source->info().sensor().noise.inverse_depth_sigma, 0.0031);
  EXPECT_EQ(source->info().camera.depth.distortion[0], 0.01);
  EXPECT_FLOAT_EQ(source->Next()->frame->depth_m(15, 11), (1000 + (11 * 32 + 15) % 7) / 2000.f);
}

TEST_F(OpenSequenceTest, WarnsIfTheCameraOfTheFolderDiffers) {
  const auto names_own = [&](const auto&... names) {
    return Names(folder_.path() + "/camera.yaml", 31, 30, 15.5, 11.5, 1000, names...);
  };
  const auto warnings = [&] { return OpenSequence(options_)->info().warnings; };
  options_.intrinsics = {31, 30, 15.5, 11.5};
  EXPECT_THAT(warnings(), IsEmpty());
  options_.intrinsics = {29, 28, 15, 11};
  EXPECT_THAT(warnings(), ElementsAre(names_own(29, 28, 15, 11)));
  options_.intrinsics.reset();
  options_.depth_units_per_metre = 500;
  EXPECT_THAT(warnings(), ::testing::Contains(names_own(500)));
  options_.depth_units_per_metre.reset();
  options_.camera = folder_.Write("other.yaml", SmallCameraYaml(33));
  EXPECT_THAT(warnings(), ElementsAre(names_own(33, "other.yaml")));
  folder_.Write("camera.yaml", "no camera at all");
  EXPECT_THAT(warnings(), ElementsAre(Names(folder_.path() + "/camera.yaml")));
}

TEST_F(OpenSequenceTest, WarnsAboutATumFolderWithoutCamera) {
  std::filesystem::remove(folder_ / "camera.yaml");
  for (int i = 0; i < 10; ++i) {
    WriteColor(folder_ / Format("rgb/%03d.png", i), NumberedColor(i, 640, 480));
    WriteDepth(folder_ / Format("depth/%03d.png", i), Image<std::uint16_t>(640, 480, 9000));
  }
  const SequenceInfo info = OpenSequence(options_)->info();
  EXPECT_EQ(info.camera.depth.fx, 525);
  EXPECT_EQ(info.camera.depth_units_per_metre, 5000);
  EXPECT_THAT(info.warnings, ElementsAre(Names(525, 319.5, 239.5)));
  options_.intrinsics = {500, 500, 320, 240};
  EXPECT_TRUE(OpenSequence(options_)->info().warnings.empty());
}

TEST_F(OpenSequenceTest, DescribesFormatSizesAndCamera) {
  EXPECT_THAT(OpenSequence(options_)->info().assumed,
              Names("tum", 10, 32, 24, 31, 30, 15.5, 11.5, 1000, folder_.path() + "/camera.yaml"));
  options_.color_intrinsics = {31, 30, 15.5, 11.5};
  options_.depth_units_per_metre = 1100;
  EXPECT_THAT(OpenSequence(options_)->info().assumed,
              Names(32, 24, 1100, folder_.path() + "/camera.yaml"));
}

TEST_F(OpenSequenceTest, RegistersASeparateColorCamera) {
  for (int i = 0; i < 10; ++i)
    WriteColor(folder_ / Format("rgb/%03d.png", i), NumberedColor(i, 64, 48));
  ExpectError("rgb/000.png", 64, 48, 32, 24);
  ExpectError("color_camera", "color_from_depth", "camera.yaml", "color_intrinsics");
  options_.color_intrinsics = {62, 60, 31, 23};
  options_.color_from_depth = Rigid3d(Eigen::Quaterniond::Identity(), {0.5, 0, 0});
  const auto source = OpenSequence(options_);
  EXPECT_FALSE(source->info().camera.color_is_registered);
  EXPECT_EQ(source->info().camera.color.width, 64);
  const RgbdFrame frame = *source->Next()->frame;
  EXPECT_EQ(frame.color(0, 12), (Rgb8{0, 20, 30}));
  // The parallax at 1 m is 62 * 0.5 = 31 px, so depth pixels with u > 16 are outside the colour
  // image.
  EXPECT_EQ(frame.color(20, 12), Rgb8());
}

TEST_F(OpenSequenceTest, SkipsUnreadableFramesAndNamesThem) {
  const std::string whole = ReadBytes(folder_ / "depth/003.png");
  WriteBytes(folder_ / "depth/003.png", whole.substr(0, whole.size() / 2));
  std::filesystem::remove(folder_ / "rgb/005.png");
  WriteDepth(folder_ / "depth/007.png", NumberedDepth(7, 16, 12));
  WriteColor(folder_ / "rgb/008.png", NumberedColor(8, 16, 12));
  const auto results = ReadAll(OpenSequence(options_).get());
  ASSERT_EQ(results.size(), 10u);
  const auto expect_error = [&](int i, const auto&... names) {
    EXPECT_FALSE(results[i].frame);
    EXPECT_THAT(results[i].error, Names(names...));
    EXPECT_EQ(results[i].index, i);
    EXPECT_DOUBLE_EQ(results[i].stamp_s, 5.003 + 0.1 * i);
  };
  expect_error(3, "depth/003.png");
  expect_error(5, "rgb/005.png");
  expect_error(7, "depth/007.png", 16, 12, 32, 24);
  expect_error(8, "rgb/008.png", 16, 12, 32, 24);
  for (const int i : {0, 1, 2, 4, 6, 9}) EXPECT_TRUE(results[i].frame) << results[i].error;
}

TEST_F(OpenSequenceTest, SkipsAnUnreadableFirstFrame) {
  WriteBytes(folder_ / "depth/000.png", "");
  const auto results = ReadAll(OpenSequence(options_).get());
  EXPECT_THAT(results[0].error, Names("depth/000.png"));
  EXPECT_TRUE(results[1].frame);
}

TEST_F(OpenSequenceTest, RejectsSequenceWithoutReadableFrames) {
  std::filesystem::remove_all(folder_ / "depth");
  ExpectError("depth/000.png");
}

TEST_F(OpenSequenceTest, WarnsAboutAnImplausibleDepthScale) {
  EXPECT_TRUE(OpenSequence(options_)->info().warnings.empty());
  options_.depth_units_per_metre = 10000;
  EXPECT_THAT(OpenSequence(options_)->info().warnings,
              ::testing::Contains(Names("depth/000.png", 0.1003, 10000, 1000)));
}

// Warning for an image with mostly depth `count`, and some invalid codes.
std::string Warning(std::uint16_t count, double scale) {
  Image<std::uint16_t> depth(10, 10, count);
  for (int v = 0; v < 10; ++v) depth(0, v) = depth(1, v) = v < 5 ? 0 : 65535;
  depth(2, 0) = 1;
  return DepthScaleWarning(depth, scale, "d.png").value_or("");
}

TEST(DepthScaleWarning, IsEmptyForPlausibleDepth) {
  EXPECT_EQ(Warning(1800, 1000), "");
  EXPECT_EQ(Warning(700, 1000), "");
  EXPECT_EQ(Warning(15000, 5000), "");
  EXPECT_EQ(Warning(13000, 6553.5), "");
}

TEST(DepthScaleWarning, NamesDepthAndLikelyScale) {
  EXPECT_THAT(Warning(1800, 5000), Names("d.png", 0.36, 5000, 1000, 1.8));
  EXPECT_THAT(Warning(18000, 1), Names(18000, 1));
}

TEST(DepthScaleWarning, SuggestsTheScaleOfTumUpToFiveMetres) {
  for (const double depth_m : {1.2, 2.2, 3.5, 4.9}) {
    const auto count = static_cast<std::uint16_t>(5000 * depth_m);
    EXPECT_THAT(Warning(count, 1000), Names(5000)) << depth_m;
  }
  // 6.4 m with the scale of TUM, 4.9 m with Replica, 3.2 m with units of 0.1 mm
  EXPECT_THAT(Warning(32000, 1000), Names(10000));
}

// Depth of 1 to 5 m, scaled by 1/5. The median depth is plausible, but the minimum depth is not.
TEST(DepthScaleWarning, SuggestsAScaleIfAllDepthsAreBelowTheSensorRange) {
  const auto warning = [](double scale) {
    Image<std::uint16_t> depth(100, 10);
    for (int v = 0; v < 10; ++v) {
      for (int u = 0; u < 100; ++u) depth(u, v) = static_cast<std::uint16_t>(1000 + 40 * u);
    }
    return DepthScaleWarning(depth, scale, "d.png").value_or("");
  };
  EXPECT_EQ(warning(1000), "");
  EXPECT_THAT(warning(5000), Names(1000));
}

TEST(DepthScaleWarning, IsEmptyIfNoScaleFitsBetterUnlessImplausible) {
  EXPECT_EQ(Warning(350, 1000), "");  // close-up of a desk
  EXPECT_NE(Warning(150, 1000), "");
}

TEST(DepthScaleWarning, IsEmptyForFloatDepth) {
  EXPECT_FALSE(DepthScaleWarning(Image<float>(4, 4, 1000.f), 5000, "d.tiff"));
  EXPECT_FALSE(DepthScaleWarning(Image<std::uint16_t>(4, 4, 0), 5000, "d.png"));
}

}  // namespace
}  // namespace surfit::testing
