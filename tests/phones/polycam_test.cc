// Raw recordings of Polycam: one camera file per frame.
#include "phones/simulated_phone.h"
#include "testing/matchers.h"

namespace surfit::testing {
namespace {

class Polycam : public ::testing::Test {
 protected:
  static const std::vector<SimulatedFrame>& Frames() {
    static const auto* const frames = new auto(RecordWithPhone(kFrames));
    return *frames;
  }
  static std::string Name(int i) { return std::to_string(std::llround(1e6 * Frames()[i].stamp_s)); }
  static std::string CameraText(const SimulatedFrame& frame, const Rigid3d& pose,
                                const std::string& fx) {
    const PinholeCamera& c = frame.color_camera;
    std::string text = "{\"fx\": " + fx + ", \"fy\": " + Number(c.fy) +
                       ", \"cx\": " + Number(c.cx) + ", \"cy\": " + Number(c.cy) +
                       ", \"width\": 320, \"height\": 240, \"blur_score\": 31.2";
    for (int k = 0; k < 12; ++k)
      text +=
          Format(", \"t_%d", k / 4) + Format("%d\": ", k % 4) + Number(pose.Matrix()(k / 4, k % 4));
    return text + "}\n";
  }

  // The corrected poses are right. The other poses drift.
  void Write(bool corrected) const {
    for (int i = 0; i < kFrames; ++i) {
      const SimulatedFrame& frame = Frames()[i];
      const std::string root = folder_ / "keyframes/", fx = Number(frame.color_camera.fx);
      WriteDepth(folder_ / ("keyframes/depth/" + Name(i) + ".png"), Millimetres(frame.depth_m));
      Image<std::uint8_t> confidence = frame.confidence;
      for (auto& value : confidence) value = value == 2 ? 255 : 127 * value;
      WriteConfidence(folder_ / ("keyframes/confidence/" + Name(i) + ".png"), confidence);
      Rigid3d drifted = OpenGlPose(frame);
      if (corrected) drifted.translation.x() += 0.01 * i;
      folder_.Write("keyframes/cameras/" + Name(i) + ".json", CameraText(frame, drifted, fx));
      WriteColor(folder_ / ("keyframes/images/" + Name(i) + ".jpg"), frame.color,
                 {cv::IMWRITE_JPEG_QUALITY, 95});
      if (!corrected) continue;
      folder_.Write("keyframes/corrected_cameras/" + Name(i) + ".json",
                    CameraText(frame, OpenGlPose(frame), fx));
      WriteColor(folder_ / ("keyframes/corrected_images/" + Name(i) + ".jpg"), frame.color,
                 {cv::IMWRITE_JPEG_QUALITY, 95});
    }
    folder_.Write("mesh_info.json", "{}");
  }
  std::unique_ptr<FrameSource> Open() const { return OpenSequence(Options(folder_)); }

  TempFolder folder_;
};

TEST_F(Polycam, IsTrackedToTheCorrectedPoses) {
  Write(/*corrected=*/true);
  const auto source = Open();
  const SequenceInfo& info = source->info();
  EXPECT_EQ(info.format, "polycam");
  EXPECT_THAT(info.warnings, IsEmpty());
  EXPECT_THAT(info.camera_from, HasSubstr("corrected_cameras"));
  EXPECT_NEAR(info.camera.color.fx, 250, 1);
  EXPECT_FALSE(info.camera.color_is_registered);
  EXPECT_TRUE(info.ground_truth.empty());
  EXPECT_THAT(info.assumed, HasSubstr("confidence 0 to 255"));
  EXPECT_NEAR(source->Next()->stamp_s, Frames()[0].stamp_s, 1e-5);
  const double error_m = ErrorOf(TrackPhone(Options(folder_)), kFrames);
  std::printf("ATE %.5f m\n", error_m);
  EXPECT_LT(error_m, 0.0014);
}

TEST_F(Polycam, UsesTheOtherPosesWithoutCorrectedOnes) {
  Write(/*corrected=*/false);
  EXPECT_LT(ErrorOf(TrackPhone(Options(folder_)), kFrames), 0.0014);
}

// Also a folder keyframes/ itself is a recording.
TEST_F(Polycam, ReportsFramesWithoutAllFiles) {
  Write(/*corrected=*/true);
  for (const std::string& name :
       {"cameras/" + Name(2) + ".json", "corrected_cameras/" + Name(2) + ".json",
        "corrected_images/" + Name(5) + ".jpg", "depth/" + Name(7) + ".png",
        "depth/" + Name(8) + ".png", "confidence/" + Name(9) + ".png"})
    ASSERT_TRUE(std::filesystem::remove(folder_ / ("keyframes/" + name))) << name;
  const auto source = OpenSequence(OptionsOf(folder_ / "keyframes"));
  EXPECT_THAT(source->info().warnings,
              ElementsAre(Names("depth", 1, "cameras"), Names("cameras", 2, "depth"),
                          Names("corrected_cameras", 1), Names("confidence", 1)));
  EXPECT_EQ(source->info().frame_count, kFrames - 3);
}

TEST_F(Polycam, RejectsWrongMetadata) {
  Write(/*corrected=*/false);
  const std::string path = "keyframes/cameras/" + Name(3) + ".json";
  const SimulatedFrame& frame = Frames()[3];
  const auto expect = [&](const std::string& fx, const std::string& message) {
    folder_.Write(path, CameraText(frame, OpenGlPose(frame), fx));
    ExpectInputError([&] { Open(); },
                     ::testing::AllOf(HasSubstr(Name(3) + ".json"), HasSubstr(message)));
  };
  expect("\"wide\"", "fx is \"wide\", must be a number");
  expect("-250", "fx is -250");
  expect("250, \"timestamp\": true", "timestamp is true, must be a number");
  SimulatedFrame shifted = frame;
  shifted.color_camera.cx = 12;
  folder_.Write(path, CameraText(shifted, OpenGlPose(frame), "250"));
  ExpectInputError([&] { Open(); }, Names(Name(3) + ".json", "cx", 12, 96, 224));
  folder_.Write(path, "{\"fx\": 250}");
  ExpectInputError([&] { Open(); }, Names(Name(3) + ".json", "width"));
  folder_.Write(path, "{\"fx\": 250");
  ExpectInputError([&] { Open(); }, Names(Name(3) + ".json"));
}

}  // namespace
}  // namespace surfit::testing
