// Compares the stated covariance of clouds with the errors of simulated registrations.
#include <gmock/gmock.h>

#include <cstdio>
#include <random>
#include <string>

#include "registration/solvers/decompositions.h"
#include "simulation/sensors/correlated_noise.h"
#include "surfit/frame/preprocess.h"
#include "surfit/registration/icp.h"
#include "surfit/registration/register_clouds.h"
#include "surfit/simulation/camera_path.h"
#include "surfit/simulation/render.h"
#include "surfit/simulation/scene.h"
#include "testing/random_pose.h"

namespace surfit::testing {
namespace {

constexpr double kNoise_m = 0.003;

// Random points of three walls, a box and a ball in front of the origin, with noise along the
// normals.
std::vector<Eigen::Vector3f> NoisyRoom(int count, std::mt19937_64* rng) {
  std::uniform_real_distribution<double> uniform(0, 1);
  std::normal_distribution<double> noise(0, kNoise_m);
  std::vector<Eigen::Vector3f> points;
  const auto plane = [&](int n, const Eigen::Vector3d& origin, const Eigen::Vector3d& a,
                         const Eigen::Vector3d& b) {
    const Eigen::Vector3d normal = a.cross(b).normalized();
    for (int i = 0; i < n; ++i) {
      const double s = uniform(*rng), t = uniform(*rng);
      points.push_back((origin + s * a + t * b + noise(*rng) * normal).cast<float>());
    }
  };
  plane(count / 4, {-1.5, 1, 1}, {3, 0, 0}, {0, 0, 2.2});
  plane(count / 4, {-1.5, -1, 3.2}, {3, 0, 0}, {0, 2, 0});
  plane(count / 5, {-1.5, -1, 1}, {0, 2, 0}, {0, 0, 2.2});
  plane(count / 10, {0.3, 0.4, 2}, {0.5, 0, 0.2}, {0, 0.6, 0});
  for (int i = 0; i < count / 5; ++i) {
    const Eigen::Vector3d direction = RandomVector(1, rng).normalized();
    points.push_back(
        (Eigen::Vector3d(-0.6, 0.5, 2.2) + (0.4 + noise(*rng)) * direction).cast<float>());
  }
  return points;
}

SensedCloud RoomCloud(const std::vector<Eigen::Vector3f>& points) {
  CloudSensor sensor;
  sensor.noise.inverse_depth_sigma = 0;
  const CloudNormals estimated = EstimateCloudNormals(points, sensor, {});
  SensedCloud cloud;
  for (std::size_t i = 0; i < points.size(); ++i) {
    cloud.points.Add(points[i], estimated.normals[i], 1e-6f + estimated.deviation_m[i]);
  }
  return cloud;
}

// Normalised estimation error squared. Requires a covariance.
double Nees(const IcpResult& icp, const Rigid3d& truth) {
  const Rigid3d error = icp.target_from_source * truth.Inverse();
  Vector6d increment;
  increment << QuaternionLog<double>(error.rotation), error.translation;
  return increment.dot(SymmetricInverse(*icp.covariance) * increment);
}

// Mean normalised estimation error squared of `runs` registrations. The expectation for a true
// covariance is 6.
double MeanNees(const std::string& residual, int points, int runs) {
  std::mt19937_64 rng(7);
  double sum = 0;
  int accepted = 0;
  for (int run = 0; run < runs; ++run) {
    const Rigid3d truth = RandomPose(0.02, 0.02, &rng);
    std::vector<Eigen::Vector3f> source = NoisyRoom(points, &rng);
    for (Eigen::Vector3f& point : source) {
      point = (truth.Inverse() * point.cast<double>()).cast<float>();
    }
    RegisterCloudsOptions options;
    options.icp.residual = residual;
    options.icp.gates.max_distance_m = 0;
    CloudStartOptions start;
    start.method = "identity";
    const CloudRegistration result = RegisterCloudsFrom(
        RoomCloud(source), RoomCloud(NoisyRoom(points, &rng)), std::nullopt, start, options);
    if (!result.icp.covariance) continue;
    ++accepted;
    sum += Nees(result.icp, truth);
  }
  EXPECT_GT(accepted, 0.9 * runs);
  std::printf("%s, %d points: NEES %.2f of %d runs\n", residual.c_str(), points, sum / accepted,
              accepted);
  return sum / accepted;
}

// The mean of n values of a chi-square distribution with 6 degrees of freedom has the standard
// deviation sqrt(12 / n): 0.77 for 20 runs, 0.45 for 60 runs.
TEST(CloudCovariance, AgreesWithErrors) {
  const double nees = MeanNees("point_to_plane", 5000, 20);
  EXPECT_GT(nees, 4);
  EXPECT_LT(nees, 9);
}

// ICP ends where the RMSE changes little. Distances within planes change slowly, so this is several
// standard deviations from the minimum.
TEST(CloudCovariance, AgreesWithErrorsOfPointToPoint) {
  const double nees = MeanNees("point_to_point", 20000, 10);
  EXPECT_GT(nees, 4);
  EXPECT_LT(nees, 9);
}

TEST(CloudCovarianceSweep, AgreesWithErrorsForEachResidual) {
  for (const char* residual :
       {"point_to_plane", "symmetric_point_to_plane", "plane_to_plane", "point_to_point"}) {
    for (const int points : {5000, 20000}) {
      const double nees = MeanNees(residual, points, 60);
      EXPECT_GT(nees, 4) << residual;
      EXPECT_LT(nees, 9) << residual;
    }
  }
}

// Kinect v1 (Khoshelham and Elberink 2012).
constexpr double kInverseDepthSigma = 0.0015;

struct NoisyViews {
  std::string residual = "point_to_plane";
  std::string association = "projective";
  int width = 160;            // px
  double correlation_px = 0;  // of the noise
};

// Mean normalised estimation error squared of pairs of views in a room. They are up to 5 cm and 3
// degrees apart.
double MeanNeesOfViews(const NoisyViews& views, int runs) {
  PinholeCamera camera;
  camera.width = views.width, camera.height = views.width * 3 / 4;
  camera.fx = camera.fy = 0.82 * camera.width;
  camera.cx = (camera.width - 1) / 2., camera.cy = (camera.height - 1) / 2.;
  const Scene scene = MakeScene("room", 1);
  const Trajectory path = MakePath(scene, 900, 1);
  std::mt19937_64 rng(3);
  std::uniform_int_distribution<int> frame(0, 899);
  std::uint64_t seed = 0;
  const auto view = [&](const Rigid3d& world_from_camera) {
    Image<float> depth_m = RenderGeometry(scene, camera, world_from_camera).depth_m;
    const Image<float> noise =
        CorrelatedNoise(camera.width, camera.height, views.correlation_px, ++seed);
    for (int v = 0; v < camera.height; ++v) {
      for (int u = 0; u < camera.width; ++u) {
        float& z = depth_m(u, v);
        if (z > 0) z = static_cast<float>(1 / (1 / z + kInverseDepthSigma * noise(u, v)));
      }
    }
    return PreprocessDepth(depth_m, {camera, {}}, PreprocessOptions());
  };
  IcpOptions options;
  options.residual = views.residual;
  options.association = views.association;
  double sum = 0;
  int stated = 0;
  for (int run = 0; run < runs; ++run) {
    const Rigid3d world_from_target = path[frame(rng)].world_from_camera;
    const Rigid3d truth = RandomPose(0.03, 0.03, &rng);
    const FramePyramid source = view(world_from_target * truth), target = view(world_from_target);
    IcpResult icp = Register(source, target, Rigid3d(), options);
    icp.covariance = CovarianceOfViews(source, target, icp, options);
    if (!icp.covariance) continue;
    ++stated;
    sum += Nees(icp, truth);
  }
  EXPECT_GT(stated, 0.8 * runs);
  std::printf("views, %s, %s, %d columns, correlation %g px: NEES %.2f of %d runs\n",
              views.residual.c_str(), views.association.c_str(), views.width, views.correlation_px,
              sum / stated, stated);
  return sum / stated;
}

// The covariance of independent residuals gives 20 or more.
TEST(CovarianceOfViews, AgreesWithErrors) {
  const double nees = MeanNeesOfViews({}, 30);
  EXPECT_GT(nees, 4);
  EXPECT_LT(nees, 9);
}

// Rotations do not change the residuals of projective point_to_point.
TEST(CovarianceOfViews, IsEmptyForProjectivePointToPoint) {
  const Scene scene = MakeScene("room", 1);
  const PinholeCamera camera = {160, 120, 131, 131, 79.5, 59.5, {}};
  const FramePyramid view = PreprocessDepth(
      RenderGeometry(scene, camera, MakePath(scene, 1, 1)[0].world_from_camera).depth_m,
      {camera, {}}, PreprocessOptions());
  IcpOptions options;
  options.residual = "point_to_point";
  const IcpResult icp = Register(view, view, Rigid3d(), options);
  ASSERT_TRUE(icp.Succeeded());
  EXPECT_FALSE(CovarianceOfViews(view, view, icp, options));
}

TEST(CovarianceOfViewsSweep, AgreesWithErrorsAtEachResolution) {
  for (const char* residual : {"point_to_plane", "symmetric_point_to_plane", "plane_to_plane"}) {
    for (const int width : {160, 320, 640}) {
      const double nees = MeanNeesOfViews({residual, "projective", width}, 60);
      EXPECT_GT(nees, 4) << residual << ", " << width << " columns";
      EXPECT_LT(nees, 9) << residual << ", " << width << " columns";
    }
  }
}

}  // namespace
}  // namespace surfit::testing
