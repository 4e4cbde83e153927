#include <limits>

#include "io/sequences/recording.h"
#include "io/stamps/image_names.h"
#include "io/stamps/time_words.h"
#include "surfit/io/camera_files.h"
#include "surfit/io/g2o.h"
#include "surfit/io/point_cloud.h"
#include "surfit/io/sequence.h"
#include "surfit/io/trajectory_files.h"
#include "testing/matchers.h"
#include "testing/recordings.h"
#include "testing/sequence_writer.h"

namespace surfit::testing {
namespace {

constexpr int kCount = 8;

std::string Fixed(double value, int decimals) {
  char text[100];
  std::snprintf(text, sizeof(text), "%.*f", decimals, value);
  return text;
}

// Capture time of frame i of a 30 Hz camera, us after the first frame.
std::int64_t Micros(int i) { return (100000 * i + 1) / 3; }

// Writes the images of a frame under these names without ending.
void WriteFrame(const TempFolder& folder, int i, const std::string& depth,
                const std::string& color) {
  WriteDepth(folder / ("depth/" + depth + ".png"), NumberedDepth(i));
  WriteColor(folder / ("color/" + color + ".png"), NumberedColor(i));
}

// Number of the images of a frame, which are those of NumberedDepth() and NumberedColor().
int ImageNumber(const ReadResult& result) {
  EXPECT_TRUE(result.frame) << result.error;
  if (!result.frame) return -1;
  const int number = static_cast<int>(std::lround((result.frame->depth_m(0, 0) - 1) * 100));
  if (!result.frame->color.empty()) {
    EXPECT_EQ(result.frame->color(3, 3).r, number);
  }
  return number;
}

std::vector<int> ImageNumbers(FrameSource* source) {
  std::vector<int> numbers;
  for (const ReadResult& result : ReadAll(source)) numbers.push_back(ImageNumber(result));
  return numbers;
}

std::vector<int> Counting(int count) {
  std::vector<int> numbers;
  for (int i = 0; i < count; ++i) numbers.push_back(i);
  return numbers;
}

class NumberedFolder : public ::testing::Test {
 protected:
  NumberedFolder() { folder_.Write("camera.yaml", SmallCameraYaml()); }
  std::unique_ptr<FrameSource> Open() { return OpenSequence(Options(folder_)); }
  // Expects that each frame has its own images, and the pose with its number as x coordinate.
  void ExpectOwnPoses(const std::vector<int>& numbers) {
    const auto source = Open();
    const Trajectory truth = source->info().ground_truth;
    const auto results = ReadAll(source.get());
    ASSERT_EQ(results.size(), numbers.size());
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      EXPECT_EQ(ImageNumber(results[i]), numbers[i]);
      const auto pose = InterpolatePose(truth, results[i].stamp_s, 0, 0);
      ASSERT_TRUE(pose) << i;
      EXPECT_EQ(pose->translation.x(), numbers[i]);
    }
  }
  TempFolder folder_;
};

using NamedFolder = NumberedFolder;
using PosesOfFolder = NumberedFolder;
using TimesOfNames = NumberedFolder;

// Numbers with a plus sign.

TEST(PlusSign, IsReadInTrajectoriesGraphsCamerasAndClouds) {
  const TempFolder folder;
  const Trajectory poses = ReadTumTrajectory(
      folder.Write("a.txt", "+1.5 +1 -2 +3e+0 +0 +0 +0 +1\n+2.5 0 0 0 0 0 0 1\n"));
  ASSERT_EQ(poses.size(), 2u);
  EXPECT_EQ(poses[0].stamp_s, 1.5);
  EXPECT_EQ(poses[0].world_from_camera.translation, Eigen::Vector3d(1, -2, 3));
  const G2oFile graph = ReadG2o(folder.Write(
      "a.g2o", "VERTEX_SE3:QUAT +0 +1 0 0 0 0 0 +1\nVERTEX_SE3:QUAT 1 2 0 0 0 0 0 1\nFIX +0\n"));
  EXPECT_EQ(graph.graph.poses.size(), 2u);
  folder.Write("camera.yaml",
               "depth_camera: { width: 32, height: +24, fx: +31, fy: 30, cx: +15.5, cy: 11.5 }\n"
               "depth_units_per_metre: +1000\n");
  EXPECT_EQ(ReadCameraYaml(folder / "camera.yaml").depth.fx, 31);
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
      "property float z\nend_header\n";
  EXPECT_EQ(ReadPointCloud(folder.Write("a.ply", head + "+1 -2 +3\n")).points[0],
            Eigen::Vector3f(1, -2, 3));
}

TEST(PlusSign, IsRejectedBeforeAnotherSign) {
  const TempFolder folder;
  for (const std::string word : {"+-1", "++1", "+", "1+"}) {
    const std::string path = folder.Write("a.txt", word + " 1 2 3 0 0 0 1\n");
    ExpectInputError([&] { ReadTumTrajectory(path); },
                     HasSubstr("'" + word + "' is not a finite number"));
  }
}

// Frame counts of .klg files.

std::string KlgWithCount(int count, int frames) {
  return LittleEndian(static_cast<std::int32_t>(count)) + KlgFile(frames, true, ".jpg").substr(4);
}

TEST(KlgFrameCount, BelowTheFramesOfTheFileIsIgnored) {
  const TempFolder folder;
  folder.Write("a.klg.yaml", SmallCameraYaml());
  for (const int count : {0, -1, 3}) {
    for (const int cut : {0, 30}) {
      std::string file = KlgWithCount(count, 6);
      const auto source =
          OpenSequence(OptionsOf(folder.Write("a.klg", file.substr(0, file.size() - cut))));
      EXPECT_EQ(ReadAll(source.get()).size(), cut == 0 ? 6u : 5u);
      EXPECT_THAT(source->info().warnings,
                  ElementsAre(HasSubstr(Concat("declares ", count, " frames, but has "))));
    }
  }
}

TEST(KlgFrameCount, DoesNotMakeFramesOfPadding) {
  const TempFolder folder;
  folder.Write("a.klg.yaml", SmallCameraYaml());
  const std::string file = KlgWithCount(0, 3) + std::string(1000, '\0');
  EXPECT_EQ(OpenSequence(OptionsOf(folder.Write("a.klg", file)))->info().frame_count, 3);
}

// Numbers in the names of images.

TEST_F(NamedFolder, NumberIsTheIntegerThatDiffers) {
  for (const std::string prefix :
       {"d435i_", "color_aligned_to_depth_435_", "2025-11-23_640x480_", "take 2 frame "}) {
    for (int i = 0; i < kCount; ++i) {
      const std::string name = prefix + Format("%06d", i + 7) + "_v2";
      WriteFrame(folder_, i, name, name);
    }
    const auto source = Open();
    EXPECT_EQ(ImageNumbers(source.get()), Counting(kCount));
    EXPECT_THAT(source->info().warnings, IsEmpty());
    std::filesystem::remove_all(folder_ / "depth");
    std::filesystem::remove_all(folder_ / "color");
  }
}

TEST_F(NamedFolder, FilesOfMacOsAreNoImages) {
  for (int i = 0; i < kCount; ++i) {
    const std::string name = Format("%06d", i);
    WriteFrame(folder_, i, name, name);
    folder_.Write("depth/._" + name + ".png", "Mac OS X");
    folder_.Write("color/._" + name + ".png", "Mac OS X");
  }
  EXPECT_EQ(ImageNumbers(Open().get()), Counting(kCount));
  for (const char* kind : {"depth", "color"}) {
    for (int i = 0; i < kCount; ++i) {
      const std::string stem = Concat(kind, "/", Format("%06d.png", i));
      std::filesystem::rename(folder_ / stem,
                              folder_ / Concat(kind, "/", Fixed(1763820000 + 0.1 * i, 3), ".png"));
    }
  }
  const auto results = ReadAll(Open().get());
  ASSERT_EQ(results.size(), static_cast<std::size_t>(kCount));
  EXPECT_DOUBLE_EQ(results[1].stamp_s, 1763820000.1);
}

TEST(NumberImages, TakesTheFreeIntegerOfASingleName) {
  EXPECT_EQ(NumberImages({"d435i_000012.png"}).at(0).number, 12);
  EXPECT_EQ(NumberImages({"frame000012.jpg"}).at(0).number, 12);
  EXPECT_EQ(NumberImages({"0000012-000000366699.png"}).at(0).number, 12);
  EXPECT_THAT(NumberImages({"mask.png"}), IsEmpty());
}

// Invalid ground truth.

TEST(InvalidTruth, OfOneFrameIsCountedInEveryFormat) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const bool is_zero : {true, false}) {
    const std::string word = is_zero ? "0" : "nan";
    TempFolder sens, scenes, log, replica, tum;
    SensEncoder encoder;
    encoder.registered = true;
    encoder.poses = {TranslationMatrix(0, 2, 3), Matrix16()};
    if (!is_zero) encoder.poses[1][5] = nan;
    sens.Write("a.sens", encoder.File(kCount));
    std::string blocks, lines;
    for (int i = 0; i < kCount; ++i) {
      const std::string one = i == 1 ? word : "1";
      const std::string matrix =
          one + " 0 0 " + std::to_string(i) + "\n0 " + one + " 0 2\n0 0 1 3\n0 0 0 1\n";
      const std::string stem = Format("frame-%06d", i);
      WriteColor(scenes / (stem + ".color.png"), NumberedColor(i));
      WriteDepth(scenes / (stem + ".depth.png"), NumberedDepth(i));
      scenes.Write(stem + ".pose.txt", matrix);
      WriteFrame(log, i, Format("%d", i), Format("%d", i));
      blocks += Format("%d 0 0\n", i) + matrix;
      WriteColor(replica / Format("results/frame%06d.jpg", i), NumberedColor(i));
      WriteDepth(replica / Format("results/depth%06d.png", i), NumberedDepth(i));
      std::string line = matrix;
      std::replace(line.begin(), line.end(), '\n', ' ');
      lines += line + "\n";
    }
    log.Write("trajectory.log", blocks);
    replica.Write("traj.txt", lines);
    WriteTumSequence(tum, kCount);
    std::string poses;
    for (int i = 0; i < kCount; ++i)
      poses += Fixed(5.003 + 0.1 * i, 3) + " 1 2 3 0 0 0 " + (i == 1 ? word : "1") + "\n";
    tum.Write("groundtruth.txt", poses);
    for (const TempFolder* folder : {&scenes, &log, &replica})
      folder->Write("camera.yaml", SmallCameraYaml());
    for (const std::string& path :
         {sens / "a.sens", scenes.path(), log.path(), replica.path(), tum.path()}) {
      const auto source = OpenSequence(OptionsOf(path));
      EXPECT_EQ(source->info().ground_truth.size(), kCount - 1u) << path;
      EXPECT_EQ(source->info().frame_count, kCount) << path;
      EXPECT_THAT(source->info().warnings,
                  Contains(HasSubstr("1 of 8 ground-truth poses are invalid and left out")))
          << path;
    }
  }
}

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
      for (int i = 0; i < kCount; ++i) {
        const double stamp_s = 1763820000 + 1e-6 * static_cast<double>(Micros(i));
        WriteFrame(folder_, i, Fixed(stamp_s * per_s, decimals),
                   Fixed((stamp_s + 0.005) * per_s, decimals));
      }
      if (!has_color) std::filesystem::remove_all(folder_ / "color");
      const auto source = Open();
      EXPECT_TRUE(source->info().has_clock);
      EXPECT_THAT(source->info().warnings, Contains(HasSubstr("by their intervals")));
      const auto results = ReadAll(source.get());
      ASSERT_EQ(results.size(), static_cast<std::size_t>(kCount));
      for (int i = 0; i < kCount; ++i) {
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
  WriteTumSequence(folder, kCount);
  std::string depth, rgb, truth;
  for (int i = 0; i < kCount; ++i) {
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
  ASSERT_EQ(results.size(), static_cast<std::size_t>(kCount));
  EXPECT_DOUBLE_EQ(results[3].stamp_s, 1763820000.1);
  EXPECT_EQ(InterpolatePose(source->info().ground_truth, results[3].stamp_s)->translation.x(), 3);
}

TEST(KlgTimes, AreInTheUnitOfTheirIntervals) {
  const TempFolder folder;
  folder.Write("a.klg.yaml", SmallCameraYaml());
  for (const double per_s : {1e3, 1e6, 1e9}) {
    std::string file = LittleEndian(std::int32_t{kCount});
    for (int i = 0; i < kCount; ++i) {
      file +=
          KlgFrame(std::llround(per_s * (1763820000 + i / 30.)), RawBytes(NumberedDepth(i)), "");
    }
    const auto source = OpenSequence(OptionsOf(folder.Write("a.klg", file)));
    EXPECT_EQ(source->info().warnings.size(), per_s == 1e6 ? 0u : 1u);
    EXPECT_NEAR(ReadAll(source.get()).at(6).stamp_s, 1763820000.2, 0.001);
  }
}

// Numbers of frames and poses.

TEST_F(PosesOfFolder, OfALogBelongToTheNumbersOfTheNames) {
  const auto block = [](int number, int pose) {
    return Format("%d 0 0\n1 0 0 ", number) + Format("%d\n0 1 0 2\n0 0 1 3\n0 0 0 1\n", pose);
  };
  struct Convention {
    int first_name, first_pose;
    bool all_poses;  // also of frames that are left out
    bool positions;  // poses count the frames of the folder
  };
  const std::vector<Convention> conventions = {
      {0, 0, true, false},  {1, 0, true, false},  {1, 1, true, false}, {0, 1, true, false},
      {0, 0, false, false}, {1, 0, false, false}, {0, 0, false, true}, {1, 0, false, true}};
  for (const std::vector<int>& kept :
       {Counting(12), std::vector<int>{0, 3, 6, 9}, std::vector<int>{0, 1, 2, 3, 8, 9, 10, 11}}) {
    for (const Convention& convention : conventions) {
      SCOPED_TRACE(::testing::Message() << kept.size() << " frames from " << convention.first_name
                                        << ", poses from " << convention.first_pose);
      for (const int i : kept) {
        const std::string name = Format("%06d", convention.first_name + i);
        WriteFrame(folder_, i, name, name);
      }
      std::string log;
      for (int i = 0; i < 12; ++i) {
        const auto at = std::find(kept.begin(), kept.end(), i);
        if (!convention.all_poses && at == kept.end()) continue;
        const int number = convention.positions ? static_cast<int>(at - kept.begin()) : i;
        log += block(convention.first_pose + number, i);
      }
      folder_.Write("trajectory.log", log);
      ExpectOwnPoses(kept);
      std::filesystem::remove_all(folder_ / "depth");
      std::filesystem::remove_all(folder_ / "color");
    }
  }
}

TEST_F(PosesOfFolder, OfReplicaBelongToTheNumbersOrToAllFrames) {
  for (const std::vector<int>& kept :
       {Counting(12), std::vector<int>{0, 3, 6, 9}, std::vector<int>{0, 1, 2, 3, 8, 9, 10, 11}}) {
    for (const int first : {0, 1}) {
      for (const bool all_poses : {true, false}) {
        if (kept.size() == 4 && first == 1 && !all_poses) continue;  // has no evidence of either
        std::string poses;
        for (int i = 0; i < 12; ++i) {
          const bool is_kept = std::count(kept.begin(), kept.end(), i) > 0;
          if (is_kept) {
            WriteColor(folder_ / Format("results/frame%06d.jpg", first + i), NumberedColor(i),
                       {cv::IMWRITE_JPEG_QUALITY, 100});
            WriteDepth(folder_ / Format("results/depth%06d.png", first + i), NumberedDepth(i));
          }
          if (is_kept || all_poses) poses += Format("1 0 0 %d 0 1 0 2 0 0 1 3 0 0 0 1\n", i);
        }
        folder_.Write("traj.txt", poses);
        SCOPED_TRACE(::testing::Message()
                     << kept.size() << " frames from " << first << ", all poses " << all_poses);
        const auto source = Open();
        const auto results = ReadAll(source.get());
        ASSERT_EQ(results.size(), kept.size());
        for (std::size_t i = 0; i < kept.size(); ++i) {
          EXPECT_DOUBLE_EQ(results[i].stamp_s, (first + kept[i]) / 30.);
          const auto pose = InterpolatePose(source->info().ground_truth, results[i].stamp_s, 0, 0);
          ASSERT_TRUE(pose);
          EXPECT_EQ(pose->translation.x(), kept[i]);
        }
        std::filesystem::remove_all(folder_ / "results");
      }
    }
  }
}

TEST_F(PosesOfFolder, StampsCountTheFramesThatAreLeftOut) {
  for (const int i : {0, 1, 5}) WriteFrame(folder_, i, Format("%d", 3 + i), Format("%d", 3 + i));
  const auto results = ReadAll(Open().get());
  ASSERT_EQ(results.size(), 3u);
  EXPECT_DOUBLE_EQ(results[0].stamp_s, 0);
  EXPECT_DOUBLE_EQ(results[1].stamp_s, 1 / 30.);
  EXPECT_DOUBLE_EQ(results[2].stamp_s, 5 / 30.);
}

// Clocks that start again.

TEST(FindClockStarts, IgnoresUnsortedLists) {
  EXPECT_THAT(FindClockStarts({0, 1, 2, 3, 4, 5, 6, 7}), ElementsAre(0));
  EXPECT_THAT(FindClockStarts({0, 1, 3, 2, 4, 6, 5, 7, 8, 9}), ElementsAre(0));
  EXPECT_THAT(FindClockStarts({10, 11, 12, 13, 14, 15, 0, 1, 2, 3, 4, 5}), ElementsAre(0));
  EXPECT_THAT(FindClockStarts({7, 2, 9, 0, 8, 1, 6, 3, 5, 4, 10, 12, 11}), ElementsAre(0));
  EXPECT_THAT(FindClockStarts({0, 1, 2, 3, 4, 5, 6, 7, 1, 2, 3, 4, 5, 6}), ElementsAre(0, 8));
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
    for (const double lag_s : {0., 0.01, 0.5}) {
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

// Names with number and time.

TEST_F(NamedFolder, ImagesWithNumberAndTimeArePairedByTime) {
  for (const char* form : {"%07d-", "%d_"}) {
    int depth = 1, color = 1;
    for (int i = 0; i < 12; ++i) {
      const std::string time = Format("%012d", static_cast<int>(Micros(i)));
      if (i != 3) {
        WriteDepth(folder_ / ("depth/" + Format(form, depth++) + time + ".png"), NumberedDepth(i));
      }
      if (i != 7) {
        WriteColor(folder_ / ("color/" + Format(form, color++) + time + ".png"), NumberedColor(i));
      }
    }
    const auto source = Open();
    EXPECT_THAT(source->info().warnings, ElementsAre(AllOf(HasSubstr("images are paired by time"),
                                                           HasSubstr("(2 have no"))));
    EXPECT_EQ(ImageNumbers(source.get()), (std::vector<int>{0, 1, 2, 4, 5, 6, 8, 9, 10, 11}));
    std::filesystem::remove_all(folder_ / "depth");
    std::filesystem::remove_all(folder_ / "color");
  }
}

TEST_F(NamedFolder, ImagesWithNumberAndTimeArePairedByNumberIfTheTimesFit) {
  for (int i = 0; i < kCount; ++i) {
    const auto name = [&](int late_us) {
      return Format("%07d-", i + 1) + Format("%012d", static_cast<int>(Micros(i)) + late_us);
    };
    WriteFrame(folder_, i, name(0), name(9000));
  }
  const auto source = Open();
  EXPECT_FALSE(source->info().has_clock);
  const auto results = ReadAll(source.get());
  ASSERT_EQ(results.size(), static_cast<std::size_t>(kCount));
  EXPECT_DOUBLE_EQ(results[3].stamp_s, 3 / 30.);
}

// Ground truth of another clock.

TEST(TumSequenceTimes, OfAnotherClockThanTheTruthAreReported) {
  const TempFolder folder;
  WriteTumSequence(folder, kCount);
  folder.Write("groundtruth.txt", "3605 1 2 3 0 0 0 1\n3606 1 2 3 0 0 0 1\n");
  EXPECT_THAT(OpenSequence(Options(folder))->info().warnings,
              ElementsAre(AllOf(HasSubstr("no frame has ground truth"),
                                HasSubstr("from 5.003000 to 5.703000 s"),
                                HasSubstr("from 3605.000000 to 3606.000000 s"))));
}

}  // namespace
}  // namespace surfit::testing
