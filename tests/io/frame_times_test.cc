
#include "io/numbered_folder.h"
#include "io/sequences/recording.h"
#include "io/stamps/time_words.h"
#include "surfit/io/camera_files.h"
#include "surfit/io/sequence.h"
#include "testing/matchers.h"
#include "testing/recordings.h"
#include "testing/sequence_writer.h"

namespace surfit::testing {
namespace {

// Fractions of timestamps without leading zeros.

TEST(ParseTimes, AddsMissingZerosOfTheFraction) {
  std::vector<std::string> words;
  std::vector<double> expected_s;
  for (int i = 0; i < 60; ++i) {
    const std::int64_t ns = 12175304000 + 1000 * Micros(i);
    words.push_back(Concat(ns / 1000000000, ".", ns % 1000000000));
    expected_s.push_back(1e-9 * static_cast<double>(ns));
  }
  std::vector<std::string> warnings;
  const Times times = ParseTimes(words, "depth.txt", &warnings);
  EXPECT_EQ(times.decimals, 0);
  for (int i = 0; i < 60; ++i) EXPECT_NEAR(times.stamps_s[i], expected_s[i], 1e-9);
  EXPECT_THAT(warnings, ElementsAre(HasSubstr("depth.txt: the fractions of the timestamps have no "
                                              "leading zeros")));
}

TEST(ParseTimes, KeepsDecimalNumbersOfAnyLength) {
  std::vector<std::string> words;
  for (int i = 1; i < 40; ++i) words.push_back(Concat(5 + 0.05 * i));
  std::vector<std::string> warnings;
  const Times times = ParseTimes(words, "depth.txt", &warnings);
  for (int i = 1; i < 40; ++i) EXPECT_DOUBLE_EQ(times.stamps_s[i - 1], 5 + 0.05 * i);
  EXPECT_THAT(warnings, IsEmpty());
}

TEST(TumSequenceTimes, WithoutLeadingZerosKeepTheOrderOfTheFrames) {
  const TempFolder folder;
  WriteTumSequence(folder, 40);
  std::string depth, rgb;
  for (int i = 0; i < 40; ++i) {
    const std::int64_t us = 5000000 + Micros(i);
    const std::string stamp = Concat(us / 1000000, ".", us % 1000000);
    depth += stamp + Format(" depth/%03d.png\n", i);
    rgb += stamp + Format(" rgb/%03d.png\n", i);
  }
  folder.Write("depth.txt", depth);
  folder.Write("rgb.txt", rgb);
  const auto source = OpenSequence(Options(folder));
  EXPECT_THAT(source->info().warnings, Contains(HasSubstr("have no leading zeros")));
  EXPECT_EQ(ImageNumbers(source.get()), Counting(40));
}

// Units of timestamps.

TEST(DetectTimeUnit, FollowsFromTheIntervals) {
  const auto stamps = [](double first, double interval) {
    std::vector<double> numbers;
    for (int i = 0; i < 20; ++i) numbers.push_back(std::round(first + interval * i));
    return numbers;
  };
  EXPECT_EQ(DetectTimeUnit({1.5, 1.533, 1.567, 1.6}), 0);
  EXPECT_EQ(DetectTimeUnit(stamps(1763820000000, 1e3 / 30)), 3);
  EXPECT_EQ(DetectTimeUnit(stamps(17, 1e3 / 30)), 3);
  EXPECT_EQ(DetectTimeUnit(stamps(1763820000000, 100)), 3);
  EXPECT_EQ(DetectTimeUnit(stamps(0, 1e6 / 30)), 6);
  EXPECT_EQ(DetectTimeUnit(stamps(1.76382e18, 1e9 / 30)), 9);
  EXPECT_EQ(DetectTimeUnit(stamps(0, 10)), std::nullopt);              // every tenth frame
  EXPECT_EQ(DetectTimeUnit({3, 17, 60, 61, 150, 171}), std::nullopt);  // selected frames
  EXPECT_EQ(DetectTimeUnit({5}), std::nullopt);
}

TEST_F(TimesOfNames, AreInTheUnitOfTheirIntervals) {
  for (const auto& [per_s, decimals] :
       {std::pair{1e3, 0}, std::pair{1e3, 3}, std::pair{1e6, 0}, std::pair{1e9, 0}}) {
    for (const bool has_color : {true, false}) {
      for (int i = 0; i < kNumberedFrames; ++i) {
        const double stamp_s = 1763820000 + 1e-6 * static_cast<double>(Micros(i));
        WriteFrame(folder_, i, Fixed(stamp_s * per_s, decimals),
                   Fixed((stamp_s + 0.005) * per_s, decimals));
      }
      if (!has_color) std::filesystem::remove_all(folder_ / "color");
      const auto source = Open();
      EXPECT_TRUE(source->info().has_clock);
      EXPECT_THAT(source->info().warnings, Contains(HasSubstr("by their intervals")));
      const auto results = ReadAll(source.get());
      ASSERT_EQ(results.size(), static_cast<std::size_t>(kNumberedFrames));
      for (int i = 0; i < kNumberedFrames; ++i) {
        EXPECT_EQ(ImageNumber(results[i]), i);
        EXPECT_NEAR(results[i].stamp_s, 1763820000 + i / 30., 0.0006);
        EXPECT_NEAR(results[i].frame->color_stamp_s - results[i].stamp_s, has_color ? 0.005 : 0,
                    0.0011);
      }
      std::filesystem::remove_all(folder_ / "depth");
      std::filesystem::remove_all(folder_ / "color");
    }
  }
}

TEST(TumSequenceTimes, AreInTheUnitOfTheirIntervals) {
  const TempFolder folder;
  WriteTumSequence(folder, kNumberedFrames);
  std::string depth, rgb, truth;
  for (int i = 0; i < kNumberedFrames; ++i) {
    const std::string stamp = std::to_string(1763820000000000 + Micros(i));
    depth += stamp + Format(" depth/%03d.png\n", i);
    rgb += stamp + Format(" rgb/%03d.png\n", i);
    truth += stamp + Format(" %d 2 3 0 0 0 1\n", i);
  }
  folder.Write("depth.txt", depth);
  folder.Write("rgb.txt", rgb);
  folder.Write("groundtruth.txt", truth);
  const auto source = OpenSequence(Options(folder));
  EXPECT_THAT(source->info().warnings, Contains(HasSubstr("depth.txt: timestamps like "
                                                          "1763820000000000 are in us")));
  EXPECT_THAT(source->info().warnings,
              Contains(HasSubstr("groundtruth.txt: timestamps are in us")));
  const auto results = ReadAll(source.get());
  ASSERT_EQ(results.size(), static_cast<std::size_t>(kNumberedFrames));
  EXPECT_DOUBLE_EQ(results[3].stamp_s, 1763820000.1);
  EXPECT_EQ(InterpolatePose(source->info().ground_truth, results[3].stamp_s)->translation.x(), 3);
}

TEST(KlgTimes, AreInTheUnitOfTheirIntervals) {
  const TempFolder folder;
  folder.Write("a.klg.yaml", SmallCameraYaml());
  for (const double per_s : {1e3, 1e6, 1e9}) {
    std::string file = LittleEndian(std::int32_t{kNumberedFrames});
    for (int i = 0; i < kNumberedFrames; ++i) {
      file +=
          KlgFrame(std::llround(per_s * (1763820000 + i / 30.)), RawBytes(NumberedDepth(i)), "");
    }
    const auto source = OpenSequence(OptionsOf(folder.Write("a.klg", file)));
    EXPECT_EQ(source->info().warnings.size(), per_s == 1e6 ? 0u : 1u);
    EXPECT_NEAR(ReadAll(source.get()).at(6).stamp_s, 1763820000.2, 0.001);
  }
}

// Clocks that start again.

TEST(FindClockStarts, IgnoresUnsortedLists) {
  EXPECT_THAT(FindClockStarts({0, 1, 2, 3, 4, 5, 6, 7}), ElementsAre(0));
  EXPECT_THAT(FindClockStarts({0, 1, 3, 2, 4, 6, 5, 7, 8, 9}), ElementsAre(0));
  EXPECT_THAT(FindClockStarts({10, 11, 12, 13, 14, 15, 0, 1, 2, 3, 4, 5}), ElementsAre(0));
  EXPECT_THAT(FindClockStarts({7, 2, 9, 0, 8, 1, 6, 3, 5, 4, 10, 12, 11}), ElementsAre(0));
  EXPECT_THAT(FindClockStarts({0, 1, 2, 3, 4, 5, 6, 7, 1, 2, 3, 4, 5, 6}), ElementsAre(0, 8));
}

TEST(FindClockStarts, FindsALaterTakeWithEarlierTimestamps) {
  EXPECT_THAT(FindClockStarts({20, 21, 22, 23, 24, 0, 1, 2, 3, 4, 5}), ElementsAre(0, 5));
  EXPECT_THAT(FindClockStarts({900, 901, 902, 903, 904, 20, 21, 22, 23, 24, 25, 0, 1, 2, 3, 4}),
              ElementsAre(0, 5, 11));
  // A part of four frames, and parts without a gap.
  EXPECT_THAT(FindClockStarts({20, 21, 22, 23, 0, 1, 2, 3, 4, 5}), ElementsAre(0));
  EXPECT_THAT(FindClockStarts({6, 7, 8, 9, 10, 11, 0, 1, 2, 3, 4, 5}), ElementsAre(0));
}

// Writes two takes of 30 frames each. The clock of the second take is `lag_s` later.
void WriteTwoTakes(const TempFolder& folder, double lag_s, bool associations) {
  WriteTumSequence(folder, 60);
  std::string depth, rgb, both;
  for (int i = 0; i < 60; ++i) {
    const std::string stamp = Fixed(100 + (i % 30) / 30. + (i < 30 ? 0 : lag_s), 6);
    const std::string depth_line = stamp + Format(" depth/%03d.png", i),
                      color_line = stamp + Format(" rgb/%03d.png", i);
    depth += depth_line + "\n";
    rgb += color_line + "\n";
    both += color_line + " " + depth_line + "\n";
  }
  folder.Write("depth.txt", depth);
  folder.Write("rgb.txt", rgb);
  if (associations) folder.Write("associations.txt", both);
  std::filesystem::remove(folder / "groundtruth.txt");
}

TEST(TumSequenceTimes, OfTwoTakesKeepTheOrderOfTheLists) {
  for (const bool associations : {false, true}) {
    for (const double lag_s : {0., 0.01, 0.5, -20., -90.}) {
      const TempFolder folder;
      WriteTwoTakes(folder, lag_s, associations);
      const auto source = OpenSequence(Options(folder));
      EXPECT_THAT(source->info().warnings,
                  ElementsAre(AllOf(HasSubstr("timestamps go back 1 times, first at frame 30"),
                                    HasSubstr("the clock starts again"))));
      EXPECT_EQ(ImageNumbers(source.get()), Counting(60));
    }
  }
}

TEST(KlgTimes, OfTwoTakesAreReported) {
  const TempFolder folder;
  folder.Write("a.klg.yaml", SmallCameraYaml());
  std::string file = LittleEndian(std::int32_t{20});
  for (int i = 0; i < 20; ++i) file += KlgFrame(Micros(i % 10), RawBytes(NumberedDepth(i)), "");
  const auto source = OpenSequence(OptionsOf(folder.Write("a.klg", file)));
  EXPECT_THAT(source->info().warnings, ElementsAre(HasSubstr("timestamps go back 1 times")));
  EXPECT_EQ(ImageNumbers(source.get()), Counting(20));
}

// Ground truth of another clock.

TEST(TumSequenceTimes, OfAnotherClockThanTheTruthAreReported) {
  const TempFolder folder;
  WriteTumSequence(folder, kNumberedFrames);
  folder.Write("groundtruth.txt", "3605 1 2 3 0 0 0 1\n3606 1 2 3 0 0 0 1\n");
  EXPECT_THAT(OpenSequence(Options(folder))->info().warnings,
              ElementsAre(AllOf(HasSubstr("no frame has ground truth"),
                                HasSubstr("from 5.003000 to 5.703000 s"),
                                HasSubstr("from 3605.000000 to 3606.000000 s"))));
}

}  // namespace
}  // namespace surfit::testing
