#include <gmock/gmock.h>

#include <cmath>

#include "io/sequences/depth_scale.h"
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
  void ExpectError(const std::string& message) {
    ExpectInputError([&] { OpenSequence(options_); }, HasSubstr(message));
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

// z = 31 px * 0.1 m * 1000 counts a px / 1000 counts.
TEST_F(OpenSequenceTest, DisparitiesReachTheFramesAsDepth) {
  std::string yaml = SmallCameraYaml();
  const std::string units = "depth_units_per_metre: 1000.";
  yaml.replace(yaml.find(units), units.size(),
               "disparity: { focal_px: 31., baseline_m: 0.1, counts_per_px: 1000. }");
  folder_.Write("camera.yaml", yaml);
  const auto source = OpenSequence(options_);
  EXPECT_FLOAT_EQ(source->Next()->frame->depth_m(0, 0), 3.1f);
  EXPECT_THAT(source->info().warnings, IsEmpty());
  EXPECT_THAT(source->info().assumed, HasSubstr("a baseline of 0.1 m"));
  options_.depth_units_per_metre = 500;
  EXPECT_FLOAT_EQ(OpenSequence(options_)->Next()->frame->depth_m(0, 0), 2.f);
}

TEST_F(OpenSequenceTest, DownsamplingAndDepthLimitReachTheFrames) {
  options_.prepare.downsample = 4;
  options_.prepare.max_depth_m = 1.002;
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

TEST_F(OpenSequenceTest, RefusesBadOptionsByName) {
  const SequenceOptions good = options_;
  const auto expect = [&](const auto& change, const std::string& message) {
    options_ = good;
    change(&options_);
    ExpectError(message);
  };
  expect([](auto* o) { o->path = ""; }, "path is missing, must be set");
  expect([](auto* o) { o->path = "/nowhere"; }, "/nowhere is neither a folder nor a file");
  expect([](auto* o) { o->format = "zip"; },
         "format is 'zip', must be one of: auto, tum, icl_nuim");
  expect([](auto* o) { o->camera = "kinect9"; }, "camera is 'kinect9'");
  expect([](auto* o) { o->first = -1; }, "first is -1");
  expect([](auto* o) { o->first = 10; }, "first is 10, must be below 10");
  expect([](auto* o) { o->last = -2; }, "last is -2");
  expect([](auto* o) { o->first = 5, o->last = 4; }, "last is 4, must be at least first, 5");
  expect([](auto* o) { o->stride = 0; }, "stride is 0");
  expect([](auto* o) { o->prepare.downsample = 17; }, "downsample is 17");
  expect([](auto* o) { o->prepare.max_depth_m = -1; }, "max_depth_m is -1");
  expect([](auto* o) { o->depth_units_per_metre = 0; }, "depth_units_per_metre is 0");
  expect([](auto* o) { o->inverse_depth_sigma = 0; },
         "inverse_depth_sigma is 0, must be positive and below 1 (1/m)");
  expect([](auto* o) { o->inverse_depth_sigma = std::nan(""); }, "inverse_depth_sigma is nan");
  expect([](auto* o) { o->frames_per_second = -3; }, "frames_per_second is -3");
  expect([](auto* o) { o->latency_s = 20; }, "latency_s is 20, must be from -1 to 1 (s)");
  expect([](auto* o) { o->intrinsics = {0, 1, 2, 3}; }, "fx is 0");
  expect([](auto* o) { o->color_from_depth = Rigid3d(); }, "give color_intrinsics too");
  expect([](auto* o) { o->color_intrinsics = {30, -30, 15, 11}; }, "must have one sign");
}

TEST_F(OpenSequenceTest, AFolderOfNoKnownFormatSaysWhatWasLookedFor) {
  TempFolder empty;
  options_.path = empty.path();
  ExpectInputError([&] { OpenSequence(options_); },
                   AllOf(HasSubstr(empty.path()), HasSubstr("depth.txt"),
                         HasSubstr("*.gt.freiburg"), HasSubstr("frame-*.depth.png")));
}

TEST_F(OpenSequenceTest, ThePresetBeatsTheFolderAndFiguresBeatBoth) {
  EXPECT_EQ(OpenSequence(options_)->info().camera.depth.fx, 31);
  options_.camera = "tum_fr1";
  ExpectError("is 32 x 24 pixels, must be 640 x 480 as the depth camera");
  options_.intrinsics = {29, 28, 15, 11};
  const SequenceInfo info = OpenSequence(options_)->info();
  EXPECT_EQ(info.camera.depth.fx, 29);
  EXPECT_EQ(info.camera.depth.width, 32);              // the images'
  EXPECT_EQ(info.camera.depth.distortion[0], 0.2624);  // still the preset's
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

TEST_F(OpenSequenceTest, TellsWhereTheFolderSaysOtherwise) {
  const std::string own = folder_.path() + "/camera.yaml says 31 30 15.5 11.5 px, 1000 units";
  const auto warnings = [&] { return OpenSequence(options_)->info().warnings; };
  options_.intrinsics = {31, 30, 15.5, 11.5};
  EXPECT_THAT(warnings(), IsEmpty());
  options_.intrinsics = {29, 28, 15, 11};
  EXPECT_THAT(warnings(),
              ElementsAre(AllOf(HasSubstr("the depth camera is 29 28 15 11 px"), HasSubstr(own))));
  options_.intrinsics.reset();
  options_.depth_units_per_metre = 500;
  EXPECT_THAT(warnings(), Contains(AllOf(HasSubstr("500 units"), HasSubstr(own))));
  options_.depth_units_per_metre.reset();
  options_.camera = folder_.Write("other.yaml", SmallCameraYaml(33));
  EXPECT_THAT(warnings(), ElementsAre(AllOf(HasSubstr("33 15.5 11.5 px"),
                                            HasSubstr("other.yaml says"), HasSubstr(own))));
  folder_.Write("camera.yaml", "no camera at all");
  EXPECT_THAT(warnings(), ElementsAre(HasSubstr("camera.yaml says")));
}

TEST_F(OpenSequenceTest, WithoutAnyCameraATumFolderIsReadWithAWarning) {
  std::filesystem::remove(folder_ / "camera.yaml");
  for (int i = 0; i < 10; ++i) {
    WriteColor(folder_ / Format("rgb/%03d.png", i), NumberedColor(i, 640, 480));
    WriteDepth(folder_ / Format("depth/%03d.png", i), Image<std::uint16_t>(640, 480, 9000));
  }
  const SequenceInfo info = OpenSequence(options_)->info();
  EXPECT_EQ(info.camera.depth.fx, 525);
  EXPECT_EQ(info.camera.depth_units_per_metre, 5000);
  EXPECT_THAT(info.warnings, ElementsAre(HasSubstr("525 525 319.5 239.5")));
  options_.intrinsics = {500, 500, 320, 240};
  EXPECT_TRUE(OpenSequence(options_)->info().warnings.empty());
}

TEST_F(OpenSequenceTest, TellsInTwoLinesWhatIsTakenForGranted) {
  EXPECT_EQ(OpenSequence(options_)->info().assumed,
            "format tum, 10 frames, depth 32 x 24, colour registered to depth\n"
            "depth camera 31 30 15.5 11.5 px, 1000 units of depth a metre: " +
                folder_.path() + "/camera.yaml");
  options_.color_intrinsics = {31, 30, 15.5, 11.5};
  options_.depth_units_per_metre = 1100;
  EXPECT_THAT(OpenSequence(options_)->info().assumed,
              AllOf(HasSubstr("colour of its own camera, 32 x 24\n"), HasSubstr("1100 units"),
                    HasSubstr("camera.yaml, the depth scale as given")));
}

TEST_F(OpenSequenceTest, AColorCameraOfItsOwnIsRegistered) {
  for (int i = 0; i < 10; ++i)
    WriteColor(folder_ / Format("rgb/%03d.png", i), NumberedColor(i, 64, 48));
  ExpectError("rgb/000.png is 64 x 48 pixels, must be 32 x 24 as depth, to which colour");
  ExpectError("color_camera and color_from_depth in a camera.yaml, or color_intrinsics");
  options_.color_intrinsics = {62, 60, 31, 23};
  options_.color_from_depth = Rigid3d(Eigen::Quaterniond::Identity(), {0.5, 0, 0});
  const auto source = OpenSequence(options_);
  EXPECT_FALSE(source->info().camera.color_is_registered);
  EXPECT_EQ(source->info().camera.color.width, 64);
  const RgbdFrame frame = *source->Next()->frame;
  EXPECT_EQ(frame.color(0, 12), (Rgb8{0, 20, 30}));
  // At 1 m the colour camera sees a point 62 * 0.5 = 31 px further right: u > 16 is outside.
  EXPECT_EQ(frame.color(20, 12), Rgb8());
}

TEST_F(OpenSequenceTest, UnreadableFramesAreNamedAndReadingGoesOn) {
  const std::string whole = ReadBytes(folder_ / "depth/003.png");
  WriteBytes(folder_ / "depth/003.png", whole.substr(0, whole.size() / 2));
  std::filesystem::remove(folder_ / "rgb/005.png");
  WriteDepth(folder_ / "depth/007.png", NumberedDepth(7, 16, 12));
  WriteColor(folder_ / "rgb/008.png", NumberedColor(8, 16, 12));
  const auto results = ReadAll(OpenSequence(options_).get());
  ASSERT_EQ(results.size(), 10u);
  const auto expect_error = [&](int i, const std::string& message) {
    EXPECT_FALSE(results[i].frame);
    EXPECT_THAT(results[i].error, HasSubstr(message));
    EXPECT_EQ(results[i].index, i);
    EXPECT_DOUBLE_EQ(results[i].stamp_s, 5.003 + 0.1 * i);
  };
  expect_error(3, "depth/003.png is truncated");
  expect_error(5, "rgb/005.png");
  expect_error(7, "depth/007.png is 16 x 12 pixels, must be 32 x 24 as the depth camera");
  expect_error(8, "rgb/008.png is 16 x 12 pixels, must be 32 x 24");
  for (const int i : {0, 1, 2, 4, 6, 9}) EXPECT_TRUE(results[i].frame) << results[i].error;
}

TEST_F(OpenSequenceTest, AnUnreadableFirstFrameIsSkippedToo) {
  WriteBytes(folder_ / "depth/000.png", "");
  const auto results = ReadAll(OpenSequence(options_).get());
  EXPECT_THAT(results[0].error, HasSubstr("depth/000.png"));
  EXPECT_TRUE(results[1].frame);
}

TEST_F(OpenSequenceTest, WithoutAnyReadableFrameTheFirstFileIsNamed) {
  std::filesystem::remove_all(folder_ / "depth");
  ExpectError("no frame can be read");
  ExpectError("depth/000.png");
}

TEST_F(OpenSequenceTest, AnAbsurdDepthScaleIsWarnedAbout) {
  EXPECT_TRUE(OpenSequence(options_)->info().warnings.empty());
  options_.depth_units_per_metre = 10000;
  EXPECT_THAT(OpenSequence(options_)->info().warnings,
              Contains(AllOf(HasSubstr("depth/000.png"), HasSubstr("0.1003 m at 10000 units"),
                             HasSubstr("more likely 1000"))));
}

// The warning about an image whose valid depth is mostly `count`, beside invalid codes.
std::string Warning(std::uint16_t count, double scale) {
  Image<std::uint16_t> depth(10, 10, count);
  for (int v = 0; v < 10; ++v) depth(0, v) = depth(1, v) = v < 5 ? 0 : 65535;
  depth(2, 0) = 1;
  return DepthScaleWarning(depth, scale, "d.png").value_or("");
}

TEST(DepthScaleWarning, IsSilentAboutUsualDepth) {
  EXPECT_EQ(Warning(1800, 1000), "");
  EXPECT_EQ(Warning(700, 1000), "");
  EXPECT_EQ(Warning(15000, 5000), "");
  EXPECT_EQ(Warning(13000, 6553.5), "");
}

TEST(DepthScaleWarning, TellsValueAndLikelyScale) {
  EXPECT_THAT(Warning(1800, 5000), HasSubstr("d.png is 0.36 m at 5000 units per metre; the scale "
                                             "is more likely 1000, which makes it 1.8 m"));
  EXPECT_THAT(Warning(18000, 1), HasSubstr("18000 m at 1 units per metre"));
}

TEST(DepthScaleWarning, TakesTumsDepthForTumsUpToFiveMetres) {
  for (const double depth_m : {1.2, 2.2, 3.5, 4.9}) {
    const auto count = static_cast<std::uint16_t>(5000 * depth_m);
    EXPECT_THAT(Warning(count, 1000), HasSubstr("more likely 5000, ")) << depth_m;
  }
  // 6.4 m at TUM's scale, 4.9 m at Replica's, 3.2 m in tenths of millimetres
  EXPECT_THAT(Warning(32000, 1000), HasSubstr("more likely 10000, "));
}

// A room of 1 to 5 m at a fifth of its size: the median may be a table's, the nearest may not.
TEST(DepthScaleWarning, DoubtsThatAllIsNearerThanSensorsMeasure) {
  const auto warning = [](double scale) {
    Image<std::uint16_t> depth(100, 10);
    for (int v = 0; v < 10; ++v) {
      for (int u = 0; u < 100; ++u) depth(u, v) = static_cast<std::uint16_t>(1000 + 40 * u);
    }
    return DepthScaleWarning(depth, scale, "d.png").value_or("");
  };
  EXPECT_EQ(warning(1000), "");
  EXPECT_THAT(warning(5000), HasSubstr("more likely 1000"));
}

TEST(DepthScaleWarning, IsSilentWhereNoScaleFitsBetterUnlessAbsurd) {
  EXPECT_EQ(Warning(350, 1000), "");  // a desk close by
  EXPECT_NE(Warning(150, 1000), "");
}

TEST(DepthScaleWarning, NeedsCounts) {
  EXPECT_FALSE(DepthScaleWarning(Image<float>(4, 4, 1000.f), 5000, "d.tiff"));
  EXPECT_FALSE(DepthScaleWarning(Image<std::uint16_t>(4, 4, 0), 5000, "d.png"));
}

}  // namespace
}  // namespace surfit::testing
