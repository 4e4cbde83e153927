// Registration of images to each other by the brightness of surfels.
#include "apps/export/image_poses.h"

#include <gmock/gmock.h>

#include <cstdint>
#include <random>

#include "export/simulated_surfels.h"
#include "surfit/core/parallel.h"
#include "surfit/simulation/camera_path.h"
#include "surfit/simulation/render.h"
#include "surfit/simulation/scene.h"
#include "testing/matchers.h"

namespace surfit::testing {
namespace {

constexpr int kImages = 12;
const PinholeCamera kLens = {240, 180, 196, 196, 119.5, 89.5, {}};

// Image motion in px of points at 1.5 m between two poses, mean over the corners of a square.
double DistancePx(const Rigid3d& pose, const Rigid3d& other) {
  double sum = 0;
  for (const double x : {-0.4, 0.4}) {
    for (const double y : {-0.3, 0.3}) {
      const Eigen::Vector3d point(x, y, 1.5);
      sum += (kLens.Project(pose.Inverse() * other * point) - kLens.Project(point)).norm();
    }
  }
  return sum / 4;
}

// Images of a room with their exact poses and a map from exact depth.
class ImagePosesTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    const Scene scene = MakeScene("room", 3);
    const Trajectory path = MakePath(scene, 6 * kImages, 3);
    colors_.clear();
    exact_.clear();
    map_ = SurfelMap();
    for (int i = 0; i < kImages; ++i) {
      const Rigid3d pose = path[6 * i].world_from_camera;
      const Rendering seen = Render(scene, kLens, pose);
      colors_.push_back(seen.color);
      PosedImage image;
      image.source.index = i;
      image.world_from_color = pose;
      exact_.push_back(image);
      if (i % 4 == 0) AddSurfels(seen, kLens, pose, 2, &map_);
    }
  }

  // Poses with errors of about 6 mm and 0.35 degrees.
  static std::vector<PosedImage> Disturbed() {
    std::mt19937_64 rng(1);
    std::normal_distribution<double> number;
    const auto random = [&] { return Eigen::Vector3d(number(rng), number(rng), number(rng)); };
    std::vector<PosedImage> images = exact_;
    for (PosedImage& image : images) {
      const Eigen::Vector3d rotation = 0.0035 * random();
      image.world_from_color =
          image.world_from_color * Rigid3d(QuaternionExp<double>(rotation), 0.0035 * random());
    }
    return images;
  }

  static ImageRegistration Register(std::vector<PosedImage>* images,
                                    const std::vector<Image<Rgb8>>& colors = colors_,
                                    const SurfelMap& map = map_) {
    const ColorReader read = [&](const std::vector<ColorImage>& sources, const auto& call) {
      for (std::size_t i = 0; i < sources.size(); ++i) call(i, colors[sources[i].index]);
    };
    return RegisterImages(
        {kLens, Rigid3d(), 0}, map, read, [](int) {}, images);
  }

  static double MeanDistancePx(const std::vector<PosedImage>& images) {
    double sum = 0;
    for (const PosedImage& image : images) {
      sum += DistancePx(exact_[image.source.index].world_from_color, image.world_from_color);
    }
    return sum / static_cast<double>(images.size());
  }

  static std::vector<Image<Rgb8>> colors_;
  static std::vector<PosedImage> exact_;
  static SurfelMap map_;
};

std::vector<Image<Rgb8>> ImagePosesTest::colors_;
std::vector<PosedImage> ImagePosesTest::exact_;
SurfelMap ImagePosesTest::map_;

TEST_F(ImagePosesTest, RegistrationReducesErrorsOfPoses) {
  std::vector<PosedImage> images = Disturbed();
  const double before_px = MeanDistancePx(images);
  const ImageRegistration found = Register(&images);
  EXPECT_GT(before_px, 0.6);
  EXPECT_LT(MeanDistancePx(images), 0.5 * before_px);
  EXPECT_EQ(found.registered, kImages);
  EXPECT_LT(found.rms_after, 0.8 * found.rms_before);
  // Median length of three normal deviates: 1.54 standard deviations.
  EXPECT_NEAR(found.median_change_m, 1.54 * 0.0035, 0.0025);
  EXPECT_NEAR(found.median_change_rad, 1.54 * 0.0035, 0.0025);
}

TEST_F(ImagePosesTest, ExactPosesAreKept) {
  std::vector<PosedImage> images = exact_;
  EXPECT_EQ(Register(&images).without_gain, kImages);
  for (int i = 0; i < kImages; ++i) {
    EXPECT_THAT(images[i].world_from_color, RigidNear(exact_[i].world_from_color, 0, 0));
  }
}

TEST_F(ImagePosesTest, ThePriorHoldsPosesWithoutTexture) {
  std::vector<PosedImage> images = Disturbed();
  const std::vector<Image<Rgb8>> grey(kImages,
                                      Image<Rgb8>(kLens.width, kLens.height, {90, 90, 90}));
  const ImageRegistration found = Register(&images, grey);
  EXPECT_EQ(found.registered, 0);
  EXPECT_EQ(found.without_gain, kImages);
  const std::vector<PosedImage> disturbed = Disturbed();
  for (int i = 0; i < kImages; ++i) {
    EXPECT_THAT(images[i].world_from_color, RigidNear(disturbed[i].world_from_color, 0, 0));
  }
}

TEST_F(ImagePosesTest, ImagesWithoutSurfelsKeepTheirPoses) {
  std::vector<PosedImage> images = Disturbed();
  const ImageRegistration found = Register(&images, colors_, SurfelMap());
  EXPECT_EQ(found.too_few_surfels, kImages);
  EXPECT_EQ(found.registered, 0);
}

// The third image is that of another pose, so its brightness contradicts its pose.
TEST_F(ImagePosesTest, AnImageThatContradictsItsPoseKeepsThePose) {
  std::vector<PosedImage> images = exact_;
  images[2].world_from_color.translation += Eigen::Vector3d(0.03, 0.03, 0.03);
  const Rigid3d tracked = images[2].world_from_color;
  const ImageRegistration found = Register(&images);
  EXPECT_EQ(found.contradicting, 1);
  EXPECT_EQ(found.registered + found.without_gain, kImages - 1);
  EXPECT_THAT(images[2].world_from_color, RigidNear(tracked, 0, 0));
}

TEST_F(ImagePosesTest, PosesAreEqualForAnyNumberOfThreads) {
  std::vector<PosedImage> one = Disturbed(), two = Disturbed();
  {
    const ThreadLimit limit(1);
    Register(&one);
  }
  const ThreadLimit limit(2);
  Register(&two);
  for (int i = 0; i < kImages; ++i) {
    EXPECT_THAT(two[i].world_from_color, RigidNear(one[i].world_from_color, 0, 0));
  }
}

TEST(MotionOfColorCamera, EqualsTheDifferenceOfColorPoses) {
  const Rigid3d color_from_depth(QuaternionExp<double>({0.1, -0.2, 0.3}), {-0.2, 0.1, 0.05});
  const CameraMotion motion = {{1, -2, 0.5}, {0.3, 0.2, -0.4}};
  constexpr double kSeconds = 1e-6;
  const Rigid3d step(QuaternionExp<double>(kSeconds * motion.angular_velocity_rad_per_s),
                     kSeconds * motion.velocity_m_per_s);
  const CameraMotion expected =
      surfit::MotionOver(color_from_depth * step * color_from_depth.Inverse(), kSeconds);
  const CameraMotion actual = MotionOfColorCamera(motion, color_from_depth);
  EXPECT_THAT(actual.angular_velocity_rad_per_s,
              VectorNear(expected.angular_velocity_rad_per_s, 1e-4));
  EXPECT_THAT(actual.velocity_m_per_s, VectorNear(expected.velocity_m_per_s, 1e-4));
}

}  // namespace
}  // namespace surfit::testing
