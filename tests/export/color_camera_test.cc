#include <gmock/gmock.h>

#include <cmath>

#include "apps/export/color_calibration.h"
#include "apps/export/color_images.h"
#include "apps/export/map_visibility.h"
#include "apps/export/sparse_points.h"
#include "export/simulated_surfels.h"
#include "surfit/simulation/camera_path.h"
#include "surfit/simulation/render.h"
#include "surfit/simulation/scene.h"
#include "testing/matchers.h"
#include "testing/sequence_writer.h"

namespace surfit::testing {
namespace {

std::vector<ColorImage> ImagesWithSharpness(const std::vector<double>& sharpness) {
  std::vector<ColorImage> images(sharpness.size());
  for (std::size_t i = 0; i < images.size(); ++i) {
    images[i].index = static_cast<int>(i);
    images[i].sharpness = sharpness[i];
    images[i].world_from_depth.translation.x() = 0.1 * static_cast<double>(i);
  }
  return images;
}

TEST(ChooseImages, TakesTheSharpestOfEachPartOfThePath) {
  const std::vector<ColorImage> images = ImagesWithSharpness({1, 5, 2, 3, 9, 1, 2, 2, 7, 4, 4, 8});
  const std::vector<ColorImage> chosen = ChooseImages(images, 4);
  std::vector<int> indices;
  for (const ColorImage& image : chosen) indices.push_back(image.index);
  EXPECT_THAT(indices, ElementsAre(1, 4, 8, 11));
  EXPECT_EQ(ChooseImages(images, 0).size(), 12u);
  EXPECT_EQ(ChooseImages(images, 20).size(), 12u);
}

// A camera at rest for most of the time has few images, but the requested number is reached.
TEST(ChooseImages, FillsPartsWithoutImages) {
  std::vector<ColorImage> images = ImagesWithSharpness(std::vector<double>(100, 1));
  for (std::size_t i = 0; i < 90; ++i) images[i].world_from_depth.translation.x() = 0;
  const std::size_t count = ChooseImages(images, 20).size();
  EXPECT_GT(count, 16u);
  EXPECT_LE(count, 20u);
}

// Simulated room, seen by a depth camera and by a colour camera beside it.
class ColorCameraTest : public ::testing::Test {
 protected:
  static constexpr int kFrames = 30;
  const PinholeCamera depth_camera_ = {160, 120, 130, 130, 79.5, 59.5, {}};
  const PinholeCamera color_camera_ = {320, 240, 262, 262, 156, 122, {}};
  const Rigid3d color_from_depth_{QuaternionExp<double>({0.004, -0.006, 0.005}),
                                  {-0.027, 0.002, 0}};

  // Writes the sequence, with this color_from_depth in camera.yaml, and fills map and run.
  void Simulate(const Rigid3d& written) {
    const Scene scene = MakeScene("room", 3);
    const Trajectory path = MakePath(scene, 10 * kFrames, 3);
    std::string rgb, depth;
    for (int i = 0; i < kFrames; ++i) {
      const Rigid3d pose = path[10 * i].world_from_camera;
      const Rendering seen = Render(scene, depth_camera_, pose);
      const Rendering colored = Render(scene, color_camera_, pose * color_from_depth_.Inverse());
      WriteDepth(folder_ / Format("depth/%03d.png", i), Millimetres(seen.depth_m));
      WriteColor(folder_ / Format("rgb/%03d.png", i), colored.color);
      rgb += std::to_string(0.1 * i) + Format(" rgb/%03d.png\n", i);
      depth += std::to_string(0.1 * i) + Format(" depth/%03d.png\n", i);
      run_.trajectory.push_back({0.1 * i, pose});
      run_.world_from_camera[i] = pose;
      if (i % 3 == 0) AddSurfels(seen, depth_camera_, pose, 1, &map_);
    }
    folder_.Write("rgb.txt", rgb);
    folder_.Write("depth.txt", depth);
    const Eigen::Vector3d& t = written.translation;
    const Eigen::Quaterniond& q = written.rotation;
    folder_.Write(
        "camera.yaml",
        Concat("%YAML:1.0\n---\ndepth_camera: { width: 160, height: 120, fx: 130., fy: 130., cx: "
               "79.5, cy: 59.5 }\ncolor_camera: { width: 320, height: 240, fx: 262., fy: 262., "
               "cx: 156., cy: 122. }\ncolor_from_depth: { translation_m: [ ",
               t.x(), ", ", t.y(), ", ", t.z(), " ], rotation_xyzw: [ ", q.x(), ", ", q.y(), ", ",
               q.z(), ", ", q.w(), " ] }\ndepth_units_per_metre: 1000.\n"));
    UnusedFrames unused;
    images_ = ListColorImages(
        Options(folder_), run_, [](int) {}, &unused);
    ASSERT_EQ(images_.size(), kFrames);
    given_ = GivenColorCamera(OpenSequence(Options(folder_))->info(), run_);
  }
  ColorCalibration Estimate() const {
    return EstimateColorCamera(given_, CalibrationPrior(), Options(folder_), images_, map_,
                               [](int) {});
  }

  const TempFolder folder_;
  RecordedRun run_;
  SurfelMap map_;
  std::vector<ColorImage> images_;
  ColorCamera given_;

 private:
  static Image<std::uint16_t> Millimetres(const Image<float>& depth_m) {
    Image<std::uint16_t> depth(depth_m.width(), depth_m.height());
    for (std::size_t i = 0; i < depth.size(); ++i) {
      depth[i] = static_cast<std::uint16_t>(1000 * depth_m[i] + 0.5f);
    }
    return depth;
  }
};

TEST_F(ColorCameraTest, EstimateCorrectsTheExtrinsics) {
  Simulate(Rigid3d());
  const ColorCalibration found = Estimate();
  EXPECT_TRUE(found.is_estimated);
  EXPECT_LT(found.rms_after, 0.8 * found.rms_before);
  // Principal point and rotation are correlated, so the prediction is compared: in px, for points
  // at 1 m and at 3 m.
  for (const double z : {1., 3.}) {
    for (const double x : {-0.4, 0., 0.4}) {
      const Eigen::Vector3d point(x * z, 0.2 * z, z);
      const Eigen::Vector2d expected = color_camera_.Project(color_from_depth_ * point);
      const Eigen::Vector2d actual =
          found.camera.lens.Project(found.camera.color_from_depth * point);
      EXPECT_THAT(actual, VectorNear(expected, 0.5));
    }
  }
}

TEST_F(ColorCameraTest, EstimateKeepsCorrectExtrinsicsWithinAFifthOfAPixel) {
  Simulate(color_from_depth_);
  const ColorCalibration found = Estimate();
  for (const double z : {1., 3.}) {
    const Eigen::Vector3d point(0.3 * z, 0.2 * z, z);
    EXPECT_THAT(found.camera.lens.Project(found.camera.color_from_depth * point),
                VectorNear(color_camera_.Project(color_from_depth_ * point), 0.2));
  }
}

// Points of the map are visible in the images that show them, and not through walls.
TEST_F(ColorCameraTest, SparsePointsAreOnTheNearestSurface) {
  Simulate(color_from_depth_);
  const Scene scene = MakeScene("room", 3);
  std::vector<PosedImage> images;
  for (const ColorImage& image : images_) {
    images.push_back({image, image.world_from_depth * color_from_depth_.Inverse()});
  }
  const SparsePoints points = FindSparsePoints(map_, color_camera_, images);
  EXPECT_GT(points.points.size(), 1000u);
  int seen = 0, wrong = 0;
  for (std::size_t i = 0; i < images.size(); i += 5) {
    const Rendering truth = Render(scene, color_camera_, images[i].world_from_color);
    for (const PointView& view : points.views[i]) {
      const Eigen::Vector3d point = images[i].world_from_color.Inverse() *
                                    points.points[view.point].position_in_world.cast<double>();
      const float depth_m = truth.depth_m(static_cast<int>(std::lround(view.pixel.x())),
                                          static_cast<int>(std::lround(view.pixel.y())));
      ++seen;
      wrong += std::abs(point.z() - depth_m) > 0.05 * point.z() ? 1 : 0;
    }
  }
  EXPECT_GT(seen, 3000);
  EXPECT_LT(wrong, 0.01 * seen);
}

}  // namespace
}  // namespace surfit::testing
