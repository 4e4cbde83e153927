// Raw recordings of Polycam: one camera file per frame.
#include <nlohmann/json.hpp>

#include "phones/simulated_phone.h"
#include "testing/matchers.h"

namespace surfit::testing {
namespace {

class Polycam : public PhoneTest {
 protected:
  static std::string Name(int i) { return std::to_string(std::llround(1e6 * Frames()[i].stamp_s)); }
  static nlohmann::json CameraOf(const SimulatedFrame& frame, const Rigid3d& pose) {
    const PinholeCamera& c = frame.color_camera;
    nlohmann::json json = {{"fx", c.fx},   {"fy", c.fy},    {"cx", c.cx},        {"cy", c.cy},
                           {"width", 320}, {"height", 240}, {"blur_score", 31.2}};
    for (int k = 0; k < 12; ++k)
      json[Format("t_%d", k / 4) + std::to_string(k % 4)] = pose.Matrix()(k / 4, k % 4);
    return json;
  }

  // The corrected poses are right. The other poses drift.
  void Write(bool corrected) const {
    for (int i = 0; i < kFrames; ++i) {
      const SimulatedFrame& frame = Frames()[i];
      WriteDepth(folder_ / ("keyframes/depth/" + Name(i) + ".png"), Millimetres(frame.depth_m));
      Image<std::uint8_t> confidence = frame.confidence;
      for (auto& value : confidence) value = value == 2 ? 255 : 127 * value;
      WriteConfidence(folder_ / ("keyframes/confidence/" + Name(i) + ".png"), confidence);
      Rigid3d drifted = OpenGlPose(frame);
      if (corrected) drifted.translation.x() += 0.01 * i;
      folder_.Write("keyframes/cameras/" + Name(i) + ".json", CameraOf(frame, drifted).dump());
      WriteColor(folder_ / ("keyframes/images/" + Name(i) + ".jpg"), frame.color,
                 {cv::IMWRITE_JPEG_QUALITY, 95});
      if (!corrected) continue;
      folder_.Write("keyframes/corrected_cameras/" + Name(i) + ".json",
                    CameraOf(frame, OpenGlPose(frame)).dump());
      WriteColor(folder_ / ("keyframes/corrected_images/" + Name(i) + ".jpg"), frame.color,
                 {cv::IMWRITE_JPEG_QUALITY, 95});
    }
    folder_.Write("mesh_info.json", "{}");
  }
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
  EXPECT_LT(TrackingError(Options(folder_)), 0.0014);
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
  const nlohmann::json right = CameraOf(Frames()[3], OpenGlPose(Frames()[3]));
  const auto expect = [&](const char* key, const nlohmann::json& value,
                          const std::string& message) {
    nlohmann::json camera = right;
    camera[key] = value;
    folder_.Write(path, camera.dump());
    ExpectInputError([&] { Open(); },
                     ::testing::AllOf(HasSubstr(Name(3) + ".json"), HasSubstr(message)));
  };
  expect("fx", "wide", "fx is \"wide\", must be a number");
  expect("fx", -250, "fx is -250");
  expect("timestamp", true, "timestamp is true, must be a number");
  nlohmann::json shifted = right;
  shifted["cx"] = 12;
  folder_.Write(path, shifted.dump());
  ExpectInputError([&] { Open(); }, Names(Name(3) + ".json", "cx", 12, 96, 224));
  folder_.Write(path, "{\"fx\": 250}");
  ExpectInputError([&] { Open(); }, Names(Name(3) + ".json", "width"));
  folder_.Write(path, "{\"fx\": 250");
  ExpectInputError([&] { Open(); }, Names(Name(3) + ".json"));
}

}  // namespace
}  // namespace surfit::testing
