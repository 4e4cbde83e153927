#include "io/recording.h"
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

SequenceOptions Options(const TempFolder& folder) {
  SequenceOptions options;
  options.path = folder.path();
  return options;
}

TEST(TumSequence, ReadsFramesStampsAndGroundTruth) {
  TempFolder folder;
  testing::WriteTumSequence(folder, 4);
  const auto source = OpenSequence(Options(folder));
  const SequenceInfo& info = source->info();
  EXPECT_EQ(info.format, "tum");
  EXPECT_EQ(info.frame_count, 4);
  EXPECT_FALSE(info.mirrored);
  EXPECT_TRUE(info.warnings.empty());
  EXPECT_EQ(info.pinhole.fx, 31);
  ASSERT_EQ(info.ground_truth.size(), 4u);
  EXPECT_EQ(info.ground_truth[2].stamp_s, 5.2);
  EXPECT_THAT(info.ground_truth[2].world_from_camera.translation,
              testing::VectorNear(Eigen::Vector3d(2, 2, 3), 1e-12));

  const auto results = testing::ReadAll(source.get());
  ASSERT_EQ(results.size(), 4u);
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(results[i].index, i);
    EXPECT_DOUBLE_EQ(results[i].stamp_s, 5 + 0.1 * i);  // colour's, not depth's
    ASSERT_TRUE(results[i].frame) << results[i].error;
    EXPECT_EQ(results[i].frame->index, i);
    EXPECT_EQ(results[i].frame->stamp_s, results[i].stamp_s);
    EXPECT_EQ(results[i].frame->color, testing::NumberedColor(i));
    EXPECT_FLOAT_EQ(results[i].frame->depth_m(3, 0), 1 + 0.01f * i + 0.003f);
  }
}

TEST(TumSequence, PairsByTimeAndLeavesOutTheRest) {
  TempFolder folder;
  testing::WriteTumSequence(folder, 4);
  folder.Write("depth.txt", "5.005 depth/000.png\n5.13 depth/001.png\n5.19 depth/002.png\n");
  const auto results = testing::ReadAll(OpenSequence(Options(folder)).get());
  ASSERT_EQ(results.size(), 2u);
  EXPECT_EQ(results[0].stamp_s, 5.0);
  EXPECT_EQ(results[1].stamp_s, 5.2);
  EXPECT_EQ(results[1].frame->color, testing::NumberedColor(2));
}

TEST(TumSequence, AssociationsTakeThePlaceOfTime) {
  TempFolder folder;
  testing::WriteTumSequence(folder, 4);
  folder.Write(
      "associations.txt",
      "# colour first\n5.1 rgb/001.png 7.1 depth/003.png\r\n5.0,rgb/000.png,7.0,depth/002.png\n");
  const auto results = testing::ReadAll(OpenSequence(Options(folder)).get());
  ASSERT_EQ(results.size(), 2u);
  EXPECT_EQ(results[0].stamp_s, 5.0);  // in order of time
  EXPECT_EQ(results[1].stamp_s, 5.1);
  EXPECT_EQ(results[1].frame->color, testing::NumberedColor(1));
  EXPECT_FLOAT_EQ(results[1].frame->depth_m(0, 0), 1.03f);
}

TEST(TumSequence, MayLackColor) {
  TempFolder folder;
  testing::WriteTumSequence(folder, 2);
  std::filesystem::remove(folder / "rgb.txt");
  const auto results = testing::ReadAll(OpenSequence(Options(folder)).get());
  ASSERT_EQ(results.size(), 2u);
  ASSERT_TRUE(results[1].frame);
  EXPECT_TRUE(results[1].frame->color.empty());
  EXPECT_DOUBLE_EQ(results[1].stamp_s, 5.103);
}

TEST(TumSequence, MayLackGroundTruth) {
  TempFolder folder;
  testing::WriteTumSequence(folder, 2);
  std::filesystem::remove(folder / "groundtruth.txt");
  EXPECT_TRUE(OpenSequence(Options(folder))->info().ground_truth.empty());
}

// Where links are unknown, a linked folder is a file that holds the folder's relative path.
TEST(TumSequence, FollowsAFolderLinkWrittenAsText) {
  TempFolder folder;
  testing::WriteTumSequence(folder, 2);
  std::filesystem::create_directory(folder / "elsewhere");
  std::filesystem::rename(folder / "rgb", folder / "elsewhere/colour");
  folder.Write("rgb", "elsewhere/colour");
  const auto results = testing::ReadAll(OpenSequence(Options(folder)).get());
  ASSERT_EQ(results.size(), 2u);
  EXPECT_EQ(results[1].frame->color, testing::NumberedColor(1));
}

TEST(TumSequence, NamesFileAndLineOfMalformedLists) {
  TempFolder folder;
  testing::WriteTumSequence(folder, 2);
  const auto open = [&] { OpenSequence(Options(folder)); };
  folder.Write("rgb.txt", "# colour\n5.0 rgb/000.png\nfive rgb/001.png\n");
  ExpectInputError(open, AllOf(HasSubstr("rgb.txt:3"), HasSubstr("'five' is not a finite number")));
  folder.Write("rgb.txt", "5.0\n");
  ExpectInputError(open, HasSubstr("rgb.txt:1 has 1 columns, must have 2"));
  folder.Write("rgb.txt", "9.0 rgb/000.png\n");
  ExpectInputError(open, AllOf(HasSubstr(folder.path()), HasSubstr("within 0.02 s")));
  folder.Write("rgb.txt", "");
  ExpectInputError(open, HasSubstr("lists no frames"));
  folder.Write("associations.txt", "5.0 rgb/000.png 5.0\n");
  ExpectInputError(open, HasSubstr("associations.txt:1 has 3 columns, must have 4"));
  std::filesystem::remove(folder / "associations.txt");
  testing::WriteTumSequence(folder, 2);
  folder.Write("groundtruth.txt", "5.0 1 2 3\n");
  ExpectInputError(open, HasSubstr("groundtruth.txt:1"));
}

TEST(TumSequence, NamesAMissingList) {
  TempFolder folder;
  testing::WriteTumSequence(folder, 2);
  std::filesystem::remove(folder / "depth.txt");
  ExpectInputError([&] { OpenSequence(Options(folder)); }, HasSubstr("depth.txt"));
}

}  // namespace
}  // namespace surfit
