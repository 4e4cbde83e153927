// Recordings in the layout of ARKitScenes: one file per image, camera and time.
#include "phones/simulated_phone.h"
#include "testing/matchers.h"

namespace surfit::testing {
namespace {

std::string TimedName(double stamp_s, const std::string& ending) {
  char text[40];
  std::snprintf(text, sizeof(text), "42446103_%.3f", stamp_s);
  return text + ending;
}

std::string PincamText(const PinholeCamera& c) {
  return Number(c.width) + " " + Number(c.height) + " " + Number(c.fx) + " " + Number(c.fy) + " " +
         Number(c.cx) + " " + Number(c.cy);
}

class ArkitScenes : public PhoneTest {
 protected:
  // Colour has the size of depth in this data set. Poses exist for every third frame.
  void Write() const {
    std::string traj;
    for (int i = 0; i < kFrames; ++i) {
      const SimulatedFrame& frame = Frames()[i];
      const std::string name = TimedName(frame.stamp_s, ".png");
      WriteDepth(folder_ / ("lowres_depth/" + name), Millimetres(frame.depth_m));
      WriteConfidence(folder_ / ("confidence/" + name), frame.confidence);
      Image<Rgb8> color(frame.depth_camera.width, frame.depth_camera.height);
      for (const auto [u, v] : PixelsOf(color)) color(u, v) = frame.color(2 * u, 2 * v);
      WriteColor(folder_ / ("lowres_wide/" + name), color);
      // Times of cameras are rounded in another way.
      folder_.Write("lowres_wide_intrinsics/" +
                        TimedName(frame.stamp_s + (i % 2 == 0 ? 0.001 : 0), ".pincam"),
                    PincamText(frame.depth_camera) + "\n");
      if (i % 3 != 0) continue;
      const Rigid3d camera_from_world = frame.world_from_camera.Inverse();
      const Eigen::AngleAxisd turn(camera_from_world.rotation);
      const Eigen::Vector3d vector = turn.angle() * turn.axis();
      traj += Number(frame.stamp_s);
      for (int k = 0; k < 3; ++k) traj += " " + Number(vector[k]);
      for (int k = 0; k < 3; ++k) traj += " " + Number(camera_from_world.translation[k]);
      traj += "\n";
    }
    folder_.Write("lowres_wide.traj", traj);
  }
};

TEST_F(ArkitScenes, IsTrackedToThePosesOfThePhone) {
  Write();
  const auto source = Open();
  const SequenceInfo& info = source->info();
  EXPECT_EQ(info.format, "arkit_scenes");
  EXPECT_TRUE(info.has_clock);
  EXPECT_TRUE(info.camera.color_is_registered);
  EXPECT_NEAR(info.camera.depth.fx, 125, 0.5);
  EXPECT_GT(info.low_confidence_ratio.value(), 0.05);
  EXPECT_THAT(info.warnings, IsEmpty());
  EXPECT_TRUE(info.ground_truth.empty());
  EXPECT_NEAR(source->Next()->stamp_s, Frames()[0].stamp_s, 6e-4);
  const SlamRunSummary summary = TrackPhone(Options(folder_));
  EXPECT_EQ(summary.frames_tracked, kFrames);
  const double error_m = summary.evaluation->ate->translation_m.rmse;
  std::printf("ATE %.5f m\n", error_m);
  EXPECT_LT(error_m, 0.002);  // poses between those of the phone are interpolated
}

// Colour, confidence and intrinsics of a frame are those of its own time.
TEST_F(ArkitScenes, ReportsTimesWithoutAllFiles) {
  Write();
  const auto remove = [&](const char* folder, int frame, double shift_s = 0) {
    const bool is_lens = std::string(folder) == "lowres_wide_intrinsics";
    const std::string name =
        TimedName(Frames()[frame].stamp_s + shift_s, is_lens ? ".pincam" : ".png");
    ASSERT_TRUE(std::filesystem::remove(folder_ / (std::string(folder) + "/" + name)));
  };
  remove("lowres_wide", 4);
  remove("lowres_depth", 9);
  remove("lowres_wide_intrinsics", 11);
  remove("confidence", 12);
  const auto source = Open();
  EXPECT_THAT(
      source->info().warnings,
      ElementsAre(Names("lowres_depth", 1, "lowres_wide"), Names("lowres_wide", 1),
                  Names("lowres_depth", 1, "lowres_wide_intrinsics"), Names("confidence", 1)));
  const auto results = ReadAll(source.get());
  ASSERT_EQ(results.size(), kFrames - 1u);
  EXPECT_TRUE(results[4].frame->color.empty());
  EXPECT_FALSE(results[5].frame->color.empty());
  EXPECT_NEAR(results[9].stamp_s, Frames()[10].stamp_s, 6e-4);
}

TEST_F(ArkitScenes, RejectsWrongMetadata) {
  Write();
  const std::string pincam = "lowres_wide_intrinsics/" + TimedName(Frames()[1].stamp_s, ".pincam");
  const auto expect = [&](const std::string& text, const std::string& message) {
    folder_.Write(pincam, text);
    ExpectInputError([&] { Open(); }, ::testing::AllOf(HasSubstr(".pincam"), HasSubstr(message)));
  };
  expect("160 120 125 125 79\n", "5 columns, must have 6");
  expect("160 120 125 125 79 sixty\n", "cy");
  expect("160 120 125 125 160 60\n", "cx is 160, must be near the centre");
  expect("0 120 125 125 79 60\n", "width is 0, must be 1 to 16384");
  expect("320 240 250 250 158 121\n", "320 x 240");
  expect("160 120 -125 125 79 60\n", "fx is -125");
  folder_.Write(pincam, PincamText(Frames()[1].depth_camera));
  folder_.Write("lowres_wide.traj", "8123.4 0 0 0 1 2\n");
  ExpectInputError([&] { Open(); }, Names("lowres_wide.traj", 7));
}

TEST_F(ArkitScenes, NeedsIntrinsics) {
  Write();
  std::filesystem::remove_all(folder_ / "lowres_wide_intrinsics");
  ExpectInputError([&] { Open(); }, Names("lowres_wide_intrinsics"));
}

}  // namespace
}  // namespace surfit::testing
