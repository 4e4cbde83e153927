#include <cmath>

#include "io/bag_fixture.h"

namespace surfit::testing {
namespace {

TEST_F(BagTest, RejectsBagWithoutCalibration) {
  AddDepth();
  AddColor("/camera/rgb/image_raw", "rgb_frame");
  ExpectError(Names("CameraInfo", "/camera/depth/image_raw", "intrinsics"));
  AddInfo("/camera/depth/camera_info");
  ExpectError(Names("CameraInfo", "/camera/rgb/image_raw", "color_intrinsics"));
  AddInfo("/camera/rgb/camera_info", "rgb_frame");
  ExpectError(Names("tf", "/camera/rgb/image_raw", "rgb_frame", "/camera/depth/image_raw",
                    "camera_optical_frame", "color_from_depth"));
  options_.color_from_depth = Rigid3d(Eigen::Quaterniond::Identity(), {0.1, 0, 0});
  EXPECT_EQ(Open()->info().camera.color_from_depth.translation.x(), 0.1);
}

TEST_F(BagTest, ReadsColorExtrinsicsFromTf) {
  AddDepth(kDepth, "/depth_frame");
  AddColor(kColor, "rgb_frame");
  AddInfo("/camera/depth/camera_info", "/depth_frame");
  RosCameraInfo color;
  color.k = {40, 41, 16, 12};
  AddInfo("/camera/rgb/camera_info", "rgb_frame", color);
  const Rigid3d base_from_depth(Eigen::Quaterniond(0.8, 0.6, 0, 0), {1, 2, 3});
  const Rigid3d base_from_link(Eigen::Quaterniond(0.6, 0, 0.8, 0), {0, 0.5, 0});
  const Rigid3d link_from_color(Eigen::Quaterniond(0, 0, 0.6, 0.8), {0.1, 0.2, 0.3});
  bag_.Add("/tf", "tf2_msgs/TFMessage", 1, RosTransform("base", "depth_frame", base_from_depth));
  bag_.Add("/tf_static", "tf2_msgs/TFMessage", 1, RosTransform("/base", "link", base_from_link));
  bag_.Add("/tf_static", "tf2_msgs/TFMessage", 1,
           RosTransform("link", "rgb_frame", link_from_color));
  const RgbdCamera camera = Open()->info().camera;
  EXPECT_FALSE(camera.color_is_registered);
  EXPECT_EQ(camera.color.fx, 40);
  const Rigid3d expected = (base_from_link * link_from_color).Inverse() * base_from_depth;
  EXPECT_TRUE(camera.color_from_depth.Matrix().isApprox(expected.Matrix(), 1e-12));
}

TEST_F(BagTest, ReadsTheLensOfRawImagesAndTheProjectionOfRectifiedOnes) {
  RosCameraInfo info;
  info.distortion = {0.1, -0.2, 0.001, 0.002, 0.05};
  AddDepth();
  AddInfo("/camera/depth/camera_info", kOptical, info);
  PinholeCamera camera = Open()->info().camera.depth;
  EXPECT_EQ(camera.fx, 31);
  EXPECT_THAT(camera.distortion, ::testing::ElementsAreArray(info.distortion));
  bag_ = {};
  AddDepth("/camera/depth/image_rect");
  AddInfo("/camera/depth/camera_info", kOptical, info);
  camera = Open()->info().camera.depth;
  EXPECT_EQ(camera.fx, 29);
  EXPECT_EQ(camera.fy, 28);
  EXPECT_EQ(camera.cx, 15);
  EXPECT_EQ(camera.cy, 11);
  EXPECT_FALSE(camera.HasDistortion());
  bag_ = {};
  AddDepth();
  info.model = "ftheta";
  AddInfo("/camera/depth/camera_info", kOptical, info);
  ExpectError(Names("/camera/depth/camera_info", "ftheta"));
}

TEST_F(BagTest, UsesIntrinsicsOfOptionsForALensOfAnotherModel) {
  RosCameraInfo info;
  info.distortion = {0.1, -0.2, 0.001, 0.002};
  info.model = "ftheta";
  AddDepth();
  AddInfo("/camera/depth/camera_info", kOptical, info);
  options_.intrinsics = {33, 34, 15, 12};
  const SequenceInfo opened = Open()->info();
  EXPECT_EQ(opened.camera.depth.fx, 33);
  EXPECT_FALSE(opened.camera.depth.HasDistortion());
  EXPECT_THAT(opened.camera_from, Names("ftheta"));
}

// Colour and depth have one CameraInfo. The given intrinsics belong to images without this lens.
TEST_F(BagTest, UsesIntrinsicsOfOptionsForFisheyeLensesOfRegisteredColor) {
  RosCameraInfo info;
  info.model = "equidistant";
  for (const auto& numbers :
       {std::vector<double>{-0.02, 0.006, -0.002, 0.0003}, std::vector<double>{0.1, 0.1}}) {
    info.distortion = numbers;
    bag_ = {};
    AddDepth("/camera/color/depth_aligned");
    AddColor("/camera/color/image_raw");
    AddInfo("/camera/color/camera_info", kOptical, info);
    options_.intrinsics.reset();
    if (numbers.size() != 4) ExpectError(Names("/camera/color/camera_info", "equidistant"));
    options_.intrinsics = {33, 34, 15, 12};
    const SequenceInfo opened = Open()->info();
    EXPECT_TRUE(opened.camera.color_is_registered);
    EXPECT_EQ(opened.camera.depth.fx, 33);
    EXPECT_FALSE(opened.camera.depth.HasDistortion());
    EXPECT_THAT(opened.camera_from, Names("equidistant"));
  }
}

TEST_F(BagTest, NamesTheOptionOfAColorCameraWithABadLens) {
  AddDepth();
  AddInfo("/camera/depth/camera_info");
  RosCameraInfo info;
  info.model = "equidistant";
  info.distortion = {0.1, 0.1};
  AddColor(kColor, "rgb_frame");
  AddInfo("/camera/rgb/camera_info", "rgb_frame", info);
  options_.color_from_depth = Rigid3d();
  ExpectError(Names("/camera/rgb/camera_info", "color_intrinsics"));
  options_.color_intrinsics = {33, 34, 15, 12};
  EXPECT_EQ(Open()->info().camera.color.fx, 33);
}

// The lens is compared with its model in lens_fit_test.cc.
TEST_F(BagTest, ReadsRationalAndFisheyeLenses) {
  RosCameraInfo info;
  info.distortion = {0.52, -2.73, 0.0007, -0.0002, 1.62, 0.40, -2.55, 1.54};
  info.model = "rational_polynomial";
  AddDepth();
  AddInfo("/camera/depth/camera_info", kOptical, info);
  EXPECT_TRUE(Open()->info().camera.depth.HasDistortion());
  bag_ = {};
  AddDepth();
  info.distortion = {-0.02, 0.006, -0.002, 0.0003};
  info.model = "equidistant";
  AddInfo("/camera/depth/camera_info", kOptical, info);
  EXPECT_TRUE(Open()->info().camera.depth.HasDistortion());
}

TEST_F(BagTest, UsesProjectionIfIntrinsicsAreMissing) {
  RosCameraInfo info;
  info.k = {0, 0, 0, 0};
  AddDepth();
  AddInfo("/camera/depth/camera_info", kOptical, info);
  EXPECT_EQ(Open()->info().camera.depth.fx, 29);
  info.p = info.k;
  bag_ = {};
  AddDepth();
  AddInfo("/camera/depth/camera_info", kOptical, info);
  ExpectError(Names("/camera/depth/image_raw", "intrinsics"));
  options_.intrinsics = {33, 34, 15, 12};
  EXPECT_EQ(Open()->info().camera.depth.fx, 33);
}

TEST_F(BagTest, UsesTheFirstMessageWithIntrinsics) {
  RosCameraInfo empty;
  empty.k = empty.p = {0, 0, 0, 0};
  AddDepth();
  AddInfo("/camera/depth/camera_info", kOptical, empty);
  AddInfo("/camera/depth/camera_info");
  EXPECT_EQ(Open()->info().camera.depth.fx, 31);
}

TEST_F(BagTest, UsesTheSizeOfImagesIfCameraInfoHasNone) {
  RosCameraInfo info;
  info.width = info.height = 0;
  AddDepth();
  AddInfo("/camera/depth/camera_info", kOptical, info);
  const PinholeCamera camera = Open()->info().camera.depth;
  EXPECT_EQ(camera.width, 32);
  EXPECT_EQ(camera.height, 24);
  EXPECT_EQ(camera.fx, 31);
  EXPECT_EQ(camera.cx, 15.5);
}

// The full image has twice the size, or the image is a part of it.
TEST_F(BagTest, AppliesBinningAndRegionOfInterest) {
  RosCameraInfo info;
  info.width = 64;
  info.height = 48;
  info.k = {62, 60, 31.5, 23.5};
  info.binning = {2, 2};
  AddDepth();
  AddInfo("/camera/depth/camera_info", kOptical, info);
  PinholeCamera camera = Open()->info().camera.depth;
  EXPECT_EQ(camera.width, 32);
  EXPECT_EQ(camera.height, 24);
  EXPECT_EQ(camera.fx, 31);
  EXPECT_EQ(camera.cx, 15.5);
  EXPECT_EQ(camera.cy, 11.5);
  bag_ = {};
  info.binning = {1, 1};
  info.roi = {10, 4, 24, 32};
  AddDepth();
  AddInfo("/camera/depth/camera_info", kOptical, info);
  camera = Open()->info().camera.depth;
  EXPECT_EQ(camera.width, 32);
  EXPECT_EQ(camera.height, 24);
  EXPECT_EQ(camera.fx, 62);
  EXPECT_EQ(camera.cx, 21.5);
  EXPECT_EQ(camera.cy, 19.5);
}

}  // namespace
}  // namespace surfit::testing
