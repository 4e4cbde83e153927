#include "io/sequences/recording.h"
#include "surfit/io/camera_files.h"
#include "surfit/io/sequence.h"
#include "surfit/io/trajectory_files.h"
#include "testing/matchers.h"
#include "testing/sequence_writer.h"

namespace surfit::testing {
namespace {

TEST(TumSequence, ReadsFramesStampsAndGroundTruth) {
  TempFolder folder;
  WriteTumSequence(folder, 4);
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
              VectorNear(Eigen::Vector3d(2, 2, 3), 1e-12));

  const auto results = ReadAll(source.get());
  ASSERT_EQ(results.size(), 4u);
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(results[i].index, i);
    EXPECT_DOUBLE_EQ(results[i].stamp_s, 5.003 + 0.1 * i);  // timestamp of depth, not of colour
    ASSERT_TRUE(results[i].frame) << results[i].error;
    EXPECT_EQ(results[i].frame->index, i);
    EXPECT_EQ(results[i].frame->stamp_s, results[i].stamp_s);
    EXPECT_DOUBLE_EQ(results[i].frame->color_stamp_s, 5 + 0.1 * i);
    EXPECT_EQ(results[i].frame->color, NumberedColor(i));
    EXPECT_FLOAT_EQ(results[i].frame->depth_m(3, 0), 1 + 0.01f * i + 0.003f);
  }
}

TEST(TumSequence, PairsImagesByTimeAndSkipsOthers) {
  TempFolder folder;
  WriteTumSequence(folder, 4);
  folder.Write("depth.txt", "5.005 depth/000.png\n5.13 depth/001.png\n5.19 depth/002.png\n");
  const auto results = ReadAll(OpenSequence(Options(folder)).get());
  ASSERT_EQ(results.size(), 2u);
  EXPECT_EQ(results[0].stamp_s, 5.005);
  EXPECT_EQ(results[1].stamp_s, 5.19);
  EXPECT_EQ(results[1].frame->color, NumberedColor(2));
}

TEST(TumSequence, AssociationsOverridePairingByTime) {
  TempFolder folder;
  WriteTumSequence(folder, 4);
  folder.Write(
      "associations.txt",
      "# colour first\n5.1 rgb/001.png 7.1 depth/003.png\r\n5.0,rgb/000.png,7.0,depth/002.png\n");
  const auto results = ReadAll(OpenSequence(Options(folder)).get());
  ASSERT_EQ(results.size(), 2u);
  EXPECT_EQ(results[0].stamp_s, 7.0);  // sorted by time
  EXPECT_EQ(results[1].stamp_s, 7.1);
  EXPECT_EQ(results[1].frame->color, NumberedColor(1));
  EXPECT_FLOAT_EQ(results[1].frame->depth_m(0, 0), 1.03f);
}

TEST(TumSequence, MayLackColor) {
  TempFolder folder;
  WriteTumSequence(folder, 2);
  std::filesystem::remove(folder / "rgb.txt");
  const auto results = ReadAll(OpenSequence(Options(folder)).get());
  ASSERT_EQ(results.size(), 2u);
  ASSERT_TRUE(results[1].frame);
  EXPECT_TRUE(results[1].frame->color.empty());
  EXPECT_DOUBLE_EQ(results[1].stamp_s, 5.103);
  EXPECT_EQ(results[1].frame->color_stamp_s, results[1].stamp_s);
}

TEST(TumSequence, MayLackGroundTruth) {
  TempFolder folder;
  WriteTumSequence(folder, 2);
  std::filesystem::remove(folder / "groundtruth.txt");
  EXPECT_TRUE(OpenSequence(Options(folder))->info().ground_truth.empty());
}

// On systems without symbolic links, a linked folder is a text file with the relative path.
TEST(TumSequence, FollowsAFolderLinkWrittenAsText) {
  TempFolder folder;
  WriteTumSequence(folder, 2);
  std::filesystem::create_directory(folder / "elsewhere");
  std::filesystem::rename(folder / "rgb", folder / "elsewhere/colour");
  folder.Write("rgb", "elsewhere/colour");
  const auto results = ReadAll(OpenSequence(Options(folder)).get());
  ASSERT_EQ(results.size(), 2u);
  EXPECT_EQ(results[1].frame->color, NumberedColor(1));
}

TEST(TumSequence, FollowsAFolderLinkToASiblingFolder) {
  const TempFolder folders;
  TempFolder images, folder;
  WriteTumSequence(images, 2);
  WriteTumSequence(folder, 2);
  std::filesystem::remove_all(folder / "rgb");
  std::filesystem::rename(images.path(), folders / "images");
  std::filesystem::rename(folder.path(), folders / "sequence");
  folders.Write("sequence/rgb", "../images/rgb\n");
  const auto results = ReadAll(OpenSequence(OptionsOf(folders / "sequence")).get());
  ASSERT_EQ(results.size(), 2u);
  EXPECT_EQ(results[1].frame->color, NumberedColor(1));
}

TEST(TumSequence, RejectsFolderLinksElsewhere) {
  for (const std::string target : {"/", "../..", "depth/../../../depth", "../../depth", "/proc"}) {
    const TempFolder folder;
    WriteTumSequence(folder, 2);
    std::filesystem::remove_all(folder / "rgb");
    folder.Write("rgb", target + "\n");
    ExpectInputError([&] { OpenSequence(Options(folder)); }, Names(folder.path() + "/rgb", target));
  }
}

TEST(TumSequence, RejectsMalformedListsByFileAndLine) {
  TempFolder folder;
  WriteTumSequence(folder, 2);
  const auto open = [&] { OpenSequence(Options(folder)); };
  folder.Write("rgb.txt", "# colour\n5.0 rgb/000.png\nfive rgb/001.png\n");
  ExpectInputError(open, Names("rgb.txt:3", "five"));
  folder.Write("rgb.txt", "5.0\n");
  ExpectInputError(open, Names("rgb.txt:1", 1, 2));
  folder.Write("rgb.txt", "9.0 rgb/000.png\n");
  ExpectInputError(open, Names(folder.path(), 0.02));
  folder.Write("rgb.txt", "");
  ExpectInputError(open, Names(folder.path()));
  folder.Write("associations.txt", "5.0 rgb/000.png 5.0\n");
  ExpectInputError(open, Names("associations.txt:1", 3, 4));
  std::filesystem::remove(folder / "associations.txt");
  WriteTumSequence(folder, 2);
  folder.Write("groundtruth.txt", "5.0 1 2 3\n");
  ExpectInputError(open, Names("groundtruth.txt:1"));
}

TEST(TumSequence, RejectsFilesOutsideItsFolder) {
  for (const std::string name : {"/dev/zero", "../depth/001.png", "depth/../../001.png"}) {
    const TempFolder folder;
    WriteTumSequence(folder, 3);
    folder.Write("depth.txt", "5 depth/000.png\n5.1 " + name + "\n");
    ExpectInputError([&] { OpenSequence(Options(folder)); }, Names("depth.txt:2", name));
  }
  const TempFolder folder;
  WriteTumSequence(folder, 3);
  folder.Write("depth.txt", "5 rgb/../depth/000.png\n");
  EXPECT_NO_THROW(OpenSequence(Options(folder)));
}

TEST(TumSequence, RejectsMissingList) {
  TempFolder folder;
  WriteTumSequence(folder, 2);
  std::filesystem::remove(folder / "depth.txt");
  ExpectInputError([&] { OpenSequence(Options(folder)); }, Names("depth.txt"));
}

// Frames 0 to 2 in the layout of ICL-NUIM. File numbers have no leading zeros. The timestamps of
// the trajectory are frame numbers and begin with 1.
void WriteIclNuim(const TempFolder& folder) {
  std::string poses;
  for (int i = 0; i < 3; ++i) {
    WriteColor(folder / Format("rgb/%d.png", i), NumberedColor(i, 640, 480));
    WriteDepth(folder / Format("depth/%d.png", i), Image<std::uint16_t>(640, 480, 9000));
    if (i > 0) poses += Format("%d 0.1 0.2 -2.3 0.1 0.2 0.3 0.9273618\n", i);
  }
  folder.Write("livingRoom2.gt.freiburg", poses);
}

TEST(IclNuimSequence, ReadsNumberedFramesWithTheirNumbersAsStamps) {
  TempFolder folder;
  WriteIclNuim(folder);
  const auto source = OpenSequence(Options(folder));
  EXPECT_EQ(source->info().format, "icl_nuim");
  EXPECT_EQ(source->info().ground_truth.size(), 2u);
  const auto results = ReadAll(source.get());
  ASSERT_EQ(results.size(), 3u);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(results[i].stamp_s, i);
    EXPECT_EQ(results[i].frame->color(0, 0).r, i);
    EXPECT_FLOAT_EQ(results[i].frame->depth_m(0, 0), 1.8f);
  }
}

TEST(IclNuimSequence, ReadsAssociationsWithDepthFirst) {
  TempFolder folder;
  WriteIclNuim(folder);
  folder.Write("associations.txt", "1 depth/1.png 1 rgb/1.png\n2 depth/2.png 2 rgb/2.png\n");
  const auto results = ReadAll(OpenSequence(Options(folder)).get());
  ASSERT_EQ(results.size(), 2u);
  EXPECT_EQ(results[1].stamp_s, 2);
  EXPECT_EQ(results[1].frame->color(0, 0).r, 2);
}

TEST(IclNuimSequence, MirrorsPosesAndCameraConsistently) {
  TempFolder folder;
  WriteIclNuim(folder);
  const auto source = OpenSequence(Options(folder));
  const SequenceInfo& info = source->info();
  EXPECT_TRUE(info.mirrored);
  EXPECT_EQ(info.camera.depth.fy, -480);
  EXPECT_EQ(info.pinhole.fy, 480);
  // World point of a pixel by the conventions of the files and of Surfit. They differ by the mirror
  // S.
  const Trajectory files = ReadTumTrajectory(folder / "livingRoom2.gt.freiburg");
  const Eigen::Matrix3d s = Eigen::Vector3d(1, -1, 1).asDiagonal();
  for (std::size_t i = 0; i < files.size(); ++i) {
    const Eigen::Vector3d in_files =
        files[i].world_from_camera * (1.8 * info.camera.depth.Ray(100, 50));
    const Eigen::Vector3d in_ours =
        info.ground_truth[i].world_from_camera * (1.8 * info.pinhole.Ray(100, 50));
    EXPECT_THAT(in_ours, VectorNear(s * in_files, 1e-12));
  }
  // The image is not flipped: the ray of a pixel in the upper half has negative y (up).
  EXPECT_LT(info.pinhole.Ray(100, 50).y(), 0);
}

TEST(IclNuimSequence, TheCameraFileDeterminesMirroring) {
  TempFolder folder;
  WriteTumSequence(folder, 2, -30);
  const SequenceInfo info = OpenSequence(Options(folder))->info();
  EXPECT_TRUE(info.mirrored);
  EXPECT_EQ(info.pinhole.fy, 30);
  EXPECT_THAT(info.ground_truth[1].world_from_camera.translation,
              VectorNear(Eigen::Vector3d(1, -2, 3), 1e-12));
  TempFolder upright;
  WriteIclNuim(upright);
  SequenceOptions options = Options(upright);
  options.intrinsics = {481.2, 480, 319.5, 239.5};
  EXPECT_FALSE(OpenSequence(options)->info().mirrored);
}

// A folder of one frame of 640 x 480 pixels without a camera.yaml.
class TumCamera : public ::testing::Test {
 protected:
  TumCamera() {
    WriteColor(folder_ / "rgb/5.png", NumberedColor(0, 640, 480));
    WriteDepth(folder_ / "depth/5.png", Image<std::uint16_t>(640, 480, 9000));
    Write("", "");
    options_.path = folder_.path();
  }
  void Write(const std::string& head_of_rgb, const std::string& head_of_depth) {
    folder_.Write("rgb.txt", head_of_rgb + "5.0 rgb/5.png\n");
    folder_.Write("depth.txt", head_of_depth + "5.0 depth/5.png\n");
  }
  void ExpectPreset(const std::string& name) {
    const SequenceInfo info = OpenSequence(options_)->info();
    EXPECT_EQ(info.camera.depth.fx, CameraPreset(name).depth.fx);
    EXPECT_EQ(info.camera.depth.distortion, CameraPreset(name).depth.distortion);
    EXPECT_EQ(info.camera.latency_s, CameraPreset(name).latency_s);
    EXPECT_THAT(info.warnings, IsEmpty());
  }

  const TempFolder folder_;
  SequenceOptions options_;
};

std::string Head(int number) {
  return "# color images\n# file: 'rgbd_dataset_freiburg" + std::to_string(number) +
         "_desk.bag'\n# timestamp filename\n";
}

TEST_F(TumCamera, IsThePresetNamedInTheHeaderOfAList) {
  for (int i = 1; i <= 3; ++i) {
    Write(Head(i), "");
    ExpectPreset("tum_fr" + std::to_string(i));
    Write("# colour\n", Head(i));
    ExpectPreset("tum_fr" + std::to_string(i));
  }
}

TEST_F(TumCamera, IsLoggedOnce) {
  Write(Head(2), Head(2));
  ::testing::internal::CaptureStderr();
  OpenSequence(options_);
  const std::string log = ::testing::internal::GetCapturedStderr();
  EXPECT_THAT(log, Names("tum_fr2", folder_.path() + "/rgb.txt"));
  EXPECT_EQ(log.find("tum_fr2"), log.rfind("tum_fr2"));
}

TEST_F(TumCamera, OfFolderAndOptionsTakesPrecedence) {
  Write(Head(1), "");
  options_.camera = "tum_fr3";
  ExpectPreset("tum_fr3");
  options_.camera.clear();
  WriteCameraYaml(CameraPreset("icl_nuim"), folder_ / "camera.yaml");
  ExpectPreset("icl_nuim");
  std::filesystem::remove(folder_ / "camera.yaml");
  options_.latency_s = 0;
  options_.intrinsics = {500, 501, 320, 240};
  const RgbdCamera camera = OpenSequence(options_)->info().camera;
  EXPECT_EQ(camera.depth.fx, 500);
  EXPECT_EQ(camera.depth.distortion, CameraPreset("tum_fr1").depth.distortion);
  EXPECT_EQ(camera.latency_s, 0);
}

TEST_F(TumCamera, CausesAWarningIfNoPresetIsNamed) {
  for (const std::string& head :
       {std::string(), Head(4), std::string("# as in freiburg1\n"), "\n" + Head(1)}) {
    Write(head, "# depth\n5.0 depth/5.png\n" + Head(1));
    const SequenceInfo info = OpenSequence(options_)->info();
    EXPECT_EQ(info.camera.depth.fx, 525);
    EXPECT_EQ(info.camera.latency_s, 0);
    EXPECT_THAT(info.warnings, ElementsAre(Names(folder_.path(), 525)));
  }
}

}  // namespace
}  // namespace surfit::testing
