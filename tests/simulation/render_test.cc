#include "surfit/simulation/render.h"

#include <gtest/gtest.h>

#include "surfit/core/parallel.h"
#include "surfit/simulation/camera_path.h"
#include "surfit/simulation/scenes.h"

namespace surfit {
namespace {

using Eigen::Vector3d;

PinholeCamera TestCamera() {
  PinholeCamera camera;
  camera.width = 80;
  camera.height = 60;
  camera.fx = 65;
  camera.fy = 66;
  camera.cx = 39;
  camera.cy = 30.5;
  return camera;
}

// Looks along world y, x right, z up.
Rigid3d LookAlongY(const Vector3d& position) {
  Eigen::Matrix3d world_from_camera;
  world_from_camera << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  return {world_from_camera, position};
}

// depth_m is a float: relative rounding 2^-24, twice for good measure.
double DepthTolerance(double depth) { return 1.2e-7 * depth; }

TEST(Render, DepthOfAWallIsZAndNotTheRange) {
  const Rendering image = Render(MakeScene("wall"), TestCamera(), LookAlongY({0.3, 0.5, 1}));
  for (const float depth : image.depth_m) EXPECT_NEAR(depth, 1.5, DepthTolerance(1.5));
}

TEST(Render, DepthOfASphereIsThatOfTheQuadraticFormula) {
  const Vector3d eye(0.1, 0.2, 1.05), center(0, 2, 1);
  const PinholeCamera camera = TestCamera();
  const Rendering image = Render(MakeScene("sphere"), camera, LookAlongY(eye));
  int on_sphere = 0;
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const Vector3d ray = camera.Ray(u, v);
      const Vector3d d(ray.x(), ray.z(), -ray.y()), o = eye - center;
      const double b = d.dot(o) / d.dot(d), c = (o.dot(o) - 0.25) / d.dot(d);
      if (b * b - c <= 0) continue;
      ++on_sphere;
      const double z = -b - std::sqrt(b * b - c);
      // Near the rim the root amplifies the 1e-10 m at which the iteration stops.
      const double rim = 1e-10 / std::sqrt(b * b - c);
      EXPECT_NEAR(image.depth_m(u, v), z, DepthTolerance(z) + rim);
    }
  }
  EXPECT_GT(on_sphere, 500);
}

class RenderEveryScene : public testing::TestWithParam<std::string> {
 protected:
  const Scene scene_ = MakeScene(GetParam());
  const PinholeCamera camera_ = TestCamera();
  const Trajectory path_ = MakePath(scene_, 30, 5);
};

TEST_P(RenderEveryScene, AgreesWithSingleRaysAgainstAllObjects) {
  const Rigid3d pose = path_[7].world_from_camera;
  const Rendering image = Render(scene_, camera_, pose);
  for (int v = 0; v < camera_.height; ++v) {
    for (int u = 0; u < camera_.width; ++u) {
      const Vector3d ray = pose.rotation.toRotationMatrix() * camera_.Ray(u, v);
      const auto hit = scene_.Intersect(pose.translation, ray);
      ASSERT_EQ(image.surface(u, v), hit ? Rendering::SurfaceOf(*hit) : Rendering::kNothing);
      if (!hit) continue;
      EXPECT_EQ(image.depth_m(u, v), static_cast<float>(hit->t));
      const Vector3d normal = pose.rotation * image.normal(u, v).cast<double>();
      EXPECT_LT((normal - hit->normal_in_world).norm(), 1e-6);
    }
  }
}

TEST_P(RenderEveryScene, PixelsLieOnTheSurface) {
  for (const StampedPose& pose : path_) {
    const Rendering image = Render(scene_, camera_, pose.world_from_camera);
    for (int v = 0; v < camera_.height; ++v) {
      for (int u = 0; u < camera_.width; ++u) {
        const double z = image.depth_m(u, v);
        if (z == 0) continue;
        const Vector3d point = pose.world_from_camera * (z * camera_.Ray(u, v));
        // The float depth times the longest ray, 1.3; iterated shapes add 1e-10.
        ASSERT_LT(std::abs(scene_.Distance(point)), 1.3 * DepthTolerance(z) + 1e-9);
      }
    }
  }
}

// A point seen by one camera, carried to another by the poses: there it is seen at its depth, or
// something nearer hides it; never is the pixel empty or farther.
TEST_P(RenderEveryScene, ReprojectsExactlyBetweenPoses) {
  const Rigid3d a = path_[0].world_from_camera, b = path_[25].world_from_camera;
  const Rendering image = Render(scene_, camera_, a);
  const Rigid3d b_from_a = b.Inverse() * a;
  int seen = 0, same = 0;
  for (int v = 0; v < camera_.height; ++v) {
    for (int u = 0; u < camera_.width; ++u) {
      if (image.depth_m(u, v) == 0) continue;
      const Vector3d in_b = b_from_a * (image.depth_m(u, v) * camera_.Ray(u, v));
      if (in_b.z() < 0.1) continue;
      const auto hit = scene_.Intersect(b.translation, b.rotation * (in_b / in_b.z()));
      ASSERT_TRUE(hit.has_value());
      // Float rounding moves the point by 1e-6 m at most (8 m); seen at a slant of up to 89.9 deg
      // that is 1e-3 m of depth.
      EXPECT_LT(hit->t, in_b.z() + 1e-3);
      ++seen;
      if (std::abs(hit->t - in_b.z()) < 1e-5) ++same;
    }
  }
  EXPECT_GT(seen, 1000);
  EXPECT_GT(same, 0.7 * seen);
}

TEST_P(RenderEveryScene, IsTheSameAtAnyNumberOfThreads) {
  std::vector<Rendering> images;
  for (const int threads : {1, 3}) {
    ThreadLimit limit(threads);
    images.push_back(Render(MakeScene(GetParam()), camera_, path_[3].world_from_camera));
  }
  EXPECT_TRUE(images[0].depth_m == images[1].depth_m);
  EXPECT_TRUE(images[0].color == images[1].color);
  EXPECT_TRUE(images[0].surface == images[1].surface);
}

INSTANTIATE_TEST_SUITE_P(All, RenderEveryScene, testing::ValuesIn(SceneNames()),
                         [](const auto& instance) { return instance.param; });

TEST(RenderFrame, HasTheImagesOfTheRendering) {
  const Scene scene = MakeScene("three_planes");
  const Rigid3d pose = MakePath(scene, 1, 1)[0].world_from_camera;
  const RgbdFrame frame = RenderFrame(scene, TestCamera(), pose, 7, 0.25);
  const Rendering image = Render(scene, TestCamera(), pose);
  EXPECT_EQ(frame.index, 7);
  EXPECT_EQ(frame.stamp_s, 0.25);
  EXPECT_TRUE(frame.depth_m == image.depth_m);
  EXPECT_TRUE(frame.color == image.color);
  const Rendering geometry = RenderGeometry(scene, TestCamera(), pose);
  EXPECT_TRUE(geometry.depth_m == image.depth_m);
  EXPECT_TRUE(geometry.color.empty());
}

}  // namespace
}  // namespace surfit
