#include <limits>

#include "io/numbered_folder.h"
#include "io/sequences/recording.h"
#include "io/stamps/image_names.h"
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
    for (int i = 0; i < kNumberedFrames; ++i) {
      const std::string name = prefix + Format("%06d", i + 7) + "_v2";
      WriteFrame(folder_, i, name, name);
    }
    const auto source = Open();
    EXPECT_EQ(ImageNumbers(source.get()), Counting(kNumberedFrames));
    EXPECT_THAT(source->info().warnings, IsEmpty());
    std::filesystem::remove_all(folder_ / "depth");
    std::filesystem::remove_all(folder_ / "color");
  }
}

TEST_F(NamedFolder, FilesOfMacOsAreNoImages) {
  for (int i = 0; i < kNumberedFrames; ++i) {
    const std::string name = Format("%06d", i);
    WriteFrame(folder_, i, name, name);
    folder_.Write("depth/._" + name + ".png", "Mac OS X");
    folder_.Write("color/._" + name + ".png", "Mac OS X");
  }
  EXPECT_EQ(ImageNumbers(Open().get()), Counting(kNumberedFrames));
  for (const char* kind : {"depth", "color"}) {
    for (int i = 0; i < kNumberedFrames; ++i) {
      const std::string stem = Concat(kind, "/", Format("%06d.png", i));
      std::filesystem::rename(folder_ / stem,
                              folder_ / Concat(kind, "/", Fixed(1763820000 + 0.1 * i, 3), ".png"));
    }
  }
  const auto results = ReadAll(Open().get());
  ASSERT_EQ(results.size(), static_cast<std::size_t>(kNumberedFrames));
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
    sens.Write("a.sens", encoder.File(kNumberedFrames));
    std::string blocks, lines;
    for (int i = 0; i < kNumberedFrames; ++i) {
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
    WriteTumSequence(tum, kNumberedFrames);
    std::string poses;
    for (int i = 0; i < kNumberedFrames; ++i)
      poses += Fixed(5.003 + 0.1 * i, 3) + " 1 2 3 0 0 0 " + (i == 1 ? word : "1") + "\n";
    tum.Write("groundtruth.txt", poses);
    for (const TempFolder* folder : {&scenes, &log, &replica})
      folder->Write("camera.yaml", SmallCameraYaml());
    for (const std::string& path :
         {sens / "a.sens", scenes.path(), log.path(), replica.path(), tum.path()}) {
      const auto source = OpenSequence(OptionsOf(path));
      EXPECT_EQ(source->info().ground_truth.size(), kNumberedFrames - 1u) << path;
      EXPECT_EQ(source->info().frame_count, kNumberedFrames) << path;
      EXPECT_THAT(source->info().warnings,
                  Contains(HasSubstr("1 of 8 ground-truth poses are invalid and left out")))
          << path;
    }
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
  for (int i = 0; i < kNumberedFrames; ++i) {
    const auto name = [&](int late_us) {
      return Format("%07d-", i + 1) + Format("%012d", static_cast<int>(Micros(i)) + late_us);
    };
    WriteFrame(folder_, i, name(0), name(9000));
  }
  const auto source = Open();
  EXPECT_FALSE(source->info().has_clock);
  const auto results = ReadAll(source.get());
  ASSERT_EQ(results.size(), static_cast<std::size_t>(kNumberedFrames));
  EXPECT_DOUBLE_EQ(results[3].stamp_s, 3 / 30.);
}

}  // namespace
}  // namespace surfit::testing
