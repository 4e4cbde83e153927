#include "surfit/simulation/render.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <opencv2/imgcodecs.hpp>

#include "surfit/core/error.h"
#include "surfit/simulation/camera_path.h"
#include "surfit/simulation/scene.h"
#include "testing/matchers.h"
#include "testing/pixels.h"
#include "testing/shared_data.h"
#include "testing/threads.h"

namespace surfit::testing {
namespace {

using Eigen::Vector3d;

PinholeCamera TestCamera() { return {80, 60, 65, 66, 39, 30.5, {}}; }

// Camera pose with the optical axis along world y, x right, z up.
Rigid3d LookAlongY(const Vector3d& position) {
  Eigen::Matrix3d world_from_camera;
  world_from_camera << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  return {world_from_camera, position};
}

// depth_m is a float: twice the relative rounding 2^-24.
double DepthTolerance(double depth) { return 1.2e-7 * depth; }

TEST(Render, DepthOfWallIsZ) {
  const Rendering image = Render(MakeScene("wall"), TestCamera(), LookAlongY({0.3, 0.5, 1}));
  for (const float depth : image.depth_m) EXPECT_NEAR(depth, 1.5, DepthTolerance(1.5));
}

TEST(Render, DepthOfSphereAgreesWithQuadraticFormula) {
  const Vector3d eye(0.1, 0.2, 1.05), center(0, 2, 1);
  const PinholeCamera camera = TestCamera();
  const Rendering image = Render(MakeScene("sphere"), camera, LookAlongY(eye));
  int on_sphere = 0;
  for (const auto [u, v] : PixelsOf(camera)) {
    const Vector3d ray = camera.Ray(u, v);
    const Vector3d d(ray.x(), ray.z(), -ray.y()), o = eye - center;
    const double b = d.dot(o) / d.dot(d), c = (o.dot(o) - 0.25) / d.dot(d);
    if (b * b - c <= 0) continue;
    ++on_sphere;
    const double z = -b - std::sqrt(b * b - c);
    // Near the rim the square root amplifies the tolerance of the iteration, 1e-10 m.
    const double rim = 1e-10 / std::sqrt(b * b - c);
    EXPECT_NEAR(image.depth_m(u, v), z, DepthTolerance(z) + rim);
  }
  EXPECT_GT(on_sphere, 500);
}

class RenderEveryScene : public ::testing::TestWithParam<std::string> {
 protected:
  const Scene scene_ = MakeScene(GetParam());
  const PinholeCamera camera_ = TestCamera();
  const Trajectory path_ = MakePath(scene_, 30, 5);
};

TEST_P(RenderEveryScene, AgreesWithSingleRaysAgainstAllObjects) {
  const Rigid3d pose = path_[7].world_from_camera;
  const Rendering image = Render(scene_, camera_, pose);
  for (const auto [u, v] : PixelsOf(camera_)) {
    const Vector3d ray = pose.rotation.toRotationMatrix() * camera_.Ray(u, v);
    const auto hit = scene_.Intersect(pose.translation, ray);
    ASSERT_EQ(image.surface(u, v), hit ? Rendering::SurfaceOf(*hit) : Rendering::kNothing);
    if (!hit) continue;
    EXPECT_EQ(image.depth_m(u, v), static_cast<float>(hit->t));
    const Vector3d normal = pose.rotation * image.normal(u, v).cast<double>();
    EXPECT_LT((normal - hit->normal_in_world).norm(), 1e-6);
  }
}

TEST_P(RenderEveryScene, PixelsLieOnTheSurface) {
  for (const StampedPose& pose : path_) {
    const Rendering image = Render(scene_, camera_, pose.world_from_camera);
    for (const auto [u, v] : PixelsOf(camera_)) {
      const double z = image.depth_m(u, v);
      if (z == 0) continue;
      const Vector3d point = pose.world_from_camera * (z * camera_.Ray(u, v));
      // Rounding of the depth times the longest ray, 1.3, plus 1e-10 of iterated shapes.
      ASSERT_LT(std::abs(scene_.Distance(point)), 1.3 * DepthTolerance(z) + 1e-9);
    }
  }
}

// A point of one view is projected to another view. There the depth is equal, or smaller if the
// point is occluded. It is never missing or larger.
TEST_P(RenderEveryScene, ReprojectsExactlyBetweenPoses) {
  const Rigid3d a = path_[0].world_from_camera, b = path_[25].world_from_camera;
  const Rendering image = Render(scene_, camera_, a);
  const Rigid3d b_from_a = b.Inverse() * a;
  int seen = 0, same = 0;
  for (const auto [u, v] : PixelsOf(camera_)) {
    if (image.depth_m(u, v) == 0) continue;
    const Vector3d in_b = b_from_a * (image.depth_m(u, v) * camera_.Ray(u, v));
    if (in_b.z() < 0.1) continue;
    const auto hit = scene_.Intersect(b.translation, b.rotation * (in_b / in_b.z()));
    ASSERT_TRUE(hit.has_value());
    // Float rounding moves the point by at most 1e-6 m (at 8 m). At a slant of 89.9 deg, this is
    // 1e-3 m of depth.
    EXPECT_LT(hit->t, in_b.z() + 1e-3);
    ++seen;
    if (std::abs(hit->t - in_b.z()) < 1e-5) ++same;
  }
  EXPECT_GT(seen, 1000);
  EXPECT_GT(same, 0.7 * seen);
}

TEST_P(RenderEveryScene, IsTheSameAtAnyNumberOfThreads) {
  const auto images = AtThreads(
      {1, 3}, [&] { return Render(MakeScene(GetParam()), camera_, path_[3].world_from_camera); });
  EXPECT_TRUE(images[0].depth_m == images[1].depth_m);
  EXPECT_TRUE(images[0].color == images[1].color);
  EXPECT_TRUE(images[0].surface == images[1].surface);
}

INSTANTIATE_TEST_SUITE_P(All, RenderEveryScene, ::testing::ValuesIn(SceneNames()),
                         [](const auto& instance) { return instance.param; });

TEST(RenderFrame, ContainsImagesOfRendering) {
  const Scene scene = MakeScene("three_planes");
  const Rigid3d pose = MakePath(scene, 1, 1)[0].world_from_camera;
  const RgbdFrame frame = RenderFrame(scene, TestCamera(), pose, 7, 0.25);
  const Rendering image = Render(scene, TestCamera(), pose);
  EXPECT_EQ(frame.index, 7);
  EXPECT_EQ(frame.stamp_s, 0.25);
  EXPECT_EQ(frame.color_stamp_s, 0.25);
  EXPECT_TRUE(frame.depth_m == image.depth_m);
  EXPECT_TRUE(frame.color == image.color);
  const Rendering geometry = RenderGeometry(scene, TestCamera(), pose);
  EXPECT_TRUE(geometry.depth_m == image.depth_m);
  EXPECT_TRUE(geometry.color.empty());
}

constexpr double kConstant_m = 351.3;

PinholeCamera Camera() { return {640, 480, 525, 525, 319.5, 239.5, {}}; }

// Plane with the disparity a u + b v + c, in disparity steps.
Image<float> PlaneDepth(double a, double b, double c) {
  Image<float> depth(640, 480);
  for (const auto [u, v] : PixelsOf(640, 480)) {
    depth(u, v) = static_cast<float>(kConstant_m / (a * u + b * v + c));
  }
  return depth;
}

struct Moments {
  double mean = 0, variance = 0;
  int count = 0;
};

// Moments of the disparity error, in steps, without the image border.
Moments DisparityError(const Image<float>& exact, const Image<float>& measured) {
  std::vector<double> errors;
  for (const auto [u, v] : Pixels(4, 636, 4, 476)) {
    if (measured(u, v) == 0) continue;
    errors.push_back(kConstant_m / measured(u, v) - kConstant_m / exact(u, v));
  }
  Moments moments;
  moments.count = static_cast<int>(errors.size());
  for (const double e : errors) moments.mean += e / errors.size();
  for (const double e : errors) {
    moments.variance += (e - moments.mean) * (e - moments.mean) / errors.size();
  }
  return moments;
}

// On a plane the error is the sum of independent parts. A shift of (s_u, s_v) px adds a s_u + b
// s_v. The noise has the standard deviation 1/6. Rounding adds a uniform error of variance 1/12,
// because the disparities of a slanted plane cover all fractions of a step.
class KinectOnAPlane : public ::testing::TestWithParam<std::array<double, 3>> {};

TEST_P(KinectOnAPlane, HasVarianceOfNoiseModel) {
  const auto [a, b, c] = GetParam();
  const Image<float> exact = PlaneDepth(a, b, c);
  const Moments error = DisparityError(exact, KinectDepth(exact, Camera(), 3));
  ASSERT_EQ(error.count, 632 * 472);
  const double variance = 0.25 * (a * a + b * b) + 1.0 / 36 + 1.0 / 12;
  // Five standard errors, for variances with the kurtosis of a normal distribution. The kurtosis
  // here is lower.
  EXPECT_NEAR(error.mean, 0, 5 * std::sqrt(variance / error.count));
  EXPECT_NEAR(error.variance, variance, 5 * variance * std::sqrt(2.0 / error.count));
}

INSTANTIATE_TEST_SUITE_P(Slopes, KinectOnAPlane,
                         ::testing::Values(std::array<double, 3>{0.011, 0.007, 290},
                                           std::array<double, 3>{0.05, 0.031, 110},
                                           std::array<double, 3>{0.013, 0.6, 90},
                                           std::array<double, 3>{-0.3, 0.017, 330}));

TEST(Kinect, IsMissingBelowMinAndAboveMaxDepth) {
  for (const auto& [depth_m, seen] : {std::pair{0.39, false}, std::pair{0.42, true},
                                      std::pair{4.3, true}, std::pair{4.8, false}}) {
    const Image<float> wall(640, 480, static_cast<float>(depth_m));
    const Image<float> measured = KinectDepth(wall, Camera(), 1);
    const auto valid = measured.size() - std::count(measured.begin(), measured.end(), 0.f);
    EXPECT_EQ(valid, seen ? measured.size() : 0u) << depth_m;
  }
}

// Floor 0.3 m below the camera. Row v has the depth z = 0.3 fy / (v - cy). The cosine of the angle
// of incidence is (v - cy) / fy / |ray|.
TEST(Kinect, IsMissingAbove80DegreesOfIncidence) {
  const PinholeCamera camera = Camera();
  Image<float> floor(640, 480, 0.f);
  for (const auto [u, v] : Pixels(0, 640, 280, 480)) {
    floor(u, v) = static_cast<float>(0.3 * camera.fy / (v - camera.cy));
  }
  const Image<float> measured = KinectDepth(floor, camera, 1);
  for (const auto [u, v] : Pixels(0, 640, 282, 478)) {
    const Eigen::Vector3d ray = camera.Ray(u, v);
    const double angle_deg = std::acos(ray.y() / ray.norm()) * 180 / M_PI;
    // Float depth and one-sided differences at the border cause errors far below 0.1 deg.
    if (angle_deg < 79.9 && floor(u, v) > 0.42) {
      EXPECT_GT(measured(u, v), 0) << u << " " << v;
    }
    if (angle_deg > 80.1) {
      EXPECT_EQ(measured(u, v), 0) << u << " " << v;
    }
  }
}

TEST(Kinect, DoesNotMixDepthsAcrossStep) {
  Image<float> step(640, 480, 1.f);
  for (int v = 0; v < 480; ++v) std::fill(step.row(v) + 320, step.row(v) + 640, 2.f);
  const Image<float> measured = KinectDepth(step, Camera(), 1);
  // A disparity step is z^2 / 351.3. Rounding and noise of 6 sigma move the depth by at most 1.5
  // steps.
  for (const auto [u, v] : PixelsOf(640, 480)) {
    if (u == 319 || u == 320) {
      EXPECT_EQ(measured(u, v), 0) << "a depth step is missing like a surface at a grazing angle";
    } else {
      const double z = step(u, v);
      EXPECT_NEAR(measured(u, v), z, 1.6 * z * z / kConstant_m);
    }
  }
}

TEST(Kinect, KeepsMissingPixels) {
  Image<float> depth(640, 480, 2.f);
  depth(100, 100) = 0;
  EXPECT_EQ(KinectDepth(depth, Camera(), 1)(100, 100), 0);
}

TEST(Kinect, DependsOnSeedAndNotOnThreads) {
  const Image<float> depth = PlaneDepth(0.05, 0.031, 110);
  const auto images = AtThreads({1, 2, 5}, [&] { return KinectDepth(depth, Camera(), 7); });
  EXPECT_TRUE(images[0] == images[1]);
  EXPECT_TRUE(images[0] == images[2]);
  EXPECT_FALSE(images[0] == KinectDepth(depth, Camera(), 8));
}

TEST(Kinect, RejectsInvalidOptionsByName) {
  KinectOptions options;
  options.max_depth_m = 0.2;
  ExpectInputError([&] { KinectDepth(Image<float>(640, 480, 1.f), Camera(), 1, options); },
                   Names("max_depth_m", 0.2, "min_depth_m"));
}

// The shared recording is icl_office with the same noise model.
class KinectAgainstRecording : public ::testing::Test {
 protected:
  static constexpr int kFrames = 5;

  void SetUp() override {
    SURFIT_REQUIRE_SHARED_DATA("icl_office_kinect");
    SURFIT_REQUIRE_SHARED_DATA("icl_office");
    PinholeCamera camera = Camera();
    camera.fx = 481.203;
    camera.fy = 480;
    for (int i = 0; i < kFrames; ++i) {
      char name[32];
      std::snprintf(name, sizeof(name), "/depth/%.6f.png", 2 + i * 40 / 30.0);
      exact_.push_back(Load(SharedData("icl_office") + name));
      recorded_.push_back(Load(SharedData("icl_office_kinect") + name));
      ours_.push_back(KinectDepth(exact_.back(), camera, i));
    }
  }

  static Image<float> Load(const std::string& path) {
    const cv::Mat units = cv::imread(path, cv::IMREAD_UNCHANGED);
    if (units.empty()) throw InputError(path + " cannot be read");
    Image<float> depth(units.cols, units.rows);
    std::transform(units.begin<std::uint16_t>(), units.end<std::uint16_t>(), depth.begin(),
                   [](std::uint16_t unit) { return unit / 5000.f; });
    return depth;
  }

  static double ValidRatio(const std::vector<Image<float>>& images) {
    double valid = 0, all = 0;
    for (const Image<float>& image : images) {
      valid += image.size() - std::count(image.begin(), image.end(), 0.f);
      all += image.size();
    }
    return valid / all;
  }

  // Sorted errors of pixels with an exact depth within 10 cm of `depth_m`.
  std::vector<double> Errors(const std::vector<Image<float>>& images, double depth_m) const {
    std::vector<double> errors;
    for (int i = 0; i < kFrames; ++i) {
      for (std::size_t k = 0; k < images[i].size(); ++k) {
        const double exact = exact_[i][k], measured = images[i][k];
        if (measured > 0 && std::abs(exact - depth_m) < 0.1) errors.push_back(measured - exact);
      }
    }
    std::sort(errors.begin(), errors.end());
    return errors;
  }

  std::vector<Image<float>> exact_, recorded_, ours_;
};

double Quantile(const std::vector<double>& sorted, double share) {
  return sorted[static_cast<std::size_t>(share * (sorted.size() - 1))];
}

TEST_F(KinectAgainstRecording, HasSameRatioOfMissingPixels) {
  EXPECT_NEAR(ValidRatio(ours_), ValidRatio(recorded_), 0.005);
}

// Half the width of the central 68.27 %: the standard deviation of a normal distribution, robust to
// the outliers at edges. The description of the recording states 3, 8, 16 and 21 mm.
TEST_F(KinectAgainstRecording, HasSameSpreadAtEachDistanceAndNoBias) {
  const double most_mm[] = {3, 8, 16, 21};
  for (int i = 0; i < 4; ++i) {
    const double depth_m = 1.2 + i;
    const std::vector<double> ours = Errors(ours_, depth_m), recorded = Errors(recorded_, depth_m);
    ASSERT_GT(ours.size(), 20000u);
    const auto spread = [](const std::vector<double>& e) {
      return (Quantile(e, 0.84134) - Quantile(e, 0.15866)) / 2;
    };
    // The recording is quantised to 0.2 mm. The standard error of the spread is 1.2 sigma / sqrt(N)
    // < 1 %. Disparities that are integers in only one image add to the difference.
    EXPECT_NEAR(spread(ours), spread(recorded), 0.0002 + 0.03 * spread(recorded)) << depth_m;
    EXPECT_LT(spread(ours), most_mm[i] / 1000);
    // Five standard errors of the median, 1.25 sigma / sqrt(N), plus half a unit of the recording.
    EXPECT_NEAR(Quantile(ours, 0.5), 0, 5 * 1.25 * spread(ours) / std::sqrt(ours.size()) + 0.0001);
  }
}

}  // namespace
}  // namespace surfit::testing
