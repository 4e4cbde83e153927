// Depth of low confidence is missing.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <limits>
#include <thread>

#include "io/images/image_files.h"
#include "io/sequences/record.h"
#include "surfit/io/sequence.h"
#include "testing/matchers.h"
#include "testing/pixels.h"
#include "testing/sequence_writer.h"

namespace surfit::testing {
namespace {

constexpr int kWidth = 32, kHeight = 24;

// Columns of 0, 1 and 2.
Image<std::uint8_t> Stripes(int width = kWidth, int height = kHeight) {
  Image<std::uint8_t> confidence(width, height);
  for (const auto [u, v] : PixelsOf(confidence))
    confidence(u, v) = static_cast<std::uint8_t>(u % 3);
  return confidence;
}

Image<std::uint8_t> Uniform(int value) {
  return Image<std::uint8_t>(kWidth, kHeight, static_cast<std::uint8_t>(value));
}

// A redwood folder of `count` frames without colour.
void WriteDepths(const TempFolder& folder, int count) {
  for (int i = 0; i < count; ++i)
    WriteDepth(folder / Format("depth/%06d.png", i), NumberedDepth(i));
  folder.Write("camera.yaml", SmallCameraYaml());
}

void WriteStripes(const TempFolder& folder, int count) {
  for (int i = 0; i < count; ++i)
    WriteConfidence(folder / Format("confidence/%06d.png", i), Stripes());
}

std::vector<ReadResult> ReadFolder(const TempFolder& folder) {
  return ReadAll(OpenSequence(Options(folder)).get());
}

// Number of pixels without depth. No pixel of NumberedDepth() lacks depth.
int CountMissing(const ReadResult& result) {
  EXPECT_TRUE(result.frame) << result.error;
  if (!result.frame) return -1;
  const Image<float>& depth_m = result.frame->depth_m;
  return static_cast<int>(std::count(depth_m.begin(), depth_m.end(), 0.0f));
}

constexpr int kAll = kWidth * kHeight;
constexpr int kStripes = 11 * kHeight;  // pixels of value 0 in Stripes(): 11 of 32 columns

TEST(Confidence, LowIsMissingAndMediumIsKept) {
  TempFolder folder;
  WriteDepths(folder, 2);
  WriteStripes(folder, 2);
  const auto source = OpenSequence(Options(folder));
  const SequenceInfo& info = source->info();
  EXPECT_THAT(info.warnings, IsEmpty());
  EXPECT_DOUBLE_EQ(info.low_confidence_ratio.value(), 11 / 32.);
  EXPECT_THAT(info.assumed, HasSubstr("no colour, confidence 0 to 2: low confidence (below 1) "
                                      "removes 34.4 % of depth in the first images\n"));
  const auto results = ReadAll(source.get());
  ASSERT_EQ(results.size(), 2u);
  for (int i = 0; i < 2; ++i) {
    ASSERT_TRUE(results[i].frame) << results[i].error;
    const auto depth = NumberedDepth(i);
    for (const auto [u, v] : PixelsOf(depth)) {
      const float expected_m = u % 3 == 0 ? 0 : 1e-3f * depth(u, v);
      ASSERT_FLOAT_EQ(results[i].frame->depth_m(u, v), expected_m) << u << " " << v;
    }
  }
}

TEST(Confidence, HasNoEffectIfSwitchedOff) {
  TempFolder folder;
  WriteDepths(folder, 1);
  folder.Write("confidence/000000.png", "broken");
  folder.Write("confidence.txt", "broken as well");
  SequenceOptions options = Options(folder);
  options.confidence = false;
  const auto source = OpenSequence(options);
  EXPECT_FALSE(source->info().low_confidence_ratio);
  EXPECT_THAT(source->info().assumed, Not(HasSubstr("confidence")));
  EXPECT_EQ(CountMissing(*source->Next()), 0);
}

TEST(Confidence, MissingDepthIsNotPartOfTheRatio) {
  TempFolder folder;
  WriteDepths(folder, 1);
  Image<std::uint16_t> depth = NumberedDepth(0);
  for (const auto [u, v] : PixelsOf(depth))
    if (v < 12) depth(u, v) = u % 2 == 0 ? 0 : 65535;
  WriteDepth(folder / "depth/000000.png", depth);
  Image<std::uint8_t> confidence = Uniform(0);
  for (int u = 0; u < kWidth; ++u) confidence(u, 20) = 2;
  WriteConfidence(folder / "confidence/000000.png", confidence);
  const auto source = OpenSequence(Options(folder));
  EXPECT_DOUBLE_EQ(source->info().low_confidence_ratio.value(), 11 / 12.);
  EXPECT_EQ(CountMissing(*source->Next()), kAll - kWidth);
}

// The second frame has no value above 2: the range is that of the recording.
TEST(Confidence, ByteValuesBelowAThirdAreLow) {
  TempFolder folder;
  WriteDepths(folder, 2);
  Image<std::uint8_t> confidence = Uniform(84);
  confidence(3, 4) = 85;
  confidence(5, 6) = 255;
  WriteConfidence(folder / "confidence/000000.png", confidence);
  WriteConfidence(folder / "confidence/000001.png", Uniform(2));
  const auto source = OpenSequence(Options(folder));
  EXPECT_THAT(source->info().assumed, HasSubstr("confidence 0 to 255: low confidence (below 85)"));
  const auto results = ReadAll(source.get());
  EXPECT_EQ(CountMissing(results[0]), kAll - 2);
  EXPECT_GT(results[0].frame->depth_m(3, 4), 0);
  EXPECT_GT(results[0].frame->depth_m(5, 6), 0);
  EXPECT_EQ(CountMissing(results[1]), kAll);
}

TEST(Confidence, RejectsValuesAboveTheRangeOfTheFirstImages) {
  TempFolder folder;
  WriteDepths(folder, 16);
  WriteStripes(folder, 16);
  WriteConfidence(folder / "confidence/000015.png", Uniform(200));
  const auto results = ReadFolder(folder);
  EXPECT_EQ(CountMissing(results[14]), kStripes);
  EXPECT_THAT(results[15].error, AllOf(HasSubstr("confidence/000015.png has the value 200, must be "
                                                 "at most 2 as in the first confidence images"),
                                       HasSubstr("--confidence=false")));
}

TEST(Confidence, RangeDoesNotDependOnTheFirstFrameThatIsRead) {
  TempFolder folder;
  WriteDepths(folder, 4);
  for (int i = 0; i < 4; ++i)
    WriteConfidence(folder / Format("confidence/%06d.png", i), Uniform(i == 0 ? 200 : 2));
  SequenceOptions options = Options(folder);
  options.first = 2;
  EXPECT_EQ(CountMissing(*OpenSequence(options)->Next()), kAll);
}

TEST(Confidence, CountsFramesWithoutImageAndKeepsTheirDepth) {
  TempFolder folder;
  WriteDepths(folder, 4);
  WriteStripes(folder, 4);
  std::filesystem::remove(folder / "confidence/000001.png");
  std::filesystem::remove(folder / "confidence/000003.png");
  const auto source = OpenSequence(Options(folder));
  EXPECT_THAT(source->info().warnings,
              ElementsAre(AllOf(HasSubstr("2 of 4 frames have no confidence image"),
                                HasSubstr("depth/000001.png"))));
  const auto results = ReadAll(source.get());
  EXPECT_EQ(CountMissing(results[0]), kStripes);
  EXPECT_EQ(CountMissing(results[1]), 0);
  EXPECT_EQ(CountMissing(results[2]), kStripes);
  EXPECT_EQ(CountMissing(results[3]), 0);
}

TEST(Confidence, KeepsAllDepthWithAnEmptyFolder) {
  TempFolder folder;
  WriteDepths(folder, 2);
  std::filesystem::create_directory(folder / "confidence");
  const auto source = OpenSequence(Options(folder));
  EXPECT_THAT(source->info().warnings, ElementsAre(HasSubstr("2 of 2 frames have no confidence")));
  EXPECT_FALSE(source->info().low_confidence_ratio);
  EXPECT_EQ(CountMissing(*source->Next()), 0);
}

TEST(Confidence, UnreadableImageIsAnErrorOfItsFrame) {
  TempFolder folder;
  WriteDepths(folder, 5);
  WriteStripes(folder, 5);
  const std::string bytes = ReadBytes(folder / "confidence/000000.png");
  folder.Write("confidence/000000.png", bytes.substr(0, bytes.size() / 2));
  WriteDepth(folder / "confidence/000001.png", NumberedDepth(0));
  WriteColor(folder / "confidence/000002.png", NumberedColor(0));
  WriteConfidence(folder / "confidence/000003.png", Stripes(30, 24));
  const auto results = ReadFolder(folder);
  ASSERT_EQ(results.size(), 5u);
  EXPECT_THAT(results[0].error, HasSubstr("confidence/000000.png is truncated"));
  EXPECT_THAT(results[1].error, HasSubstr("confidence/000001.png has 1 channel(s) of 16 bits, a "
                                          "confidence image must have one of 8 bits"));
  EXPECT_THAT(results[2].error, HasSubstr("confidence/000002.png has 3 channel(s) of 8 bits"));
  EXPECT_THAT(
      results[3].error,
      AllOf(HasSubstr("confidence/000003.png is 30 x 24 pixels, must have the aspect ratio"),
            HasSubstr("depth/000003.png, 32 x 24")));
  EXPECT_EQ(CountMissing(results[4]), kStripes);
}

TEST(Confidence, RejectsSequencesWithUnreadableImagesOnly) {
  TempFolder folder;
  WriteDepths(folder, 2);
  for (int i = 0; i < 2; ++i)
    WriteDepth(folder / Format("confidence/%06d.png", i), NumberedDepth(i));
  ExpectInputError([&] { OpenSequence(Options(folder)); },
                   HasSubstr("no frame can be read: " + (folder / "confidence/000000.png")));
}

// The value is that of the pixel that contains the centre of the depth pixel.
TEST(Confidence, ResamplesOtherSizesByNearestNeighbour) {
  for (const int height : {3, 12, 36, 48, 96}) {
    TempFolder folder;
    WriteDepths(folder, 1);
    const int width = height * kWidth / kHeight;
    Image<std::uint8_t> confidence(width, height);
    for (const auto [u, v] : PixelsOf(confidence))
      confidence(u, v) = static_cast<std::uint8_t>((u + 2 * v) % 3);
    WriteConfidence(folder / "confidence/000000.png", confidence);
    const auto results = ReadFolder(folder);
    ASSERT_TRUE(results[0].frame) << results[0].error;
    const double scale = static_cast<double>(height) / kHeight;
    for (const auto [u, v] : PixelsOf(kWidth, kHeight)) {
      const auto at = [&](int i) { return static_cast<int>(std::floor((i + 0.5) * scale)); };
      ASSERT_EQ(results[0].frame->depth_m(u, v) == 0, confidence(at(u), at(v)) == 0)
          << height << ": " << u << " " << v;
    }
  }
}

TEST(Confidence, AppliesToFloatDepth) {
  TempFolder folder;
  WriteDepths(folder, 1);
  std::filesystem::remove(folder / "depth/000000.png");
  Image<float> metres(kWidth, kHeight, 1.5f);
  metres(0, 0) = metres(1, 0) = std::numeric_limits<float>::quiet_NaN();
  WriteDepth(folder / "depth/000000.tiff", metres);
  WriteStripes(folder, 1);
  const auto source = OpenSequence(Options(folder));
  EXPECT_DOUBLE_EQ(source->info().low_confidence_ratio.value(), (kStripes - 1.) / (kAll - 2));
  EXPECT_EQ(CountMissing(*source->Next()), kStripes + 1);
}

// Confidence images 10 ms and 30 ms from depth.
TEST(Confidence, MatchesTimestampsInNames) {
  TempFolder folder;
  folder.Write("camera.yaml", SmallCameraYaml());
  WriteDepth(folder / "depth/1763820000.100.png", NumberedDepth(0));
  WriteDepth(folder / "depth/1763820000.200.png", NumberedDepth(1));
  WriteDepth(folder / "depth/1763820000.300.png", NumberedDepth(2));
  WriteConfidence(folder / "confidence/1763820000.100.png", Stripes());
  WriteConfidence(folder / "confidence/1763820000.210.png", Uniform(0));
  WriteConfidence(folder / "confidence/1763820000.330.png", Uniform(0));
  const auto source = OpenSequence(Options(folder));
  EXPECT_THAT(source->info().warnings, ElementsAre(HasSubstr("1 of 3 frames")));
  const auto results = ReadAll(source.get());
  EXPECT_EQ(CountMissing(results[0]), kStripes);
  EXPECT_EQ(CountMissing(results[1]), kAll);
  EXPECT_EQ(CountMissing(results[2]), 0);
}

// Depth of frame i is at 5.003 + 0.1 i, colour 3 ms earlier.
TEST(Confidence, MatchesTimestampsOfAList) {
  TempFolder folder;
  WriteTumSequence(folder, 3);
  WriteConfidence(folder / "sure/a.png", Stripes());
  WriteConfidence(folder / "sure/b.png", Uniform(0));
  folder.Write("confidence.txt",
               "# later first\n5.11 sure/b.png\n5.003 sure/a.png\n5.225 sure/b.png\n");
  for (const bool has_folder : {false, true}) {
    if (has_folder) WriteConfidence(folder / "confidence/002.png", Uniform(0));
    const auto source = OpenSequence(Options(folder));
    EXPECT_THAT(source->info().warnings, ElementsAre(HasSubstr("1 of 3 frames")));
    EXPECT_THAT(source->info().assumed, HasSubstr("colour registered to depth, confidence 0 to 2"));
    const auto results = ReadAll(source.get());
    EXPECT_EQ(CountMissing(results[0]), kStripes);
    EXPECT_EQ(CountMissing(results[1]), kAll);
    EXPECT_EQ(CountMissing(results[2]), 0);
  }
}

TEST(Confidence, RejectsMalformedLists) {
  TempFolder folder;
  WriteTumSequence(folder, 2);
  const auto open = [&] { OpenSequence(Options(folder)); };
  folder.Write("confidence.txt", "5.0 confidence/000.png 1\n");
  ExpectInputError(open, HasSubstr("confidence.txt:1 has 3 columns, must have 2"));
  folder.Write("confidence.txt", "5.0 confidence/000.png\nnow confidence/001.png\n");
  ExpectInputError(open, HasSubstr("confidence.txt:2"));
  folder.Write("confidence.txt", "5.0 ../000.png\n");
  ExpectInputError(open, Names("../000.png"));
  folder.Write("confidence.txt", "5.003 confidence/000.png\n5.103 confidence/001.png\n");
  WriteConfidence(folder / "confidence/000.png", Stripes());
  const auto results = ReadFolder(folder);
  EXPECT_EQ(CountMissing(results[0]), kStripes);
  EXPECT_THAT(results[1].error, HasSubstr("confidence/001.png"));
}

TEST(Confidence, MatchesEqualNamesInATumFolder) {
  TempFolder folder;
  WriteTumSequence(folder, 2);
  const std::string names[] = {"41048190_3418.539", "41048190_3418.606"};
  std::string list;
  for (int i = 0; i < 2; ++i) {
    WriteDepth(folder / ("depth/" + names[i] + ".png"), NumberedDepth(i));
    WriteConfidence(folder / ("confidence/" + names[i] + ".png"), i == 0 ? Stripes() : Uniform(0));
    list += std::to_string(5 + 0.1 * i) + " depth/" + names[i] + ".png\n";
  }
  folder.Write("depth.txt", list);
  const auto results = ReadFolder(folder);
  ASSERT_EQ(results.size(), 2u);
  EXPECT_EQ(CountMissing(results[0]), kStripes);
  EXPECT_EQ(CountMissing(results[1]), kAll);
}

TEST(Confidence, MatchesNumbersInNames) {
  TempFolder folder;
  for (int i = 0; i < 3; ++i) {
    WriteColor(folder / Format("frame-%06d.color.png", i), NumberedColor(i));
    WriteDepth(folder / Format("frame-%06d.depth.png", i), NumberedDepth(i));
  }
  folder.Write("camera.yaml", SmallCameraYaml());
  WriteConfidence(folder / "confidence/c2.pgm", Stripes());
  WriteConfidence(folder / "confidence/c1.tiff", Uniform(0));
  const auto source = OpenSequence(Options(folder));
  EXPECT_EQ(source->info().format, "seven_scenes");
  const auto results = ReadAll(source.get());
  EXPECT_EQ(CountMissing(results[0]), 0);
  EXPECT_EQ(CountMissing(results[1]), kAll);
  EXPECT_EQ(CountMissing(results[2]), kStripes);
  WriteConfidence(folder / "confidence/d2.png", Stripes());
  ExpectInputError([&] { OpenSequence(Options(folder)); },
                   HasSubstr("c2.pgm and d2.png are both number 2, must be one image per number"));
}

TEST(Confidence, RecordingWritesLowConfidenceAsMissing) {
  TempFolder folder, output;
  WriteTumSequence(folder, 3);
  for (int i = 0; i < 2; ++i) WriteConfidence(folder / Format("confidence/%03d.png", i), Stripes());
  RecordOptions options;
  options.sequence = Options(folder);
  options.output = output / "copy";
  const RecordSummary summary =
      RecordSequence(options, std::atomic<bool>(false), [](const RecordSummary&) {});
  EXPECT_EQ(summary.depths, 2 * kAll);
  EXPECT_EQ(summary.low_confidence, 2 * kStripes);
  const auto expected = ReadFolder(folder),
             actual = ReadAll(OpenSequence(OptionsOf(options.output)).get());
  ASSERT_EQ(actual.size(), 3u);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(actual[i].frame->depth_m, expected[i].frame->depth_m) << i;
}

class WatchConfidence : public ::testing::Test {
 protected:
  WatchConfidence() {
    folder_.Write("camera.yaml", SmallCameraYaml());
    std::filesystem::create_directory(folder_ / "depth");
    std::filesystem::create_directory(folder_ / "confidence");
    options_ = Options(folder_);
    options_.format = "watch";
  }
  void AddDepth(int i) { WriteDepth(folder_ / Format("depth/%06d.png", i), NumberedDepth(i)); }
  void AddConfidence(int i, const Image<std::uint8_t>& confidence) {
    WriteConfidence(folder_ / Format("confidence/%06d.png", i), confidence);
  }
  TempFolder folder_;
  SequenceOptions options_;
  std::atomic<bool> stop_{false};
};

TEST_F(WatchConfidence, WaitsForConfidenceAfterDepth) {
  AddDepth(0);
  std::thread writer([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    AddConfidence(0, Stripes());
    AddDepth(1);
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    AddConfidence(1, Uniform(0));
    folder_.Write("done", "");
  });
  const auto source = WatchFolder(options_, stop_);
  const auto results = ReadAll(source.get());
  writer.join();
  EXPECT_THAT(source->info().assumed, HasSubstr("confidence 0 to 2"));
  ASSERT_EQ(results.size(), 2u);
  EXPECT_EQ(CountMissing(results[0]), kStripes);
  EXPECT_EQ(CountMissing(results[1]), kAll);
}

TEST_F(WatchConfidence, UsesFramesWithoutConfidenceAfterTwoSecondsOrAtTheEnd) {
  AddDepth(0);
  AddDepth(1);
  AddConfidence(0, Stripes());
  const auto source = WatchFolder(options_, stop_);
  EXPECT_EQ(CountMissing(*source->Next()), kStripes);
  EXPECT_EQ(CountMissing(*source->Next()), 0);  // after two seconds
  AddDepth(2);
  folder_.Write("done", "");
  EXPECT_EQ(CountMissing(*source->Next()), 0);
  EXPECT_FALSE(source->Next());
}

TEST_F(WatchConfidence, KeepsTheRangeOfTheFirstImage) {
  for (int i = 0; i < 3; ++i) AddDepth(i);
  AddConfidence(0, Uniform(200));
  AddConfidence(1, Uniform(2));
  folder_.Write("confidence/000002.png", "broken");
  folder_.Write("done", "");
  const auto results = ReadAll(WatchFolder(options_, stop_).get());
  ASSERT_EQ(results.size(), 3u);
  EXPECT_EQ(CountMissing(results[0]), 0);
  EXPECT_EQ(CountMissing(results[1]), kAll);
  EXPECT_THAT(results[2].error, HasSubstr("confidence/000002.png"));
}

TEST(ReadConfidenceImage, GivesTheValuesOfEachKind) {
  const TempFolder folder;
  Image<std::uint8_t> values(37, 23);
  for (const auto [u, v] : PixelsOf(values)) values(u, v) = static_cast<std::uint8_t>(u * 7 + v);
  for (const char* name : {"a.png", "a.pgm", "a.tiff"}) {
    WriteConfidence(folder / name, values);
    EXPECT_EQ(ReadConfidenceImage(folder / name), values) << name;
  }
  for (auto& value : values) value = value % 2 == 0 ? 0 : 255;
  WriteConfidence(folder / "bits.png", values, {cv::IMWRITE_PNG_BILEVEL, 1});
  EXPECT_EQ(ReadConfidenceImage(folder / "bits.png"), values);
  // A largest value of 2 does not stand for 255.
  EXPECT_EQ(ReadConfidenceImage(folder.Write("text.pgm", "P2 3 1 2\n0 1 2\n"))[1], 1);
}

TEST(ReadConfidenceImage, RejectsOtherKinds) {
  const TempFolder folder;
  const auto rejects = [&](const std::string& name, const char* message) {
    ExpectInputError([&] { ReadConfidenceImage(folder / name); },
                     AllOf(HasSubstr(name), HasSubstr(message)));
  };
  WriteConfidence(folder / "a.jpg", Stripes());
  rejects("a.jpg", "is a JPEG, a confidence image must be PNG, TIFF or PGM");
  for (const std::string name : {"depth.png", "depth.pgm", "depth.tiff"}) {
    WriteDepth(folder / name, NumberedDepth(0));
    rejects(name, "has 1 channel(s) of 16 bits");
  }
  for (const std::string name : {"color.png", "color.ppm", "color.tiff"}) {
    WriteColor(folder / name, NumberedColor(0));
    rejects(name, "has 3 channel(s) of 8 bits");
  }
  rejects("none.png", "cannot read");
}

}  // namespace
}  // namespace surfit::testing
