#include "surfit/mesh/mesh_surfels.h"

#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <random>

#include "surfit/core/error.h"
#include "testing/matchers.h"
#include "testing/threads.h"

namespace surfit::testing {
namespace {

// Surfels of a surface with random noise of positions and normals.
class NoisySurfels {
 public:
  NoisySurfels(float noise_m, float tilt) : height_(0, noise_m), tilt_(0, tilt) {}

  void Add(const Eigen::Vector3f& point, const Eigen::Vector3f& normal, float radius_m) {
    const Eigen::Vector3f tilted =
        normal + Eigen::Vector3f(tilt_(random_), tilt_(random_), tilt_(random_));
    cloud.points.push_back(point + height_(random_) * normal);
    cloud.normals.push_back(tilted.normalized());
    cloud.colors.push_back({200, 100, 50});
    cloud.radii_m.push_back(radius_m);
    cloud.confidences.push_back(10);
  }
  float Uniform(float low, float high) {
    return std::uniform_real_distribution<float>(low, high)(random_);
  }

  PointCloud cloud;

 private:
  std::mt19937_64 random_{1};
  std::normal_distribution<float> height_, tilt_;
};

constexpr float kSphereRadius = 0.3f;

// Sphere of 40000 surfels, with a spacing of about 5 mm.
PointCloud Sphere(float noise_m, float tilt) {
  NoisySurfels surfels(noise_m, tilt);
  const int count = 40000;
  for (int i = 0; i < count; ++i) {  // a spiral with constant steps in z
    const float z = 2 * (static_cast<float>(i) + 0.5f) / count - 1, r = std::sqrt(1 - z * z);
    const float angle = 2.3999632f * static_cast<float>(i);
    const Eigen::Vector3f normal(r * std::cos(angle), r * std::sin(angle), z);
    surfels.Add(kSphereRadius * normal, normal, 0.005f);
  }
  return surfels.cloud;
}

// Square of 1 m x 1 m at z = 0, seen from above, with a spacing of 5 mm and a circular hole in the
// middle.
PointCloud TornPlane(float noise_m, float tilt, float hole_m) {
  NoisySurfels surfels(noise_m, tilt);
  for (float x = -0.5f; x < 0.5f; x += 0.005f) {
    for (float y = -0.5f; y < 0.5f; y += 0.005f) {
      const Eigen::Vector3f point(x + surfels.Uniform(0, 0.005f), y + surfels.Uniform(0, 0.005f),
                                  0);
      if (point.norm() >= hole_m) surfels.Add(point, Eigen::Vector3f::UnitZ(), 0.005f);
    }
  }
  return surfels.cloud;
}

TriangleMesh Mesh(const PointCloud& cloud, const MeshOptions& options, MeshSummary* summary) {
  return MeshSurfels(cloud, options, summary);
}
TriangleMesh Mesh(const PointCloud& cloud, const MeshOptions& options = {}) {
  MeshSummary summary;
  return Mesh(cloud, options, &summary);
}

struct MeshTriangle {
  Eigen::Vector3f center, normal;
};
std::vector<MeshTriangle> TrianglesOf(const TriangleMesh& mesh) {
  std::vector<MeshTriangle> triangles;
  for (const auto& t : mesh.triangles) {
    const Eigen::Vector3f &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]],
                          &c = mesh.vertices[t[2]];
    triangles.push_back({(a + b + c) / 3, (b - a).cross(c - a).normalized()});
  }
  return triangles;
}

// Counts the triangles of each edge: in the direction of the edge, and in the opposite direction.
std::map<std::pair<std::uint32_t, std::uint32_t>, std::pair<int, int>> EdgesOf(
    const TriangleMesh& mesh) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::pair<int, int>> edges;
  for (const auto& t : mesh.triangles) {
    for (int i = 0; i < 3; ++i) {
      const std::uint32_t from = t[i], to = t[(i + 1) % 3];
      auto& [forward, backward] = edges[std::minmax(from, to)];
      ++(from < to ? forward : backward);
    }
  }
  return edges;
}

TEST(MeshSurfels, MakesClosedSphereFromExactSurfels) {
  const TriangleMesh mesh = Mesh(Sphere(0, 0));
  const auto edges = EdgesOf(mesh);
  for (const auto& [edge, count] : edges) ASSERT_EQ(count, std::make_pair(1, 1));
  // Euler's formula: vertices - edges + faces = 2.
  EXPECT_EQ(mesh.vertices.size() + mesh.triangles.size(), edges.size() + 2);
  // The kernel ends at 2.5 cells = 20 mm. It averages planes up to 0.02^2 / (2 * 0.3) = 0.7 mm
  // above the sphere. The weight (1 - d^2 / s^2)^2 reduces this to a quarter. Each of the two
  // smoothing passes adds the same error.
  const float most_m = 0.0007f;
  for (const Eigen::Vector3f& vertex : mesh.vertices)
    ASSERT_NEAR(vertex.norm(), kSphereRadius, most_m);
  for (const MeshTriangle& triangle : TrianglesOf(mesh))
    ASSERT_GT(triangle.normal.dot(triangle.center.normalized()), 0.9f);
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    ASSERT_GT(mesh.normals[i].dot(mesh.vertices[i].normalized()), 0.99f);
    ASSERT_EQ(mesh.colors[i], (Rgb8{200, 100, 50}));
  }
}

// The mesh has less than half of the noise of 2 mm and of 0.1 per axis of normals. An average over
// 20 surfels would leave a quarter. The curvature of the sphere causes the remaining error.
TEST(MeshSurfels, HalvesNoiseOfSphere) {
  const float noise_m = 0.002f, tilt = 0.1f;
  const TriangleMesh mesh = Mesh(Sphere(noise_m, tilt));
  double squares = 0, tilt_squares = 0;
  const auto triangles = TrianglesOf(mesh);
  for (const MeshTriangle& triangle : triangles) {
    const Eigen::Vector3f outward = triangle.center.normalized();
    squares += std::pow(triangle.center.norm() - kSphereRadius, 2);
    tilt_squares += (triangle.normal - outward).squaredNorm();
  }
  const auto count = static_cast<double>(triangles.size());
  std::printf("distance %.5f m rms, normals %.4f rms\n", std::sqrt(squares / count),
              std::sqrt(tilt_squares / count));
  EXPECT_LT(std::sqrt(squares / count), noise_m / 2);
  EXPECT_LT(std::sqrt(tilt_squares / count), std::sqrt(2.) * tilt / 2);
}

TEST(MeshSurfels, KeepsOnlyHoleOfPlane) {
  const float noise_m = 0.002f, hole_m = 0.1f;
  const TriangleMesh mesh = Mesh(TornPlane(noise_m, 0.1f, hole_m));
  double squares = 0, area = 0;
  for (const auto& t : mesh.triangles) {
    const Eigen::Vector3f &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]],
                          &c = mesh.vertices[t[2]];
    area += (b - a).cross(c - a).norm() / 2;
    const Eigen::Vector3f center = (a + b + c) / 3;
    // Margin of two surfel radii.
    ASSERT_GT(center.head<2>().norm(), hole_m - 0.01f);
    squares += center.z() * center.z();
  }
  EXPECT_LT(std::sqrt(squares / static_cast<double>(mesh.triangles.size())), noise_m / 3);
  // Error of both borders: at most two surfel radii.
  EXPECT_NEAR(area, 1 - M_PI * hole_m * hole_m, 4 * 0.01 + 2 * M_PI * hole_m * 0.01);
}

TEST(MeshSurfels, IsTheSameAtAnyNumberOfThreads) {
  const PointCloud cloud = Sphere(0.002f, 0.1f);
  MeshOptions options;
  options.max_triangles = 5000;
  const auto meshes = AtThreads({1, 2, 4}, [&] { return Mesh(cloud, options); });
  for (const TriangleMesh& mesh : meshes) {
    EXPECT_EQ(mesh.vertices, meshes[0].vertices);
    EXPECT_EQ(mesh.normals, meshes[0].normals);
    EXPECT_EQ(mesh.colors, meshes[0].colors);
    EXPECT_EQ(mesh.triangles, meshes[0].triangles);
  }
}

TEST(MeshSurfels, CountsRemovedPieces) {
  PointCloud cloud = TornPlane(0, 0, 0);
  NoisySurfels loose(0, 0);
  for (float x = 0; x < 0.05f; x += 0.005f)
    for (float y = 0; y < 0.05f; y += 0.005f)
      loose.Add({1 + x, y, 0.3f}, Eigen::Vector3f::UnitX(), 0.005f);
  cloud.points.insert(cloud.points.end(), loose.cloud.points.begin(), loose.cloud.points.end());
  cloud.normals.resize(cloud.points.size(), Eigen::Vector3f::UnitZ());
  cloud.colors.resize(cloud.points.size());
  cloud.radii_m.resize(cloud.points.size(), 0.005f);
  cloud.confidences.resize(cloud.points.size(), 10);
  MeshSummary summary;
  const TriangleMesh mesh = Mesh(cloud, {}, &summary);
  EXPECT_EQ(summary.components_dropped, 1u);
  EXPECT_GT(summary.triangles_dropped, 0u);
  EXPECT_EQ(summary.pieces, 1u);
  for (const Eigen::Vector3f& vertex : mesh.vertices) EXPECT_LT(vertex.x(), 0.6f);
  MeshOptions all;
  all.min_component_m = 0;
  const TriangleMesh with_it = Mesh(cloud, all, &summary);
  EXPECT_EQ(summary.components_dropped, 0u);
  EXPECT_EQ(summary.pieces, 2u);
  EXPECT_GT(with_it.triangles.size(), mesh.triangles.size());
}

// Between two planes with equal normals, at a distance of 3 cm, the field has another sign change.
TEST(MeshSurfels, HasNoSurfaceBetweenLayers) {
  PointCloud cloud = TornPlane(0, 0, 0);
  const PointCloud other = cloud;
  for (const Eigen::Vector3f& point : other.points) {
    cloud.points.push_back(point + Eigen::Vector3f(0, 0, 0.03f));
    cloud.normals.push_back(Eigen::Vector3f::UnitZ());
    cloud.colors.push_back({});
    cloud.radii_m.push_back(0.005f);
    cloud.confidences.push_back(10);
  }
  const TriangleMesh mesh = Mesh(cloud);
  std::size_t lower = 0, upper = 0;
  for (const Eigen::Vector3f& vertex : mesh.vertices)
    ++(std::abs(vertex.z()) < 0.002f           ? lower
       : std::abs(vertex.z() - 0.03f) < 0.002f ? upper
                                               : lower);
  for (const Eigen::Vector3f& vertex : mesh.vertices)
    ASSERT_LT(std::min(std::abs(vertex.z()), std::abs(vertex.z() - 0.03f)), 0.002f);
  EXPECT_GT(lower, 1000u);
  EXPECT_GT(upper, 1000u);
}

TEST(MeshSurfels, HasAtMostMaxTriangles) {
  MeshOptions options;
  MeshSummary summary;
  options.max_triangles = 2000;
  const TriangleMesh mesh = Mesh(Sphere(0, 0), options, &summary);
  EXPECT_LE(mesh.triangles.size(), 2000u);
  EXPECT_GT(mesh.triangles.size(), 1000u);
  EXPECT_GT(summary.triangles_found, 10000u);
  // The sides of the triangles are a = 36 mm. Their centres are a^2 / (6 R) = 0.7 mm below the
  // sphere. The error of the finer mesh is another 0.7 mm.
  EXPECT_GT(summary.decimation_m, 0);
  EXPECT_LT(summary.decimation_m, 0.003);
  for (const MeshTriangle& triangle : TrianglesOf(mesh))
    ASSERT_NEAR(triangle.center.norm(), kSphereRadius, 0.004);
}

// A gap wider than two surfel radii, but narrower than trim_distance_m, is closed only if the radii
// are unknown.
TEST(MeshSurfels, ExtendsToSurfelRadii) {
  PointCloud cloud = TornPlane(0, 0, 0.015f);
  MeshOptions options;
  options.cell_m = 0.004;
  const auto count_in_hole = [&] {
    const TriangleMesh mesh = Mesh(cloud, options);
    return std::count_if(mesh.vertices.begin(), mesh.vertices.end(),
                         [](const Eigen::Vector3f& v) { return v.head<2>().norm() < 0.004f; });
  };
  EXPECT_EQ(count_in_hole(), 0);
  cloud.radii_m.clear();
  cloud.confidences.clear();
  EXPECT_GT(count_in_hole(), 0);
}

TEST(MeshSurfels, RejectsInvalidOptionsAndClouds) {
  PointCloud cloud = TornPlane(0, 0, 0);
  const auto expect = [&](const MeshOptions& options, const auto&... names) {
    EXPECT_THAT([&] { Mesh(cloud, options); }, ThrowsNaming<InputError>(names...));
  };
  MeshOptions options;
  options.cell_m = 0;
  expect(options, "cell_m", 0);
  options.cell_m = 1e-9;
  expect(options, "cell_m");
  options = {};
  options.min_component_m = 5;
  expect(options, "cell_m", "trim_distance_m", "min_component_m");
  cloud.normals.assign(cloud.points.size(), Eigen::Vector3f::Zero());
  EXPECT_THROW(Mesh(cloud), InputError);
  cloud.normals.clear();
  EXPECT_THROW(Mesh(cloud), InputError);
}

TEST(MeshSurfels, RejectsPointThatIsNotFinite) {
  for (const float bad : {std::nanf(""), std::numeric_limits<float>::infinity()}) {
    PointCloud cloud = TornPlane(0, 0, 0);
    cloud.points[7].y() = bad;
    ExpectInputError([&] { Mesh(cloud); }, HasSubstr("point 7 has a coordinate that is not"));
  }
}

TEST(MeshSurfels, RejectsAttributeOfAnotherSize) {
  const PointCloud good = TornPlane(0, 0, 0);
  const auto expect = [&](const char* name, auto PointCloud::*attribute) {
    for (const int change : {-1, 1}) {
      PointCloud cloud = good;
      (cloud.*attribute).resize(good.points.size() + change);
      const std::string counts = Concat(name, " has ", good.points.size() + change,
                                        " elements, must have ", good.points.size());
      ExpectInputError([&] { Mesh(cloud); }, HasSubstr(counts));
    }
  };
  expect("normals", &PointCloud::normals);
  expect("colors", &PointCloud::colors);
  expect("radii_m", &PointCloud::radii_m);
  expect("confidences", &PointCloud::confidences);
}

}  // namespace
}  // namespace surfit::testing
