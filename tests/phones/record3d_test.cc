// The export "EXR + JPG sequence" of Record3D.
#include <nlohmann/json.hpp>

#include "phones/simulated_phone.h"
#include "testing/exr_writer.h"
#include "testing/matchers.h"

namespace surfit::testing {
namespace {

class Record3d : public PhoneTest {
 protected:
  static nlohmann::json Metadata(const std::vector<double>& k, bool is_new = true,
                                 std::size_t stamp_count = kFrames) {
    nlohmann::json json = {{"w", 320}, {"h", 240}, {"fps", 30}, {"K", k}};
    json["initPose"] = {0, 0, 0, 1, 0, 0, 0};
    for (const SimulatedFrame& frame : Frames()) {
      const Rigid3d pose = OpenGlPose(frame);
      const Eigen::Vector4d q = pose.rotation.coeffs();
      const Eigen::Vector3d t = pose.translation;
      json["poses"].push_back({q[0], q[1], q[2], q[3], t[0], t[1], t[2]});
      if (!is_new) continue;
      const PinholeCamera& c = frame.color_camera;
      json["perFrameIntrinsicCoeffs"].push_back({c.fx, c.fy, c.cx, c.cy});
      if (json["frameTimestamps"].size() < stamp_count)
        json["frameTimestamps"].push_back(frame.stamp_s);
    }
    return json;
  }
  static std::vector<double> RightK() { return {250, 0, 0, 0, 250, 0, 158.5, 121.5, 1}; }

  // Depth of low confidence is missing in this export, as NaN.
  void Write(const nlohmann::json& metadata) const {
    for (int i = 0; i < kFrames; ++i) {
      Image<float> depth_m = Frames()[i].depth_m;
      for (std::size_t k = 0; k < depth_m.size(); ++k)
        if (Frames()[i].confidence[k] == 0) depth_m[k] = NAN;
      folder_.Write(Format("EXR_RGBD/depth/%d.exr", i), ExrFile(depth_m));
      WriteColor(folder_ / Format("EXR_RGBD/rgb/%d.jpg", i), Frames()[i].color,
                 {cv::IMWRITE_JPEG_QUALITY, 95});
    }
    folder_.Write("EXR_RGBD/metadata.json", metadata.dump());
  }
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
  EXPECT_LT(TrackingError(OptionsOf(folder_ / "EXR_RGBD")), 0.0014);
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
  Write({});
  const auto expect = [&](const nlohmann::json& metadata, const std::string& message) {
    folder_.Write("EXR_RGBD/metadata.json", metadata.dump());
    ExpectInputError([&] { Open(); },
                     ::testing::AllOf(HasSubstr("metadata.json"), HasSubstr(message)));
  };
  expect(nlohmann::json::object(), "w is missing, must be a number");
  expect({{"w", 0.5}, {"h", 240}}, "w is 0.5, must be an integer from 1 to 16384");
  expect({{"w", 320}, {"h", 240}}, "K is missing, must be 9 numbers");
  expect(Metadata({1, 2}), "K has 2 numbers, must have 9");
  expect(Metadata({250, 0, 158.5, 0, 250, 121.5, 0, 0, 1}), "K[2] is 158.5, must be 0");
  expect(Metadata({250, 0, 0, 0, 250, 0, 900, 121.5, 1}), "cx is 900");
  nlohmann::json wrong = {{"w", 320}, {"h", 240}, {"fps", 0}, {"K", RightK()}};
  expect(wrong, "fps is 0, must be positive");
  wrong["fps"] = 30;
  wrong["perFrameIntrinsicCoeffs"][0] = {250, 250, 158};
  expect(wrong, "perFrameIntrinsicCoeffs[0] has 3 numbers, must have 4");
  expect({{"w", 320}, {"h", 320}, {"fps", 30}, {"K", {250, 0, 0, 0, 250, 0, 158, 158, 1}}},
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
