#include <gmock/gmock.h>

#include <cmath>
#include <random>

#include "surfit/registration/register_clouds.h"
#include "testing/matchers.h"
#include "testing/random_pose.h"
#include "testing/threads.h"

namespace surfit::testing {
namespace {

using Points = std::vector<Eigen::Vector3f>;

// Random points in a rectangle with the given sides (m) and `density` points per square metre.
// Noise is along the normal z. The points are transformed by `pose`.
Points Rectangle(double side_x, double side_y, double density, double sigma_m,
                 const Rigid3d& pose = {}) {
  std::mt19937_64 rng(1);
  std::uniform_real_distribution<double> uniform(-0.5, 0.5);
  std::normal_distribution<double> noise(0, 1);
  Points points;
  const int count = static_cast<int>(side_x * side_y * density);
  for (int i = 0; i < count; ++i) {
    const double x = side_x * uniform(rng), y = side_y * uniform(rng);
    points.push_back((pose * Eigen::Vector3d(x, y, sigma_m * noise(rng))).cast<float>());
  }
  return points;
}

// Sensor model for points with noise that does not depend on the viewpoint.
CloudSensor WithoutDepthNoise() {
  CloudSensor sensor;
  sensor.noise.inverse_depth_sigma = 0;
  return sensor;
}

TEST(CloudNormals, AreExactOnTiltedPlaneAtAnyScale) {
  for (const double scale : {0.01, 1., 100.}) {
    const Eigen::Quaterniond turn = QuaternionExp<double>({0.3, -0.4, 0.2});
    const Points points =
        Rectangle(scale, scale, 3000 / (scale * scale), 0, {turn, {scale, 2 * scale, 5 * scale}});
    const CloudNormals result = EstimateCloudNormals(points, WithoutDepthNoise(), {});
    EXPECT_EQ(result.missing, 0);
    const Eigen::Vector3f expected = (turn * -Eigen::Vector3d::UnitZ()).cast<float>();
    for (const auto& normal : result.normals) {
      // Coordinates up to 6 have random rounding errors of 2.4e-7. The smallest neighbourhood has a
      // radius of 3 / sqrt(3000) = 0.05 and 10 points: 2.4e-7 / (0.025 sqrt(10)) = 3e-6 rad at one
      // sigma, and a few times that at the border.
      ASSERT_THAT(normal, VectorNear(expected, 5e-5f));
    }
  }
}

// The deviation of a normal has two components of at most max_normal_sigma_rad at one sigma. So the
// mean square is at most twice the square of max_normal_sigma_rad. The deviation of points is
// measured by deviation_m.
TEST(CloudNormals, UseMoreNeighboursForLargerNoise) {
  double last_square = 0;
  for (const double sigma_m : {0.0005, 0.004}) {
    const Points points =
        Rectangle(1, 1, 20000, sigma_m, {Eigen::Quaterniond::Identity(), {0, 0, 2}});
    const CloudNormals result = EstimateCloudNormals(points, WithoutDepthNoise(), {});
    EXPECT_LT(result.missing, 0.01 * points.size());
    double square = 0, deviation_m = 0;
    const double found = static_cast<double>(points.size()) - result.missing;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (result.normals[i].isZero(0)) continue;
      square += (result.normals[i] + Eigen::Vector3f::UnitZ()).squaredNorm() / found;
      deviation_m += result.deviation_m[i] / found;
    }
    EXPECT_LT(std::sqrt(square), M_SQRT2 * CloudNormalOptions().max_normal_sigma_rad);
    // Neighbourhoods with small noise are accepted early, so the estimate is about 10 % smaller.
    EXPECT_NEAR(deviation_m, sigma_m, 0.15 * sigma_m);
    EXPECT_GT(square, last_square);
    last_square = square;
  }
}

// With ten neighbours, 4 mm noise and a spacing of 7 mm, normals have errors of 0.3 rad.
TEST(CloudNormals, AreMissingForNoiseWithoutGrowth) {
  const Points points = Rectangle(1, 1, 20000, 0.004);
  CloudNormalOptions options;
  options.max_growth = 1;
  EXPECT_GT(EstimateCloudNormals(points, WithoutDepthNoise(), options).missing,
            0.9 * points.size());
}

TEST(CloudNormals, AreOfOneWallOrMissingAtEdge) {
  const double half_pi = M_PI / 2;
  Points points = Rectangle(1, 1, 20000, 0.001, {Eigen::Quaterniond::Identity(), {0.5, 0, 2}});
  const Points other =
      Rectangle(1, 1, 20000, 0.001, {QuaternionExp<double>({0, half_pi, 0}), {0, 0, 1.5}});
  points.insert(points.end(), other.begin(), other.end());
  CloudSensor sensor = WithoutDepthNoise();
  sensor.viewpoint = {0.5, 0, 1.5};
  const CloudNormals result = EstimateCloudNormals(points, sensor, {});
  int slanted = 0;
  for (const auto& n : result.normals) {
    const bool is_wall = (n + Eigen::Vector3f::UnitZ()).norm() < 0.3f ||
                         (n - Eigen::Vector3f::UnitX()).norm() < 0.3f;
    slanted += !n.isZero(0) && !is_wall;
  }
  EXPECT_GT(result.missing, 0);
  EXPECT_LT(result.missing, 0.1 * points.size());
  EXPECT_LT(slanted, 0.005 * points.size());
}

// Wall at 3.5 m with a slant of 45 degrees. Depth is quantised to layers of 36 mm, each 36 mm wide
// on the wall. Within 20 mm there is about one layer, and a plane fitted to it faces the camera.
TEST(CloudNormals, IgnoreDepthQuantisationWithSensorModel) {
  const Rigid3d pose(QuaternionExp<double>({0, M_PI / 4, 0}), {0, 0, 3.5});
  Points points = Rectangle(1, 1, 20000, 0, pose);
  for (auto& point : points) point *= 0.036f * std::round(point.z() / 0.036f) / point.z();
  const Eigen::Vector3f expected = (pose.rotation * -Eigen::Vector3d::UnitZ()).cast<float>();
  const auto share_right = [&](const CloudSensor& sensor) {
    int right = 0;
    for (const auto& n : EstimateCloudNormals(points, sensor, {}).normals) {
      right += n.dot(expected) > std::cos(0.15);
    }
    return right / static_cast<double>(points.size());
  };
  EXPECT_LT(share_right(WithoutDepthNoise()), 0.5);
  EXPECT_GT(share_right({}), 0.9);
}

TEST(CloudNormals, FaceViewpoint) {
  std::mt19937_64 rng(1);
  Points sphere;
  for (int i = 0; i < 5000; ++i) {
    sphere.push_back(RandomVector(1, &rng).normalized().cast<float>());
  }
  const CloudNormals inwards = EstimateCloudNormals(sphere, {}, {});
  EXPECT_EQ(inwards.missing, 0);
  for (std::size_t i = 0; i < sphere.size(); ++i) {
    ASSERT_LT(inwards.normals[i].dot(sphere[i]), -0.98f);  // 0.2 rad
  }
}

TEST(CloudNormals, AreMissingWithoutPlane) {
  Points points = Rectangle(1, 1, 1000, 0);
  points.push_back({0, 0, 9});  // an outlier
  for (int i = 0; i < 50; ++i) points.push_back({3, 3, 0.01f * static_cast<float>(i)});  // a wire
  for (int i = 0; i < 50; ++i) points.push_back({5, 5, 5});  // equal points
  const CloudNormals result = EstimateCloudNormals(points, WithoutDepthNoise(), {});
  EXPECT_EQ(result.missing, 101);
  for (std::size_t i = 1000; i < points.size(); ++i) {
    EXPECT_TRUE(result.normals[i].isZero(0));
    EXPECT_EQ(result.deviation_m[i], 0);
  }
  for (const Points& few :
       {Points(), Points(1, Eigen::Vector3f::Zero()), Points(9, Eigen::Vector3f::Zero()),
        Points(20, Eigen::Vector3f::Zero())}) {
    EXPECT_EQ(EstimateCloudNormals(few, {}, {}).missing, static_cast<int>(few.size()));
  }
}

// A lidar scan has far more points near the sensor. The normals of the dense part use part of the
// points, and the time per point stays bounded.
TEST(CloudNormals, AreRightAtVeryDifferentDensities) {
  Points points = Rectangle(1, 1, 2000, 0.001, {Eigen::Quaterniond::Identity(), {0, 0, 2}});
  const Points dense =
      Rectangle(0.05, 0.05, 8e6, 0.001, {Eigen::Quaterniond::Identity(), {2, 0, 2}});
  points.insert(points.end(), dense.begin(), dense.end());
  CloudNormalOptions options;
  options.radius_m = 0.05;
  const CloudNormals result = EstimateCloudNormals(points, WithoutDepthNoise(), options);
  EXPECT_LT(result.missing, 0.01 * points.size());
  int slanted = 0;
  for (const auto& normal : result.normals) {
    slanted += !normal.isZero(0) && (normal + Eigen::Vector3f::UnitZ()).norm() > 0.15f;
  }
  EXPECT_LT(slanted, 0.01 * points.size());
}

// Half of the points are equal. The spacing is that of the other half.
TEST(CloudNormals, IgnoreManyEqualPoints) {
  Points points = Rectangle(1, 1, 5000, 0, {Eigen::Quaterniond::Identity(), {0, 0, 2}});
  const double radius_m = EstimateCloudNormals(points, WithoutDepthNoise(), {}).radius_m;
  points.resize(2 * points.size(), Eigen::Vector3f::Zero());
  const CloudNormals result = EstimateCloudNormals(points, WithoutDepthNoise(), {});
  EXPECT_EQ(result.missing, 5000);
  EXPECT_NEAR(result.radius_m, radius_m, 0.1 * radius_m);
}

TEST(CloudNormals, IsTheSameAtAnyNumberOfThreads) {
  const Points points = Rectangle(1, 1, 5000, 0.002);
  const auto results =
      AtThreads({1, 4}, [&] { return EstimateCloudNormals(points, WithoutDepthNoise(), {}); });
  EXPECT_EQ(results[0].normals, results[1].normals);
  EXPECT_EQ(results[0].deviation_m, results[1].deviation_m);
}

TEST(CloudNormals, RejectsInvalidOptions) {
  CloudNormalOptions options;
  options.radius_m = -1;
  ExpectInputError([&] { EstimateCloudNormals({}, {}, options); }, Names("radius_m", -1));
  options = {};
  options.min_neighbors = 3;
  ExpectInputError([&] { EstimateCloudNormals({}, {}, options); }, Names("min_neighbors", 3, 4));
}

}  // namespace
}  // namespace surfit::testing
