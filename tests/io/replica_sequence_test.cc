#include "surfit/io/camera_presets.h"
#include "surfit/io/sequence.h"
#include "testing/expect_input_error.h"
#include "testing/read_all.h"
#include "testing/sequence_writer.h"

namespace surfit {
namespace {

using testing::ExpectInputError;
using ::testing::HasSubstr;
using testing::TempFolder;

class ReplicaTest : public ::testing::Test {
 protected:
  ReplicaTest() {
    std::string poses;
    for (int i = 0; i < 3; ++i) {
      testing::WriteColor(folder_ / testing::Format("room0/results/frame%06d.jpg", i),
                          testing::NumberedColor(i), {cv::IMWRITE_JPEG_QUALITY, 100});
      testing::WriteDepth(folder_ / testing::Format("room0/results/depth%06d.png", i),
                          testing::NumberedDepth(i));
      poses += testing::Format("1 0 0 %d 0 1 0 2 0 0 1 3 0 0 0 1\n", i);
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
  const auto results = testing::ReadAll(source.get());
  ASSERT_EQ(results.size(), 3u);
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(results[i].frame) << results[i].error;
    EXPECT_DOUBLE_EQ(results[i].stamp_s, i / 30.);
    EXPECT_FLOAT_EQ(results[i].frame->depth_m(1, 0), 1.001f + 0.01f * i);
    EXPECT_NEAR(results[i].frame->color(5, 5).g, 20, 2);
  }
}

TEST_F(ReplicaTest, NamesTheImageThatIsMissing) {
  std::filesystem::remove(folder_ / "room0/results/frame000001.jpg");
  const auto results = testing::ReadAll(OpenSequence(options_).get());
  ASSERT_EQ(results.size(), 3u);
  EXPECT_THAT(results[1].error, HasSubstr("results/frame000001.jpg"));
  EXPECT_TRUE(results[2].frame);
}

TEST_F(ReplicaTest, WithoutCamParamsTheCameraIsTheDataSets) {
  std::filesystem::remove(folder_ / "cam_params.json");
  ExpectInputError([&] { OpenSequence(options_); },
                   HasSubstr("is 32 x 24 pixels, must be 1200 x 680"));
  EXPECT_EQ(CameraPreset("replica").depth_units_per_metre, 6553.5);
}

TEST_F(ReplicaTest, RefusesMalformedFiles) {
  folder_.Write("room0/cam_params.json", R"({"camera": {"w": 32}})");
  ExpectInputError([&] { OpenSequence(options_); },
                   ::testing::AllOf(HasSubstr("room0/cam_params.json"), HasSubstr("'h'")));
  std::filesystem::remove(folder_ / "room0/cam_params.json");
  folder_.Write("room0/traj.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n");
  ExpectInputError([&] { OpenSequence(options_); },
                   HasSubstr("traj.txt:1 has 12 columns, must have 16"));
}

}  // namespace
}  // namespace surfit
