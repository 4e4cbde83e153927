#include "surfit/io/sequence.h"
#include "testing/expect_input_error.h"
#include "testing/matchers.h"
#include "testing/read_all.h"
#include "testing/sequence_writer.h"

namespace surfit {
namespace {

using testing::ExpectInputError;
using ::testing::HasSubstr;
using testing::TempFolder;

void WriteSevenScenes(const TempFolder& folder, int count) {
  for (int i = 0; i < count; ++i) {
    const std::string stem = testing::Format("frame-%06d", i);
    testing::WriteColor(folder / (stem + ".color.png"), testing::NumberedColor(i));
    testing::WriteDepth(folder / (stem + ".depth.png"), testing::NumberedDepth(i));
    // A quarter turn about z: the camera's x axis points along the world's y.
    folder.Write(stem + ".pose.txt",
                 "0 -1 0 1.5\t\n 1 0 0 " + std::to_string(i) + "\n0.0e+00 0 1 -3 \n0 0 0 1\n");
  }
  folder.Write("camera.yaml", testing::SmallCameraYaml());
}

SequenceOptions Options(const TempFolder& folder) {
  SequenceOptions options;
  options.path = folder.path();
  return options;
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
              testing::VectorNear(Eigen::Vector3d(1.5, 4, -3), 1e-12));
  const auto results = testing::ReadAll(source.get());
  ASSERT_EQ(results.size(), 4u);
  EXPECT_DOUBLE_EQ(results[3].stamp_s, 3 / 30.);
  EXPECT_EQ(results[3].frame->color, testing::NumberedColor(3));
  EXPECT_FLOAT_EQ(results[3].frame->depth_m(1, 0), 1.031f);
}

TEST(SevenScenesSequence, FramesPerSecondGiveTheStamps) {
  TempFolder folder;
  WriteSevenScenes(folder, 2);
  SequenceOptions options = Options(folder);
  options.frames_per_second = 10;
  const auto source = OpenSequence(options);
  EXPECT_DOUBLE_EQ(source->info().ground_truth[1].stamp_s, 0.1);
  EXPECT_DOUBLE_EQ(testing::ReadAll(source.get())[1].stamp_s, 0.1);
}

TEST(SevenScenesSequence, AMissingImageIsASkippedFrameAndAMissingPoseIsNone) {
  TempFolder folder;
  WriteSevenScenes(folder, 4);
  std::filesystem::remove(folder / "frame-000001.depth.png");
  std::filesystem::remove(folder / "frame-000002.color.png");
  std::filesystem::remove(folder / "frame-000003.pose.txt");
  const auto source = OpenSequence(Options(folder));
  EXPECT_EQ(source->info().ground_truth.size(), 3u);
  const auto results = testing::ReadAll(source.get());
  ASSERT_EQ(results.size(), 4u);
  EXPECT_THAT(results[1].error, HasSubstr("frame-000001.depth.png"));
  EXPECT_THAT(results[2].error, HasSubstr("frame-000002.color.png"));
  EXPECT_TRUE(results[3].frame);
}

TEST(SevenScenesSequence, NamesAMalformedPose) {
  TempFolder folder;
  WriteSevenScenes(folder, 2);
  const auto open = [&] { OpenSequence(Options(folder)); };
  folder.Write("frame-000001.pose.txt", "1 0 0 0\n0 1 0 0\n0 0 1 0\n");
  ExpectInputError(open, HasSubstr("frame-000001.pose.txt ends before"));
  folder.Write("frame-000001.pose.txt", "1 0 0 0\n0 1 0\n0 0 1 0\n0 0 0 1\n");
  ExpectInputError(open, HasSubstr("frame-000001.pose.txt:2 has 3 columns, must have 4"));
  folder.Write("frame-000001.pose.txt", "1 0 0 0\n0 nan 0 0\n0 0 1 0\n0 0 0 1\n");
  ExpectInputError(open, HasSubstr("'nan' is not a finite number"));
  folder.Write("frame-000001.pose.txt", "1 0 0 0\n0 -1 0 0\n0 0 1 0\n0 0 0 1\n");
  ExpectInputError(open, HasSubstr("no rigid transform"));
}

}  // namespace
}  // namespace surfit
