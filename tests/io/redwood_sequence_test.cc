#include "surfit/io/sequence.h"
#include "testing/expect_input_error.h"
#include "testing/matchers.h"
#include "testing/read_all.h"
#include "testing/sequence_writer.h"

namespace surfit {
namespace {

using ::testing::AllOf;
using testing::ExpectInputError;
using ::testing::HasSubstr;
using testing::TempFolder;

// Numbered from 1, depth names carrying times as Redwood's do.
void WriteRedwood(const TempFolder& folder, int count, const std::string& color_folder) {
  std::string log;
  for (int i = 0; i < count; ++i) {
    testing::WriteColor(folder / (color_folder + testing::Format("/%07d.jpg", i + 1)),
                        testing::NumberedColor(i), {cv::IMWRITE_JPEG_QUALITY, 100});
    testing::WriteDepth(
        folder / (testing::Format("depth/%07d", i + 1) + testing::Format("-%012d.png", 33366 * i)),
        testing::NumberedDepth(i));
    log += testing::Format("%d ", i) + testing::Format("%d ", i) + testing::Format("%d\n", i + 1);
    log += "0 -1 0 1.5\n1 0 0 " + std::to_string(i) + "\n0 0 1 -3\n0 0 0 1\n";
  }
  folder.Write("trajectory.log", log);
  folder.Write(
      "camera_intrinsic.json",
      R"({"width": 32, "height": 24, "intrinsic_matrix": [31, 0, 0, 0, 30, 0, 15, 11, 1]})");
}

SequenceOptions Options(const TempFolder& folder) {
  SequenceOptions options;
  options.path = folder.path();
  return options;
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
                testing::VectorNear(Eigen::Vector3d(1.5, 3, -3), 1e-12));
    const auto results = testing::ReadAll(source.get());
    ASSERT_EQ(results.size(), 3u);
    for (int i = 0; i < 3; ++i) {
      ASSERT_TRUE(results[i].frame) << results[i].error;
      EXPECT_DOUBLE_EQ(results[i].stamp_s, i / 30.);
      EXPECT_FLOAT_EQ(results[i].frame->depth_m(1, 0), 1.001f + 0.01f * i);
      EXPECT_NEAR(results[i].frame->color(5, 5).r, i, 2);  // one colour, JPEG
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
  const auto results = testing::ReadAll(source.get());
  ASSERT_EQ(results.size(), 2u);
  EXPECT_TRUE(results[0].frame->color.empty());
}

TEST(RedwoodSequence, AMissingImageIsASkippedFrameAndShiftsNoOther) {
  TempFolder folder;
  WriteRedwood(folder, 4, "color");
  std::filesystem::remove(folder / "color/0000002.jpg");
  std::filesystem::remove(folder / "depth/0000003-000000066732.png");
  const auto results = testing::ReadAll(OpenSequence(Options(folder)).get());
  ASSERT_EQ(results.size(), 4u);
  EXPECT_THAT(results[1].error, AllOf(HasSubstr("color/0000002"), HasSubstr(".jpg")));
  EXPECT_THAT(results[2].error, HasSubstr("depth/0000003.png"));
  EXPECT_DOUBLE_EQ(results[3].stamp_s, 3 / 30.);
  EXPECT_TRUE(results[3].frame);
}

TEST(RedwoodSequence, NamesTwoImagesOfOneNumber) {
  TempFolder folder;
  WriteRedwood(folder, 2, "color");
  testing::WriteColor(folder / "color/0000001.png", testing::NumberedColor(0));
  ExpectInputError([&] { OpenSequence(Options(folder)); },
                   HasSubstr("0000001.jpg and 0000001.png are both number 1"));
}

TEST(RedwoodSequence, NamesWhatIsMalformed) {
  TempFolder folder;
  WriteRedwood(folder, 2, "color");
  const auto open = [&] { OpenSequence(Options(folder)); };
  folder.Write("trajectory.log", "0 0 1\n1 0 0 0\n0 1 0 0\n");
  ExpectInputError(open, HasSubstr("trajectory.log ends before"));
  std::filesystem::remove(folder / "trajectory.log");
  folder.Write("camera_intrinsic.json", R"({"width": 32, "height": 24, "intrinsic_matrix": [1]})");
  ExpectInputError(open, HasSubstr("intrinsic_matrix must have 9 numbers"));
  folder.Write("camera_intrinsic.json", R"({"width": 32})");
  ExpectInputError(open, AllOf(HasSubstr("camera_intrinsic.json"), HasSubstr("intrinsic_matrix")));
  folder.Write("camera_intrinsic.json", "{");
  ExpectInputError(open, HasSubstr("camera_intrinsic.json"));
}

}  // namespace
}  // namespace surfit
