// Which camera a TUM folder is read with.
#include "surfit/io/camera_files.h"
#include "surfit/io/sequence.h"
#include "testing/matchers.h"
#include "testing/sequence_writer.h"

namespace surfit::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

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

TEST_F(TumCamera, IsTheOneThatTheHeadOfAListNames) {
  for (int i = 1; i <= 3; ++i) {
    Write(Head(i), "");
    ExpectPreset("tum_fr" + std::to_string(i));
    Write("# colour\n", Head(i));
    ExpectPreset("tum_fr" + std::to_string(i));
  }
}

TEST_F(TumCamera, IsToldInALine) {
  Write(Head(2), Head(2));
  ::testing::internal::CaptureStderr();
  OpenSequence(options_);
  const std::string log = ::testing::internal::GetCapturedStderr();
  EXPECT_THAT(log, HasSubstr("rgb.txt names the recording: its camera is the preset tum_fr2"));
  EXPECT_EQ(log.find("preset"), log.rfind("preset"));
}

TEST_F(TumCamera, OfTheFolderOrTheOptionsGoesFirst) {
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

TEST_F(TumCamera, IsWarnedAboutWhereNoneIsNamed) {
  for (const std::string& head :
       {std::string(), Head(4), std::string("# as in freiburg1\n"), "\n" + Head(1)}) {
    Write(head, "# depth\n5.0 depth/5.png\n" + Head(1));
    const SequenceInfo info = OpenSequence(options_)->info();
    EXPECT_EQ(info.camera.depth.fx, 525);
    EXPECT_EQ(info.camera.latency_s, 0);
    EXPECT_THAT(info.warnings, ElementsAre(HasSubstr("does not name its camera")));
  }
}

}  // namespace
}  // namespace surfit::testing
