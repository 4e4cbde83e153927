// The export "EXR + JPG sequence" of Record3D.
#include "phones/simulated_phone.h"
#include "testing/exr_writer.h"
#include "testing/matchers.h"

namespace surfit::testing {
namespace {

std::string List(const std::vector<std::string>& items) {
  std::string text = "[";
  for (const std::string& item : items) text += (text.size() > 1 ? ", " : "") + item;
  return text + "]";
}

std::string Numbers(const std::vector<double>& numbers) {
  std::vector<std::string> items;
  for (const double number : numbers) items.push_back(Number(number));
  return List(items);
}

class Record3d : public ::testing::Test {
 protected:
  static const std::vector<SimulatedFrame>& Frames() {
    static const auto* const frames = new auto(RecordWithPhone(kFrames));
    return *frames;
  }
  static std::string Metadata(const std::string& k, bool is_new = true,
                              std::size_t stamp_count = kFrames) {
    std::vector<std::string> poses, lenses, stamps;
    for (const SimulatedFrame& frame : Frames()) {
      const Rigid3d pose = OpenGlPose(frame);
      const Eigen::Vector4d q = pose.rotation.coeffs();
      const Eigen::Vector3d t = pose.translation;
      poses.push_back(Numbers({q[0], q[1], q[2], q[3], t[0], t[1], t[2]}));
      const PinholeCamera& c = frame.color_camera;
      lenses.push_back(Numbers({c.fx, c.fy, c.cx, c.cy}));
      if (stamps.size() < stamp_count) stamps.push_back(Number(frame.stamp_s));
    }
    std::string text = "{\"w\": 320, \"h\": 240, \"fps\": 30, \"K\": " + k +
                       ", \"poses\": " + List(poses) + ", \"initPose\": [0, 0, 0, 1, 0, 0, 0]";
    if (is_new)
      text += ", \"perFrameIntrinsicCoeffs\": " + List(lenses) +
              ", \"frameTimestamps\": " + List(stamps);
    return text + "}";
  }
  static std::string RightK() { return "[250, 0, 0, 0, 250, 0, 158.5, 121.5, 1]"; }

  // Depth of low confidence is missing in this export, as NaN.
  void Write(const std::string& metadata) const {
    for (int i = 0; i < kFrames; ++i) {
      Image<float> depth_m = Frames()[i].depth_m;
      for (std::size_t k = 0; k < depth_m.size(); ++k)
        if (Frames()[i].confidence[k] == 0) depth_m[k] = NAN;
      folder_.Write(Format("EXR_RGBD/depth/%d.exr", i), ExrFile(depth_m));
      WriteColor(folder_ / Format("EXR_RGBD/rgb/%d.jpg", i), Frames()[i].color,
                 {cv::IMWRITE_JPEG_QUALITY, 95});
    }
    folder_.Write("EXR_RGBD/metadata.json", metadata);
  }
  std::unique_ptr<FrameSource> Open() const { return OpenSequence(Options(folder_)); }

  TempFolder folder_;
};

TEST_F(Record3d, IsTrackedToThePosesOfThePhone) {
  Write(Metadata(RightK()));
  const auto source = Open();
  const SequenceInfo& info = source->info();
  EXPECT_EQ(info.format, "record3d");
  EXPECT_THAT(info.warnings, IsEmpty());
  EXPECT_TRUE(info.has_clock);
  EXPECT_NEAR(info.camera.color.fx, 250, 1);
  EXPECT_NEAR(info.camera.depth.cx, 78.75, 0.5);
  EXPECT_TRUE(info.ground_truth.empty());
  EXPECT_NEAR(source->Next()->stamp_s, Frames()[0].stamp_s, 1e-6);
  const double error_m = ErrorOf(TrackPhone(OptionsOf(folder_ / "EXR_RGBD")), kFrames);
  std::printf("ATE %.5f m\n", error_m);
  EXPECT_LT(error_m, 0.0014);
}

TEST_F(Record3d, OlderVersionsHaveOneCameraAndNoTimes) {
  Write(Metadata(RightK(), /*is_new=*/false));
  const auto source = Open();
  EXPECT_FALSE(source->info().has_clock);
  EXPECT_EQ(source->info().camera.color.fx, 250);
  const auto results = ReadAll(source.get());
  EXPECT_NEAR(results[30].stamp_s, 1, 1e-9);
}

TEST_F(Record3d, ReportsNumbersWithoutAllFiles) {
  Write(Metadata(RightK(), /*is_new=*/true, kFrames - 2));
  for (const char* name : {"depth/3.exr", "rgb/6.jpg"})
    std::filesystem::remove(folder_ / (std::string("EXR_RGBD/") + name));
  const auto source = Open();
  EXPECT_THAT(source->info().warnings,
              ElementsAre(Names("rgb", 1), Names("depth", 1, "rgb"), Names("frameTimestamps", 2)));
  const auto results = ReadAll(source.get());
  ASSERT_EQ(results.size(), kFrames - 3u);
  EXPECT_NEAR(results[3].stamp_s, Frames()[4].stamp_s, 1e-6);
  EXPECT_TRUE(results[5].frame->color.empty());
}

TEST_F(Record3d, RejectsWrongMetadata) {
  Write("{}");
  const auto expect = [&](const std::string& metadata, const std::string& message) {
    folder_.Write("EXR_RGBD/metadata.json", metadata);
    ExpectInputError([&] { Open(); },
                     ::testing::AllOf(HasSubstr("metadata.json"), HasSubstr(message)));
  };
  expect("{}", "w is missing, must be a number");
  expect("{\"w\": 0.5, \"h\": 240}", "w is 0.5, must be an integer from 1 to 16384");
  expect("{\"w\": 320, \"h\": 240}", "K is missing, must be 9 numbers");
  expect(Metadata("[1, 2]"), "K has 2 numbers, must have 9");
  expect(Metadata("[250, 0, 158.5, 0, 250, 121.5, 0, 0, 1]"), "K[2] is 158.5, must be 0");
  expect(Metadata("[250, 0, 0, 0, 250, 0, 900, 121.5, 1]"), "cx is 900");
  expect("{\"w\": 320, \"h\": 240, \"fps\": 0, \"K\": " + RightK() + "}",
         "fps is 0, must be positive");
  expect("{\"w\": 320, \"h\": 240, \"fps\": 30, \"K\": " + RightK() +
             ", \"perFrameIntrinsicCoeffs\": [[250, 250, 158]]}",
         "perFrameIntrinsicCoeffs[0] has 3 numbers, must have 4");
  expect("{\"w\": 320, \"h\": 320, \"fps\": 30, \"K\": [250, 0, 0, 0, 250, 0, 158, 158, 1]}",
         "must have the aspect ratio");
}

// No library of Debian decompresses LZFSE.
TEST(Record3dFile, NamesTheExportThatCanBeRead) {
  TempFolder folder;
  const std::string file = folder.Write("video.r3d", "PK");
  ExpectInputError([&] { OpenSequence(OptionsOf(file)); },
                   Names("video.r3d", "LZFSE", "EXR + JPG"));
  folder.Write("metadata", "{}");
  folder.Write("rgbd/0.depth", "bvx2");
  ExpectInputError([&] { OpenSequence(Options(folder)); }, Names("rgbd", "LZFSE", "EXR + JPG"));
}

}  // namespace
}  // namespace surfit::testing
