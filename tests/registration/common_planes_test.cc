// Tests of the structure beside the largest common planes of two clouds.
#include "registration/global/common_planes.h"

#include <gmock/gmock.h>

#include <cmath>
#include <random>

#include "surfit/registration/register_clouds.h"

namespace surfit::testing {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

// Points on a plane through `origin` with the edges a and b.
void AddPlane(int count, const Vector3f& origin, const Vector3f& a, const Vector3f& b,
              std::mt19937_64* rng, std::vector<ComparedPoint>* points) {
  std::uniform_real_distribution<float> uniform(0, 1);
  for (int i = 0; i < count; ++i) {
    const float s = uniform(*rng), t = uniform(*rng);
    points->push_back({origin + s * a + t * b, a.cross(b).normalized(), true, true});
  }
}

// Corner of three planes with 300, 200 and 70 points, and a box face of 30 points.
std::vector<ComparedPoint> Corner() {
  std::mt19937_64 rng(1);
  std::vector<ComparedPoint> points;
  AddPlane(300, {0, 0, 0}, {2, 0, 0}, {0, 2, 0}, &rng, &points);
  AddPlane(200, {0, 0, 0}, {0, 2, 0}, {0, 0, 2}, &rng, &points);
  AddPlane(70, {0, 0, 0}, {0, 0, 2}, {2, 0, 0}, &rng, &points);
  AddPlane(30, {0.5f, 0.5f, 0.5f}, {0.2f, 0, 0}, {0, 0.2f, 0}, &rng, &points);
  return points;
}

TEST(CommonPlanes, AreTheLargestInOrder) {
  const std::vector<CommonPlane> planes = FindCommonPlanes(Corner(), 0.01);
  ASSERT_EQ(planes.size(), 3u);
  EXPECT_NEAR(std::abs(planes[0].normal.z()), 1, 1e-6);
  EXPECT_NEAR(std::abs(planes[1].normal.x()), 1, 1e-6);
  EXPECT_NEAR(std::abs(planes[2].normal.y()), 1, 1e-6);
  for (const CommonPlane& plane : planes) EXPECT_NEAR(plane.offset_m, 0, 1e-6);
}

TEST(CommonPlanes, AreAbsentWithoutPointsOnTheSurface) {
  std::vector<ComparedPoint> points = Corner();
  for (ComparedPoint& point : points) point.is_on_surface = false;
  EXPECT_TRUE(FindCommonPlanes(points, 0.01).empty());
  EXPECT_EQ(CountOffTwoPlanes(points, 0.01), 0);
}

// Points within 1 cm of the two larger planes are not counted: at most 2 % of the third plane.
TEST(CommonPlanes, LeaveThirdPlaneAndBoxToCount) {
  const int count = CountOffTwoPlanes(Corner(), 0.01);
  EXPECT_LE(count, 100);
  EXPECT_GE(count, 97);
}

// The image shows the corner without the box. So all points off the planes are in free space.
TEST(CommonPlanes, LeaveOnlyTheBoxToRefuteThePose) {
  std::mt19937_64 rng(2);
  std::vector<ComparedPoint> seen;
  AddPlane(40000, {0, 0, 0}, {2, 0, 0}, {0, 2, 0}, &rng, &seen);
  AddPlane(40000, {0, 0, 0}, {0, 2, 0}, {0, 0, 2}, &rng, &seen);
  AddPlane(40000, {0, 0, 0}, {0, 0, 2}, {2, 0, 0}, &rng, &seen);
  std::vector<Vector3f> image;
  for (const ComparedPoint& point : seen) image.push_back(point.point);
  const StructureCounts counts =
      CountStructure(Corner(), RangeImage(image, Vector3d(1.5, 1.5, 1.5), 0.01), 0.01, 0.03);
  EXPECT_EQ(counts.free_space, counts.visible);
  EXPECT_GE(counts.visible, 25);  // a few pixels of the image can be empty
  EXPECT_GE(counts.ViolationRatio(), 25. / 45);
}

// Corner of 2 m with a cube of 0.3 m at a position, seen from (1.8, 1.8, 1.8). The points have
// noise of 2 mm.
SensedCloud CornerWithCube(const Vector3d& cube, int seed) {
  constexpr double kStep_m = 0.02, kCube_m = 0.3;
  std::mt19937_64 rng(seed);
  std::uniform_real_distribution<double> shift(0, kStep_m);
  std::normal_distribution<double> noise(0, 0.002);
  const Vector3d viewpoint(1.8, 1.8, 1.8);
  SensedCloud cloud;
  cloud.viewpoint = viewpoint;
  cloud.has_viewpoint = true;
  cloud.has_signed_normals = true;
  const Eigen::AlignedBox3d box(cube, cube + Vector3d::Constant(kCube_m));
  const auto is_hidden = [&](const Vector3d& point) {
    const Vector3d way = point - viewpoint;
    for (double t = 0.2; t < 0.98; t += 0.02) {
      if (box.contains(viewpoint + t * way)) return true;
    }
    return false;
  };
  for (int axis = 0; axis < 3; ++axis) {
    const auto add = [&](double s, double t, double offset_m) {
      Vector3d point;
      point[axis] = offset_m + noise(rng);
      point[(axis + 1) % 3] = s + shift(rng);
      point[(axis + 2) % 3] = t + shift(rng);
      if (!is_hidden(point))
        cloud.points.Add(point.cast<float>(), Vector3d::Unit(axis).cast<float>(), 0.002f);
    };
    for (double s = 0; s < 2; s += kStep_m) {
      for (double t = 0; t < 2; t += kStep_m) add(s, t, 0);
    }
    for (double s = 0; s < kCube_m; s += kStep_m) {
      for (double t = 0; t < kCube_m; t += kStep_m) {
        add(cube[(axis + 1) % 3] + s, cube[(axis + 2) % 3] + t, cube[axis] + kCube_m);
      }
    }
  }
  return cloud;
}

// The corners agree in both cases. The cube is 2 % of the points.
TEST(CommonPlanes, DecideAboutPosesOfCorners) {
  CloudStartOptions start;
  start.method = "identity";
  RegisterCloudsOptions options;
  options.icp.gates.max_distance_m = 0;
  const SensedCloud target = CornerWithCube({0.3, 0.3, 0.6}, 1);
  const auto reason_of = [&](const Vector3d& cube) {
    return ToString(
        RegisterCloudsFrom(CornerWithCube(cube, 2), target, std::nullopt, start, options).reason);
  };
  EXPECT_EQ(reason_of({0.3, 0.3, 0.6}), "accepted");
  EXPECT_EQ(reason_of({0.6, 0.6, 0.2}), "free_space_violation");
}

}  // namespace
}  // namespace surfit::testing
