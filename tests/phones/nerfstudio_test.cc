// Folders of nerfstudio whose frames have intrinsics of their own.
#include "phones/simulated_phone.h"
#include "testing/matchers.h"

namespace surfit::testing {
namespace {

class Nerfstudio : public ::testing::Test {
 protected:
  static const std::vector<SimulatedFrame>& Frames() {
    static const auto* const frames = new auto(RecordWithPhone(kFrames));
    return *frames;
  }
  // `scale`: applied_scale of the positions.
  static std::string Transforms(bool with_depth, double scale = 1) {
    std::string frames;
    for (int i = 0; i < kFrames; ++i) {
      const PinholeCamera& c = Frames()[i].color_camera;
      frames += (i == 0 ? "{" : ", {") + std::string("\"file_path\": \"./images/frame_") +
                Format("%05d.png\"", i + 1);
      if (with_depth)
        frames +=
            std::string(", \"depth_file_path\": \"./depth/frame_") + Format("%05d.png\"", i + 1);
      frames += ", \"w\": 320, \"h\": 240, \"fl_x\": " + Number(c.fx) +
                ", \"fl_y\": " + Number(c.fy) + ", \"cx\": " + Number(c.cx) +
                ", \"cy\": " + Number(c.cy) + ", \"transform_matrix\": [";
      Eigen::Matrix4d matrix = OpenGlPose(Frames()[i]).Matrix();
      matrix.block<3, 1>(0, 3) *= scale;
      for (int row = 0; row < 4; ++row) {
        frames += row == 0 ? "[" : ", [";
        for (int k = 0; k < 4; ++k) frames += (k == 0 ? "" : ", ") + Number(matrix(row, k));
        frames += "]";
      }
      frames += "]}";
    }
    return "{\"camera_model\": \"OPENCV\", \"applied_scale\": " + Number(scale) +
           ", \"frames\": [" + frames + "]}";
  }

  void Write(const std::string& transforms) const {
    for (int i = 0; i < kFrames; ++i) {
      WriteDepth(folder_ / Format("depth/frame_%05d.png", i + 1), Millimetres(Frames()[i].depth_m));
      WriteColor(folder_ / Format("images/frame_%05d.png", i + 1), Frames()[i].color);
      WriteConfidence(folder_ / Format("confidence/frame_%05d.png", i + 1), Frames()[i].confidence);
    }
    folder_.Write("transforms.json", transforms);
  }
  std::unique_ptr<FrameSource> Open() const { return OpenSequence(Options(folder_)); }

  TempFolder folder_;
};

TEST_F(Nerfstudio, UsesTheIntrinsicsOfEachFrame) {
  Write(Transforms(/*with_depth=*/true, 0.25));
  const auto source = Open();
  EXPECT_EQ(source->info().format, "nerfstudio");
  EXPECT_THAT(source->info().warnings, IsEmpty());
  EXPECT_THAT(source->info().camera_from, Names("transforms.json", "median"));
  EXPECT_TRUE(source->info().ground_truth.empty());
  const double error_m = ErrorOf(TrackPhone(Options(folder_)), kFrames);
  std::printf("ATE %.5f m\n", error_m);
  EXPECT_LT(error_m, 0.0014);
}

TEST_F(Nerfstudio, FindsTheFramesOfDepthImagesThatAreNotListed) {
  Write(Transforms(/*with_depth=*/false));
  EXPECT_LT(ErrorOf(TrackPhone(Options(folder_)), kFrames), 0.0014);
}

TEST_F(Nerfstudio, RejectsWrongMetadata) {
  Write(Transforms(true));
  const auto expect = [&](const std::string& from, const std::string& to,
                          const std::string& message) {
    std::string text = Transforms(true);
    const std::size_t at = text.rfind(from);
    text.replace(at, from.size(), to);
    folder_.Write("transforms.json", text);
    ExpectInputError([&] { Open(); },
                     ::testing::AllOf(HasSubstr("transforms.json"), HasSubstr(message)));
  };
  expect("\"w\": 320", "\"w\": \"wide\"", "w is \"wide\", must be a number");
  expect("\"h\": 240", "\"h\": 99999", "h is 99999, must be an integer from 1 to 16384");
  expect("\"fl_x\": ", "\"fl_x\": -", "fx is -");
  expect("\"applied_scale\": 1", "\"applied_scale\": 0", "applied_scale is 0, must be positive");
  expect("\"transform_matrix\": [", "\"transform_matrix\": [[1, 0], ",
         "has 2 numbers, must have 4");
}

// A camera file takes precedence, also if the lens of the recording cannot be used.
TEST_F(Nerfstudio, ReadsTheCameraFileInsteadOfAFisheyeLens) {
  std::string text = Transforms(true);
  text.replace(text.find("OPENCV"), 6, "OPENCV_FISHEYE");
  Write(text);
  ExpectInputError([&] { Open(); }, Names("transforms.json", "OPENCV_FISHEYE"));
  folder_.Write("camera.yaml",
                "%YAML:1.0\n---\ndepth_camera: { width: 160, height: 120, fx: 125., fy: 125., cx: "
                "79., cy: 60.5 }\ncolor_camera: { width: 320, height: 240, fx: 250., fy: 250., cx: "
                "158.5, cy: 121.5 }\ndepth_units_per_metre: 1000.\nframes_per_second: 15.\n");
  const auto results = ReadAll(Open().get());
  ASSERT_EQ(results.size(), static_cast<std::size_t>(kFrames));
  EXPECT_TRUE(results[0].frame) << results[0].error;
  EXPECT_NEAR(results[15].stamp_s, 1, 1e-9);
}

}  // namespace
}  // namespace surfit::testing
