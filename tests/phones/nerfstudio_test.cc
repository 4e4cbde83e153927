// Folders of nerfstudio whose frames have intrinsics of their own.
#include <nlohmann/json.hpp>

#include "phones/simulated_phone.h"
#include "testing/matchers.h"

namespace surfit::testing {
namespace {

class Nerfstudio : public PhoneTest {
 protected:
  // `scale`: applied_scale of the positions.
  static nlohmann::json Transforms(bool with_depth, double scale = 1) {
    nlohmann::json frames;
    for (int i = 0; i < kFrames; ++i) {
      const PinholeCamera& c = Frames()[i].color_camera;
      Eigen::Matrix4d matrix = OpenGlPose(Frames()[i]).Matrix();
      matrix.block<3, 1>(0, 3) *= scale;
      nlohmann::json frame = {{"file_path", Format("./images/frame_%05d.png", i + 1)},
                              {"w", 320},
                              {"h", 240},
                              {"fl_x", c.fx},
                              {"fl_y", c.fy},
                              {"cx", c.cx},
                              {"cy", c.cy}};
      if (with_depth) frame["depth_file_path"] = Format("./depth/frame_%05d.png", i + 1);
      for (int k = 0; k < 16; ++k) frame["transform_matrix"][k / 4].push_back(matrix(k / 4, k % 4));
      frames.push_back(frame);
    }
    return {{"camera_model", "OPENCV"}, {"applied_scale", scale}, {"frames", frames}};
  }

  void Write(const nlohmann::json& transforms) const {
    for (int i = 0; i < kFrames; ++i) {
      WriteDepth(folder_ / Format("depth/frame_%05d.png", i + 1), Millimetres(Frames()[i].depth_m));
      WriteColor(folder_ / Format("images/frame_%05d.png", i + 1), Frames()[i].color);
      WriteConfidence(folder_ / Format("confidence/frame_%05d.png", i + 1), Frames()[i].confidence);
    }
    folder_.Write("transforms.json", transforms.dump());
  }
};

TEST_F(Nerfstudio, UsesTheIntrinsicsOfEachFrame) {
  Write(Transforms(/*with_depth=*/true, 0.25));
  const auto source = Open();
  EXPECT_EQ(source->info().format, "nerfstudio");
  EXPECT_THAT(source->info().warnings, IsEmpty());
  EXPECT_THAT(source->info().camera_from, Names("transforms.json", "median"));
  EXPECT_TRUE(source->info().ground_truth.empty());
  EXPECT_LT(TrackingError(Options(folder_)), 0.0014);
}

TEST_F(Nerfstudio, FindsTheFramesOfDepthImagesThatAreNotListed) {
  Write(Transforms(/*with_depth=*/false));
  EXPECT_LT(ErrorOf(TrackPhone(Options(folder_)), kFrames), 0.0014);
}

TEST_F(Nerfstudio, RejectsWrongMetadata) {
  Write(Transforms(true));
  const auto expect = [&](const std::string& pointer, const nlohmann::json& value,
                          const std::string& message) {
    nlohmann::json transforms = Transforms(true);
    transforms[nlohmann::json::json_pointer(pointer)] = value;
    folder_.Write("transforms.json", transforms.dump());
    ExpectInputError([&] { Open(); },
                     ::testing::AllOf(HasSubstr("transforms.json"), HasSubstr(message)));
  };
  expect("/frames/39/w", "wide", "w is \"wide\", must be a number");
  expect("/frames/39/h", 99999, "h is 99999, must be an integer from 1 to 16384");
  expect("/frames/39/fl_x", -250, "fx is -250");
  expect("/applied_scale", 0, "applied_scale is 0, must be positive");
  expect("/frames/39/transform_matrix/0", {1, 0}, "has 2 numbers, must have 4");
}

// A camera file takes precedence, also if the lens of the recording cannot be used.
TEST_F(Nerfstudio, ReadsTheCameraFileInsteadOfAFisheyeLens) {
  nlohmann::json transforms = Transforms(true);
  transforms["camera_model"] = "OPENCV_FISHEYE";
  Write(transforms);
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
