#include "surfit/evaluation/map_error.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <limits>

#include "surfit/core/error.h"
#include "testing/matchers.h"
#include "testing/random_pose.h"
#include "testing/threads.h"

namespace surfit::testing {
namespace {

using Cloud = std::vector<Eigen::Vector3f>;

Cloud RandomPoints(int count, double size_m, int seed) {
  std::mt19937_64 rng(seed);
  Cloud points;
  for (int i = 0; i < count; ++i) {
    points.push_back(RandomVector(size_m, &rng).cast<float>());
  }
  return points;
}

// Grid of (2 n + 1)^2 points in the plane z = 0.
Cloud Grid(int n, float spacing_m) {
  Cloud points;
  for (int i = -n; i <= n; ++i) {
    for (int j = -n; j <= n; ++j) points.push_back({spacing_m * i, spacing_m * j, 0});
  }
  return points;
}

double BruteForceDistance(const Eigen::Vector3f& query, const Cloud& points) {
  double least = std::numeric_limits<double>::infinity();
  for (const Eigen::Vector3f& point : points) {
    least = std::min(least, (query.cast<double>() - point.cast<double>()).norm());
  }
  return least;
}

TEST(MapError, AgreesWithBruteForce) {
  const Cloud map = RandomPoints(1500, 1, 1), reference = RandomPoints(2500, 1, 2);
  const MapErrorOptions options{0.1};
  const MapError error = ComputeMapError(map, reference, {}, options);
  std::vector<double> to_reference;
  for (const auto& point : map) to_reference.push_back(BruteForceDistance(point, reference));
  const ErrorStatistics expected = Summarize(to_reference);
  // The tree compares squared distances in float. The nearest point has a relative error of about
  // 1e-7.
  EXPECT_NEAR(error.accuracy_m.mean, expected.mean, 1e-6 * expected.mean);
  EXPECT_NEAR(error.accuracy_m.median, expected.median, 1e-6 * expected.median);
  EXPECT_NEAR(error.accuracy_m.p90, expected.p90, 1e-6 * expected.p90);
  EXPECT_NEAR(error.accuracy_m.max, expected.max, 1e-6 * expected.max);
  const auto mapped = std::count_if(reference.begin(), reference.end(), [&](const auto& point) {
    return BruteForceDistance(point, map) <= 0.1;
  });
  EXPECT_GT(mapped, 100);
  EXPECT_LT(mapped, 2400);
  EXPECT_EQ(error.completeness, static_cast<double>(mapped) / 2500);
  EXPECT_EQ(error.map_points, 1500u);
  EXPECT_EQ(error.reference_points, 2500u);
}

// One half of a plane is mapped, 8 mm too far away.
TEST(MapError, IsShiftAndHalfCompletenessOfShiftedHalfPlane) {
  const Cloud reference = Grid(20, 0.125f);
  Cloud map;
  for (const auto& point : reference) {
    if (point.x() > 0) map.push_back(point + Eigen::Vector3f(0, 0, 0.0078125f));
  }
  const MapError error = ComputeMapError(map, reference, {}, MapErrorOptions());
  EXPECT_EQ(error.accuracy_m.mean, 0.0078125);
  EXPECT_EQ(error.accuracy_m.max, 0.0078125);
  EXPECT_EQ(error.completeness, 20. / 41);
  EXPECT_FALSE(error.plane_accuracy_m.has_value());
}

TEST(MapError, CompletenessDistanceIsInclusive) {
  const Cloud reference = {{0, 0, 0}}, map = {{0.25f, 0, 0}};
  EXPECT_EQ(ComputeMapError(map, reference, {}, {0.25}).completeness, 1);
  EXPECT_EQ(ComputeMapError(map, reference, {}, {0.2499}).completeness, 0);
}

// Random map points at height h over a grid of spacing s. The distance to the plane is h. For h =
// 0, the mean distance to the nearest grid point is s (sqrt(2) + ln(1 + sqrt(2))) / 6 = 0.3826 s.
TEST(MapError, PlaneAccuracyIsIndependentOfSpacing) {
  const Cloud reference = Grid(20, 0.1f);
  const Cloud normals(reference.size(), Eigen::Vector3f(0, 0, -1));
  const int count = 20000;
  Cloud map = RandomPoints(count, 2, 3);
  for (auto& point : map) point.z() = 0;
  const MapError flat = ComputeMapError(map, reference, normals, MapErrorOptions());
  // 5 sigma / sqrt(N). The standard deviation of the distance is 0.143 s.
  EXPECT_NEAR(flat.accuracy_m.mean, 0.03826, 5 * 0.0143 / std::sqrt(count));
  EXPECT_EQ(flat.plane_accuracy_m->max, 0);
  for (auto& point : map) point.z() = 0.25f;
  const MapError lifted = ComputeMapError(map, reference, normals, MapErrorOptions());
  EXPECT_EQ(lifted.plane_accuracy_m->median, 0.25);
  EXPECT_GT(lifted.accuracy_m.median, 0.25);
}

TEST(MapError, UsesPlaneOfNearestPoint) {
  const Cloud reference = {{-2, 0, 0}, {0, 0, 0}, {0, 3, 0}};
  const Cloud normals = {{1, 0, 0}, {0, 0, 1}, {0, 1, 0}};
  const MapError error = ComputeMapError({{0.5f, 0.25f, 0.125f}}, reference, normals, {});
  EXPECT_EQ(error.plane_accuracy_m->max, 0.125);
}

TEST(MapError, IgnoresNonFinitePoints) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  const Cloud map = {{kNan, 0, 0}, {0, 0, 0}}, reference = {{0, 0, 1}, {0, 0, 0}, {0, kNan, 0}};
  const Cloud normals = {{1, 0, 0}, {0, 0, 1}, {1, 0, 0}};
  const MapError error = ComputeMapError(map, reference, normals, MapErrorOptions());
  EXPECT_EQ(error.map_points, 1u);
  EXPECT_EQ(error.reference_points, 2u);
  EXPECT_EQ(error.accuracy_m.max, 0);
  EXPECT_EQ(error.completeness, 0.5);
}

struct Mesh {
  Cloud vertices;
  std::vector<Eigen::Vector3i> triangles;
};

Mesh RandomMesh(int triangles, int seed) {
  Mesh mesh{RandomPoints(3 * triangles, 1, seed), {}};
  for (int i = 0; i < triangles; ++i) mesh.triangles.emplace_back(3 * i, 3 * i + 1, 3 * i + 2);
  return mesh;
}

// Smallest distance to points on a fine grid of the triangle. The distance to the triangle is
// smaller by at most the grid spacing.
double DistanceToGrid(const Eigen::Vector3f& query, const Mesh& mesh, const Eigen::Vector3i& t) {
  constexpr int kSteps = 60;
  const Eigen::Vector3f &a = mesh.vertices[t.x()], &b = mesh.vertices[t.y()],
                        &c = mesh.vertices[t.z()];
  float least = std::numeric_limits<float>::infinity();
  for (int i = 0; i <= kSteps; ++i) {
    for (int j = 0; i + j <= kSteps; ++j) {
      const Eigen::Vector3f point = a + (b - a) * i / kSteps + (c - a) * j / kSteps;
      least = std::min(least, (query - point).norm());
    }
  }
  return least;
}

TEST(MapErrorOfMesh, AgreesWithDistancesToFineGrids) {
  const Mesh mesh = RandomMesh(40, 1);
  for (const Eigen::Vector3f& query : RandomPoints(30, 2, 2)) {
    double expected = std::numeric_limits<double>::infinity();
    for (const auto& t : mesh.triangles)
      expected = std::min(expected, DistanceToGrid(query, mesh, t));
    const MapError error = ComputeMapErrorOfMesh({query}, mesh.vertices, mesh.triangles, {0.5});
    EXPECT_LE(error.accuracy_m.max, expected + 1e-6);
    // Edges are at most 2 sqrt(3) m long, and a point is at most half of a grid diagonal away.
    EXPECT_GE(error.accuracy_m.max, expected - 2 * std::sqrt(3.) / 60);
  }
}

// Each triangle is 1 m large, so distances to its vertices would be about 0.5 m.
TEST(MapErrorOfMesh, IsTheHeightAboveLargeTrianglesAndTheShareOfTheirArea) {
  const Cloud vertices = {{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {0, 1, 0}};
  Cloud map;
  for (int i = 0; i <= 100; ++i) {
    for (int j = 0; j <= 100; ++j) map.push_back({0.01f * i, 0.01f * j, 0.0078125f});
  }
  const MapError error =
      ComputeMapErrorOfMesh(map, vertices, {{0, 1, 2}, {0, 2, 3}, {0, 0, 1}}, {0.0125});
  EXPECT_NEAR(error.accuracy_m.mean, 0.0078125, 1e-9);
  EXPECT_NEAR(error.accuracy_m.max, 0.0078125, 1e-9);
  EXPECT_FALSE(error.plane_accuracy_m);
  EXPECT_EQ(error.reference_triangles, 3u);
  EXPECT_NEAR(error.reference_points, 2 / (0.00625 * 0.00625), 1);
  EXPECT_NEAR(error.completeness, 0.505, 0.002);  // 1 m of 2 m, and half of 0.0125 m around it
}

TEST(MapErrorOfMesh, IsTheSameAtAnyNumberOfThreads) {
  const Cloud map = RandomPoints(20000, 1, 1);
  const Mesh mesh = RandomMesh(500, 2);
  const auto errors = AtThreads(
      {1, 4}, [&] { return ComputeMapErrorOfMesh(map, mesh.vertices, mesh.triangles, {0.03}); });
  EXPECT_EQ(errors[0].accuracy_m.rmse, errors[1].accuracy_m.rmse);
  EXPECT_EQ(errors[0].completeness, errors[1].completeness);
}

TEST(MapErrorOfMesh, RejectsMeshWithoutAreaAndInvalidIndex) {
  const Cloud map = {{0, 0, 0}}, line = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  EXPECT_THAT(
      [&] {
        ComputeMapErrorOfMesh(map, line, {{0, 1, 2}}, {});
      },
      ThrowsNaming<InputError>("area", 0));
  EXPECT_THAT(
      [&] {
        ComputeMapErrorOfMesh(map, line, {{0, 1, 3}}, {});
      },
      ThrowsNaming<InputError>("triangle", 3, 2));
  EXPECT_THAT([&] { ComputeMapErrorOfMesh(map, line, {}, {}); },
              ThrowsNaming<InputError>("mesh", "triangle"));
}

TEST(MapError, IsTheSameAtAnyNumberOfThreads) {
  const Cloud map = RandomPoints(20000, 1, 1), reference = RandomPoints(30000, 1, 2);
  const auto errors =
      AtThreads({1, 4}, [&] { return ComputeMapError(map, reference, {}, {0.03}); });
  EXPECT_EQ(errors[0].accuracy_m.mean, errors[1].accuracy_m.mean);
  EXPECT_EQ(errors[0].accuracy_m.rmse, errors[1].accuracy_m.rmse);
  EXPECT_EQ(errors[0].completeness, errors[1].completeness);
}

TEST(MapError, RejectsEmptyCloudByName) {
  const Cloud none, one = {{0, 0, 0}};
  EXPECT_THAT([&] { ComputeMapError(none, one, {}, MapErrorOptions()); },
              ThrowsNaming<InputError>("map"));
  EXPECT_THAT([&] { ComputeMapError(one, none, {}, MapErrorOptions()); },
              ThrowsNaming<InputError>("reference"));
  EXPECT_THAT([&] { ComputeMapError(one, one, {}, {-1}); },
              ThrowsNaming<InputError>("completeness_distance_m", -1));
}

}  // namespace
}  // namespace surfit::testing
