#include "surfit/io/camera_files.h"
#include "surfit/io/sequence.h"
#include "testing/matchers.h"
#include "testing/sequence_writer.h"

namespace surfit::testing {
namespace {

void WriteSevenScenes(const TempFolder& folder, int count) {
  for (int i = 0; i < count; ++i) {
    const std::string stem = Format("frame-%06d", i);
    WriteColor(folder / (stem + ".color.png"), NumberedColor(i));
    WriteDepth(folder / (stem + ".depth.png"), NumberedDepth(i));
    // Rotation by 90 degrees about z: the x axis of the camera is the y axis of the world.
    folder.Write(stem + ".pose.txt",
                 "0 -1 0 1.5\t\n 1 0 0 " + std::to_string(i) + "\n0.0e+00 0 1 -3 \n0 0 0 1\n");
  }
  folder.Write("camera.yaml", SmallCameraYaml());
}

TEST(SevenScenesSequence, ReadsFramesAndCameraToWorldPoses) {
  TempFolder folder;
  WriteSevenScenes(folder, 4);
  const auto source = OpenSequence(Options(folder));
  EXPECT_EQ(source->info().format, "seven_scenes");
  const Trajectory& poses = source->info().ground_truth;
  ASSERT_EQ(poses.size(), 4u);
  EXPECT_DOUBLE_EQ(poses[3].stamp_s, 3 / 30.);
  EXPECT_THAT(poses[3].world_from_camera * Eigen::Vector3d(1, 0, 0),
              VectorNear(Eigen::Vector3d(1.5, 4, -3), 1e-12));
  const auto results = ReadAll(source.get());
  ASSERT_EQ(results.size(), 4u);
  EXPECT_DOUBLE_EQ(results[3].stamp_s, 3 / 30.);
  EXPECT_EQ(results[3].frame->color, NumberedColor(3));
  EXPECT_FLOAT_EQ(results[3].frame->depth_m(1, 0), 1.031f);
}

TEST(SevenScenesSequence, FramesPerSecondDetermineTheStamps) {
  TempFolder folder;
  WriteSevenScenes(folder, 2);
  SequenceOptions options = Options(folder);
  options.frames_per_second = 10;
  const auto source = OpenSequence(options);
  EXPECT_DOUBLE_EQ(source->info().ground_truth[1].stamp_s, 0.1);
  EXPECT_DOUBLE_EQ(ReadAll(source.get())[1].stamp_s, 0.1);
}

TEST(SevenScenesSequence, SkipsFramesWithMissingImagesAndAllowsMissingPoses) {
  TempFolder folder;
  WriteSevenScenes(folder, 4);
  std::filesystem::remove(folder / "frame-000001.depth.png");
  std::filesystem::remove(folder / "frame-000002.color.png");
  std::filesystem::remove(folder / "frame-000003.pose.txt");
  const auto source = OpenSequence(Options(folder));
  EXPECT_EQ(source->info().ground_truth.size(), 3u);
  const auto results = ReadAll(source.get());
  ASSERT_EQ(results.size(), 4u);
  EXPECT_THAT(results[1].error, Names("frame-000001.depth.png"));
  EXPECT_THAT(results[2].error, Names("frame-000002.color.png"));
  EXPECT_TRUE(results[3].frame);
}

TEST(SevenScenesSequence, RejectsMalformedPoses) {
  TempFolder folder;
  WriteSevenScenes(folder, 2);
  const auto open = [&] { OpenSequence(Options(folder)); };
  folder.Write("frame-000001.pose.txt", "1 0 0 0\n0 1 0 0\n0 0 1 0\n");
  ExpectInputError(open, Names("frame-000001.pose.txt"));
  folder.Write("frame-000001.pose.txt", "1 0 0 0\n0 1 0\n0 0 1 0\n0 0 0 1\n");
  ExpectInputError(open, Names("frame-000001.pose.txt:2", 3, 4));
  folder.Write("frame-000001.pose.txt", "1 0 0 0\n0 one 0 0\n0 0 1 0\n0 0 0 1\n");
  ExpectInputError(open, Names("frame-000001.pose.txt:1", "one"));
}

// Redwood names: numbers begin with 1, and depth file names contain times.
void WriteRedwood(const TempFolder& folder, int count, const std::string& color_folder) {
  std::string log;
  for (int i = 0; i < count; ++i) {
    WriteColor(folder / (color_folder + Format("/%07d.jpg", i + 1)), NumberedColor(i),
               {cv::IMWRITE_JPEG_QUALITY, 100});
    WriteDepth(folder / (Format("depth/%07d", i + 1) + Format("-%012d.png", 33366 * i)),
               NumberedDepth(i));
    log += Format("%d ", i) + Format("%d ", i) + Format("%d\n", i + 1);
    log += "0 -1 0 1.5\n1 0 0 " + std::to_string(i) + "\n0 0 1 -3\n0 0 0 1\n";
  }
  folder.Write("trajectory.log", log);
  folder.Write(
      "camera_intrinsic.json",
      R"({"width": 32, "height": 24, "intrinsic_matrix": [31, 0, 0, 0, 30, 0, 15, 11, 1]})");
}

TEST(RedwoodSequence, ReadsFramesPosesAndCamera) {
  for (const char* color_folder : {"color", "rgb", "image"}) {
    TempFolder folder;
    WriteRedwood(folder, 3, color_folder);
    const auto source = OpenSequence(Options(folder));
    const SequenceInfo& info = source->info();
    EXPECT_EQ(info.format, "redwood");
    EXPECT_EQ(info.pinhole.fx, 31);
    EXPECT_EQ(info.pinhole.fy, 30);
    EXPECT_EQ(info.pinhole.cx, 15);
    EXPECT_EQ(info.pinhole.cy, 11);
    ASSERT_EQ(info.ground_truth.size(), 3u);
    EXPECT_DOUBLE_EQ(info.ground_truth[2].stamp_s, 2 / 30.);
    EXPECT_THAT(info.ground_truth[2].world_from_camera * Eigen::Vector3d(1, 0, 0),
                VectorNear(Eigen::Vector3d(1.5, 3, -3), 1e-12));
    const auto results = ReadAll(source.get());
    ASSERT_EQ(results.size(), 3u);
    for (int i = 0; i < 3; ++i) {
      ASSERT_TRUE(results[i].frame) << results[i].error;
      EXPECT_DOUBLE_EQ(results[i].stamp_s, i / 30.);
      EXPECT_FLOAT_EQ(results[i].frame->depth_m(1, 0), 1.001f + 0.01f * i);
      EXPECT_NEAR(results[i].frame->color(5, 5).r, i, 2);  // uniform JPEG image
    }
  }
}

TEST(RedwoodSequence, MayLackColorAndPoses) {
  TempFolder folder;
  WriteRedwood(folder, 2, "color");
  std::filesystem::remove_all(folder / "color");
  std::filesystem::remove(folder / "trajectory.log");
  const auto source = OpenSequence(Options(folder));
  EXPECT_TRUE(source->info().ground_truth.empty());
  const auto results = ReadAll(source.get());
  ASSERT_EQ(results.size(), 2u);
  EXPECT_TRUE(results[0].frame->color.empty());
}

TEST(RedwoodSequence, SkipsFramesWithMissingImagesWithoutRenumbering) {
  TempFolder folder;
  WriteRedwood(folder, 4, "color");
  std::filesystem::remove(folder / "color/0000002.jpg");
  std::filesystem::remove(folder / "depth/0000003-000000066732.png");
  const auto results = ReadAll(OpenSequence(Options(folder)).get());
  ASSERT_EQ(results.size(), 4u);
  EXPECT_THAT(results[1].error, ContainsRegex("color/0000002.*[.]jpg"));
  EXPECT_THAT(results[2].error, Names("depth/0000003.png"));
  EXPECT_DOUBLE_EQ(results[3].stamp_s, 3 / 30.);
  EXPECT_TRUE(results[3].frame);
}

TEST(RedwoodSequence, RejectsTwoImagesOfOneNumber) {
  TempFolder folder;
  WriteRedwood(folder, 2, "color");
  WriteColor(folder / "color/0000001.png", NumberedColor(0));
  ExpectInputError([&] { OpenSequence(Options(folder)); }, Names("0000001.jpg", "0000001.png", 1));
}

TEST(RedwoodSequence, WarnsThatTheCameraIsGuessed) {
  TempFolder folder;
  WriteColor(folder / "color/1.png", NumberedColor(1, 640, 480));
  WriteDepth(folder / "depth/1.png", NumberedDepth(1, 640, 480));
  SequenceOptions options = Options(folder);
  const SequenceInfo guessed = OpenSequence(options)->info();
  EXPECT_TRUE(guessed.camera_is_guessed);
  EXPECT_THAT(guessed.warnings, ElementsAre(Names(folder.path(), 525, 1000)));
  EXPECT_THAT(guessed.assumed, Names("redwood", 1, 640, 480, 525, 1000));
  options.camera = "kinect_v1";
  EXPECT_FALSE(OpenSequence(options)->info().camera_is_guessed);
  EXPECT_THAT(OpenSequence(options)->info().camera_from, Names("kinect_v1"));
  options.camera = "";
  options.intrinsics = {500, 500, 320, 240};
  EXPECT_THAT(OpenSequence(options)->info().warnings, IsEmpty());
  EXPECT_THAT(OpenSequence(options)->info().camera_from, ContainsRegex("GUESSED|guessed"));
}

TEST(RedwoodSequence, RejectsUnknownImageSizeAndListsPresets) {
  TempFolder folder;
  WriteDepth(folder / "depth/1.png", NumberedDepth(1, 848, 480));
  ExpectInputError([&] { OpenSequence(Options(folder)); },
                   Names("depth/1.png", 848, 480, "realsense_d415", "realsense_d435"));
}

// File numbers of ICL-NUIM without its pose file.
TEST(IclNuimSequence, WarnsThatTheFormatIsGuessedWithoutPoses) {
  TempFolder folder;
  WriteColor(folder / "rgb/0.png", NumberedColor(1, 640, 480));
  WriteDepth(folder / "depth/0.png", Image<std::uint16_t>(640, 480, 9000));
  SequenceOptions options = Options(folder);
  EXPECT_THAT(OpenSequence(options)->info().warnings, ElementsAre(Names("mirrored")));
  options.format = "icl_nuim";
  EXPECT_THAT(OpenSequence(options)->info().warnings, IsEmpty());
}

// Recorders of ROS and RealSense name images by time. Colour is a little later than depth.
TEST(RedwoodSequence, ReadsTimesFromFileNames) {
  TempFolder folder;
  for (int i = 0; i < 3; ++i) {
    WriteDepth(folder / Format("depth/1763820000.%d34.png", i + 1), NumberedDepth(i));
    WriteColor(folder / Format("color/1763820000.%d45.png", i + 1), NumberedColor(i));
  }
  WriteColor(folder / "color/1763820000.167.png", NumberedColor(99));
  folder.Write("camera.yaml", SmallCameraYaml());
  folder.Write("groundtruth.txt", "1763820000.2 1 2 3 0 0 0 1\n");
  const auto source = OpenSequence(Options(folder));
  EXPECT_EQ(source->info().ground_truth.size(), 1u);
  const auto results = ReadAll(source.get());
  ASSERT_EQ(results.size(), 3u);
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(results[i].frame) << results[i].error;
    EXPECT_NEAR(results[i].stamp_s, 1763820000.134 + 0.1 * i, 1e-6);
    EXPECT_NEAR(results[i].frame->color_stamp_s, 1763820000.145 + 0.1 * i, 1e-6);
    EXPECT_EQ(results[i].frame->color(3, 3).r, i);
  }
  std::filesystem::remove_all(folder / "color");
  EXPECT_EQ(OpenSequence(Options(folder))->info().frame_count, 3);
  WriteColor(folder / "color/1763829999.5.png", NumberedColor(1));
  ExpectInputError([&] { OpenSequence(Options(folder)); }, Names(0.02));
}

TEST(RedwoodSequence, ReadsPgmAndPpm) {
  TempFolder folder;
  WriteColor(folder / "rgb/7.ppm", NumberedColor(7));
  WriteDepth(folder / "depth/7.pgm", NumberedDepth(7));
  folder.Write("camera.yaml", SmallCameraYaml());
  const auto results = ReadAll(OpenSequence(Options(folder)).get());
  ASSERT_EQ(results.size(), 1u);
  ASSERT_TRUE(results[0].frame) << results[0].error;
  EXPECT_EQ(results[0].frame->color(3, 3).r, 7);
  EXPECT_FLOAT_EQ(results[0].frame->depth_m(0, 0), 1.07F);
}

TEST(RedwoodSequence, RejectsMalformedFiles) {
  TempFolder folder;
  WriteRedwood(folder, 2, "color");
  const auto open = [&] { OpenSequence(Options(folder)); };
  folder.Write("trajectory.log", "0 0 1\n1 0 0 0\n0 1 0 0\n");
  ExpectInputError(open, Names("trajectory.log"));
  std::filesystem::remove(folder / "trajectory.log");
  folder.Write("camera_intrinsic.json", R"({"width": 32, "height": 24, "intrinsic_matrix": [1]})");
  ExpectInputError(open, Names("intrinsic_matrix", 9));
  folder.Write("camera_intrinsic.json", R"({"width": 32})");
  ExpectInputError(open, Names("camera_intrinsic.json", "intrinsic_matrix"));
  folder.Write("camera_intrinsic.json", "{");
  ExpectInputError(open, Names("camera_intrinsic.json"));
}

class ReplicaTest : public ::testing::Test {
 protected:
  ReplicaTest() {
    std::string poses;
    for (int i = 0; i < 3; ++i) {
      WriteColor(folder_ / Format("room0/results/frame%06d.jpg", i), NumberedColor(i),
                 {cv::IMWRITE_JPEG_QUALITY, 100});
      WriteDepth(folder_ / Format("room0/results/depth%06d.png", i), NumberedDepth(i));
      poses += Format("1 0 0 %d 0 1 0 2 0 0 1 3 0 0 0 1\n", i);
    }
    folder_.Write("room0/traj.txt", poses);
    folder_.Write("cam_params.json",
                  R"({"camera": {"w": 32, "h": 24, "fx": 31.0, "fy": 30.0, "cx": 15.5,
                      "cy": 11.5, "scale": 1000.0}})");
    options_.path = folder_ / "room0";
  }
  TempFolder folder_;
  SequenceOptions options_;
};

TEST_F(ReplicaTest, ReadsFramesPosesAndCamera) {
  const auto source = OpenSequence(options_);
  const SequenceInfo& info = source->info();
  EXPECT_EQ(info.format, "replica");
  EXPECT_EQ(info.pinhole.fy, 30);
  ASSERT_EQ(info.ground_truth.size(), 3u);
  EXPECT_DOUBLE_EQ(info.ground_truth[2].stamp_s, 2 / 30.);
  EXPECT_EQ(info.ground_truth[2].world_from_camera.translation, Eigen::Vector3d(2, 2, 3));
  const auto results = ReadAll(source.get());
  ASSERT_EQ(results.size(), 3u);
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(results[i].frame) << results[i].error;
    EXPECT_DOUBLE_EQ(results[i].stamp_s, i / 30.);
    EXPECT_FLOAT_EQ(results[i].frame->depth_m(1, 0), 1.001f + 0.01f * i);
    EXPECT_NEAR(results[i].frame->color(5, 5).g, 20, 2);
  }
}

TEST_F(ReplicaTest, NamesTheMissingImage) {
  std::filesystem::remove(folder_ / "room0/results/frame000001.jpg");
  const auto results = ReadAll(OpenSequence(options_).get());
  ASSERT_EQ(results.size(), 3u);
  EXPECT_THAT(results[1].error, Names("results/frame000001.jpg"));
  EXPECT_TRUE(results[2].frame);
}

TEST_F(ReplicaTest, UsesThePresetWithoutCamParams) {
  std::filesystem::remove(folder_ / "cam_params.json");
  ExpectInputError([&] { OpenSequence(options_); }, Names(32, 24, 1200, 680));
  EXPECT_EQ(CameraPreset("replica").depth_units_per_metre, 6553.5);
}

TEST_F(ReplicaTest, RejectsMalformedFiles) {
  folder_.Write("room0/cam_params.json", R"({"camera": {"w": 32}})");
  ExpectInputError([&] { OpenSequence(options_); }, Names("room0/cam_params.json", "h"));
  std::filesystem::remove(folder_ / "room0/cam_params.json");
  folder_.Write("room0/traj.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n");
  ExpectInputError([&] { OpenSequence(options_); }, Names("traj.txt:1", 12, 16));
}

}  // namespace
}  // namespace surfit::testing
