#include "testing/recordings.h"

#include <limits>

#include "io/sequences/klg_writer.h"
#include "surfit/io/sequence.h"
#include "testing/matchers.h"
#include "testing/sequence_writer.h"

namespace surfit::testing {
namespace {

// Expects three frames of NumberedDepth(), and NumberedColor() unless `color_coding` is "none".
void ExpectNumberedFrames(const std::vector<ReadResult>& results, const std::string& color_coding) {
  ASSERT_EQ(results.size(), 3u);
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(results[i].frame) << results[i].error;
    EXPECT_DOUBLE_EQ(results[i].stamp_s, 5 + 0.1 * i);
    const auto raw = NumberedDepth(i);
    for (std::size_t k = 0; k < raw.size(); ++k)
      ASSERT_FLOAT_EQ(results[i].frame->depth_m[k], raw[k] * 0.001f);
    const Image<Rgb8>& read = results[i].frame->color;
    if (color_coding == "none") {
      EXPECT_TRUE(read.empty());
    } else if (color_coding == ".jpg") {
      EXPECT_NEAR(read(16, 12).g, 20, 2);
    } else {
      EXPECT_EQ(read, NumberedColor(i));
    }
  }
}

class KlgTest : public ::testing::Test {
 protected:
  KlgTest() { folder_.Write("a.klg.yaml", SmallCameraYaml()); }
  std::unique_ptr<FrameSource> Open(const std::string& bytes) {
    options_.path = folder_.Write("a.klg", bytes);
    return OpenSequence(options_);
  }
  TempFolder folder_;
  SequenceOptions options_;
};

TEST_F(KlgTest, ReadsEveryCodingOfTheSameFrames) {
  for (const bool zlib : {false, true}) {
    for (const std::string color : {"", ".jpg", "none"}) {
      const auto source = Open(KlgFile(3, zlib, color));
      EXPECT_EQ(source->info().format, "klg");
      EXPECT_TRUE(source->info().warnings.empty());
      const auto results = ReadAll(source.get());
      ASSERT_NO_FATAL_FAILURE(ExpectNumberedFrames(results, color));
    }
  }
}

TEST_F(KlgTest, RejectsUnknownImageSizeWithoutCamera) {
  std::filesystem::remove(folder_ / "a.klg.yaml");
  options_.intrinsics = {31, 30, 15.5, 11.5};
  EXPECT_EQ(Open(KlgFile(2, true, ".jpg"))->info().pinhole.width, 32);
  ExpectInputError([&] { Open(KlgFile(2, true, "")); }, Names("a.klg"));
  options_.intrinsics.reset();
  ExpectInputError([&] { Open(KlgFile(2, true, ".jpg")); }, Names(0, 32, 24, 640, 480));
}

TEST_F(KlgTest, ReadsTheCompleteFramesOfATruncatedFile) {
  const std::string whole = KlgFile(3, true, ".jpg");
  const auto source = Open(whole.substr(0, whole.size() - 1));
  EXPECT_EQ(ReadAll(source.get()).size(), 2u);
  EXPECT_THAT(source->info().warnings, ElementsAre(Names("a.klg", 3)));
}

TEST_F(KlgTest, RejectsFilesWithoutFrames) {
  ExpectInputError([&] { Open(""); }, Names("a.klg", 0));
  ExpectInputError([&] { Open(LittleEndian(0)); }, Names("a.klg"));
  ExpectInputError([&] { Open(LittleEndian(-1)); }, Names("a.klg"));
}

TEST_F(KlgTest, NamesDamagedFrames) {
  std::string file = LittleEndian(4) + KlgFrame(1, "not zlib", "");
  file += KlgFrame(2, ZlibBytes(NumberedDepth(1, 16, 12)), "");
  const std::string depth = RawBytes(NumberedDepth(2));
  file += KlgFrame(3, depth, "no picture");
  const auto results = ReadAll(Open(file + KlgFrame(4, depth, "")).get());
  EXPECT_THAT(results[0].error, Names("a.klg", "depth", 0));
  EXPECT_THAT(results[1].error, Names("a.klg", "depth", 1));
  EXPECT_THAT(results[2].error, Names("a.klg", 2, "JPEG", "PNG"));
  EXPECT_TRUE(results[3].frame);
}

TEST_F(KlgTest, RejectsFoldersAndUnknownFiles) {
  options_.format = "klg";
  options_.path = folder_.path();
  ExpectInputError([&] { OpenSequence(options_); }, Names(folder_.path(), "klg"));
  options_.path = folder_.Write("a.bin", "");
  options_.format = "auto";
  ExpectInputError([&] { OpenSequence(options_); }, Names("a.bin"));
}

class KlgWriterTest : public ::testing::Test {
 protected:
  KlgWriterTest() { WriteTumSequence(folder_, 4); }
  std::unique_ptr<FrameSource> Open(const std::string& path) {
    return OpenSequence(OptionsOf(path));
  }
  KlgSummary Write() { return WriteKlg(Open(folder_.path()).get(), folder_ / "a.klg"); }
  TempFolder folder_;
};

TEST_F(KlgWriterTest, RoundTripsFrames) {
  const auto expected = ReadAll(Open(folder_.path()).get());
  const KlgSummary summary = Write();
  EXPECT_EQ(summary.frames_written, 4);
  EXPECT_EQ(summary.frames_skipped, 0);
  EXPECT_EQ(summary.depths_out_of_range, 0);
  const auto source = Open(folder_ / "a.klg");
  EXPECT_EQ(source->info().pinhole.fx, 31);
  const auto read = ReadAll(source.get());
  ASSERT_EQ(read.size(), 4u);
  for (int i = 0; i < 4; ++i) {
    EXPECT_DOUBLE_EQ(read[i].stamp_s, expected[i].stamp_s);
    EXPECT_EQ(read[i].frame->depth_m, expected[i].frame->depth_m);
  }
}

TEST_F(KlgWriterTest, JpegColourIsCloseAndSmaller) {
  Write();
  const auto read = ReadAll(Open(folder_ / "a.klg").get());
  const Rgb8 color = read[3].frame->color(16, 12);
  EXPECT_NEAR(color.r, 3, 2);
  EXPECT_NEAR(color.g, 20, 2);
  EXPECT_NEAR(color.b, 30, 2);
  EXPECT_LT(std::filesystem::file_size(folder_ / "a.klg"), 4 * sizeof(Rgb8) * 32 * 24 / 2);
}

TEST_F(KlgWriterTest, KeepsTheConventionOfAMirroredSource) {
  folder_.Write("camera.yaml", SmallCameraYaml(-30));
  Write();
  const auto source = Open(folder_ / "a.klg");
  EXPECT_EQ(source->info().camera.depth.fy, -30);
  EXPECT_TRUE(source->info().mirrored);
}

TEST_F(KlgWriterTest, CountsSkippedFramesAndClippedDepths) {
  std::filesystem::remove(folder_ / "depth/002.png");
  Image<std::uint16_t> far = NumberedDepth(1);
  far[5] = 0;      // missing
  far[6] = 65534;  // maximum of a .klg file
  WriteDepth(folder_ / "depth/001.png", far);
  WriteDepth(folder_ / "depth/003.tiff", Image<float>(32, 24, 65.535f));
  std::filesystem::rename(folder_ / "depth/003.tiff", folder_ / "depth/003.png");
  SequenceOptions options = Options(folder_);
  options.rectify.max_depth_m = 100;
  const KlgSummary summary = WriteKlg(OpenSequence(options).get(), folder_ / "a.klg");
  EXPECT_EQ(summary.frames_written, 3);
  EXPECT_EQ(summary.frames_skipped, 1);
  EXPECT_EQ(summary.depths_out_of_range, 32 * 24);
}

class SensTest : public ::testing::Test {
 protected:
  std::unique_ptr<FrameSource> Open(const std::string& bytes) {
    options_.path = folder_.Write("a.sens", bytes);
    return OpenSequence(options_);
  }
  TempFolder folder_;
  SequenceOptions options_;
  SensEncoder encoder_;
};

TEST_F(SensTest, ReadsEveryCodingOfTheSameFrames) {
  encoder_.registered = true;
  for (encoder_.depth_coding = 0; encoder_.depth_coding < 2; ++encoder_.depth_coding) {
    for (const char* color : {"", ".png", ".jpg", "none"}) {
      encoder_.color_coding = color;
      const auto results = ReadAll(Open(encoder_.File(3)).get());
      ASSERT_NO_FATAL_FAILURE(ExpectNumberedFrames(results, encoder_.color_coding));
    }
  }
}

TEST_F(SensTest, ReadsCamerasAndPosesOfTheFile) {
  encoder_.color_extrinsics = TranslationMatrix(0.5f, 0, 0);
  const float inf = std::numeric_limits<float>::infinity();
  encoder_.poses = {TranslationMatrix(7, 8, 9), TranslationMatrix(-inf, 0, 0)};
  const SequenceInfo info = Open(encoder_.File(3))->info();
  EXPECT_EQ(info.format, "sens");
  EXPECT_EQ(info.camera.depth.fy, 30);
  EXPECT_EQ(info.camera.depth.cx, 15.5);
  EXPECT_EQ(info.camera.depth_units_per_metre, 1000);
  EXPECT_FALSE(info.camera.color_is_registered);
  EXPECT_EQ(info.camera.color.width, 64);
  EXPECT_EQ(info.camera.color.fx, 62);
  EXPECT_EQ(info.camera.color_from_depth.translation, Eigen::Vector3d(0.5, 0, 0));
  ASSERT_EQ(info.ground_truth.size(), 2u);  // the second frame has no pose
  EXPECT_EQ(info.ground_truth[0].world_from_camera.translation, Eigen::Vector3d(7, 8, 9));
  EXPECT_DOUBLE_EQ(info.ground_truth[1].stamp_s, 5.2);
}

TEST_F(SensTest, DerivesStampsFromTheFrameRateIfMissing) {
  encoder_.has_stamps = false;
  options_.frames_per_second = 20;
  const auto results = ReadAll(Open(encoder_.File(3)).get());
  EXPECT_DOUBLE_EQ(results[2].stamp_s, 0.1);
}

TEST_F(SensTest, ReadsTheCompleteFramesOfATruncatedFile) {
  const std::string file = encoder_.Header(5) + encoder_.Frame(0) + encoder_.Frame(1);
  const auto source = Open(file + encoder_.Frame(2).substr(0, 200));
  EXPECT_EQ(ReadAll(source.get()).size(), 2u);
  EXPECT_THAT(source->info().warnings, ElementsAre(Names("a.sens", 5)));
}

TEST_F(SensTest, RejectsMalformedFiles) {
  const auto expect = [&](const std::string& bytes, const auto&... names) {
    ExpectInputError([&] { Open(bytes); }, Names("a.sens", names...));
  };
  const std::string file = encoder_.File(1);
  expect("", 0);
  expect("\3" + file.substr(1), 3, 4);
  expect(file.substr(0, 4) + LittleEndian(std::uint64_t{1} << 60) + file.substr(12),
         std::uint64_t{1} << 60);
  expect(file.substr(0, 100));
  expect(encoder_.Header(0));
  const std::size_t depth_width_at = 4 + 8 + 6 + 4 * 64 + 2 * 4 + 2 * 4;
  std::string huge = file;
  huge.replace(depth_width_at, 4, LittleEndian(2000000000));
  expect(huge, "depth", 2000000000, 24);
  huge.replace(depth_width_at, 4, LittleEndian(16000));
  expect(huge, "depth", 0);
  encoder_.color_extrinsics[0] = 3;
  expect(encoder_.File(1));
  encoder_.color_extrinsics[0] = 1;
  encoder_.depth_coding = 2;
  expect(encoder_.File(1), "depth", 2, "occi", 0, "raw", 1, "zlib");
}

}  // namespace
}  // namespace surfit::testing
