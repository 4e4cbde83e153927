#include "mapping/map/view_frustum.h"

#include <gtest/gtest.h>

#include "mapping/random_surfel.h"
#include "testing/random_pose.h"

namespace surfit::testing {
namespace {

// Bounds of a box around a point that projects to a pixel.
SurfelBounds BoxAt(double u, double v, double depth_m, float half_m, const Rigid3d& pose) {
  const Eigen::Vector3f middle = (pose * (depth_m * SmallCamera().Ray(u, v))).cast<float>();
  SurfelBounds bounds;
  bounds.Add(Eigen::Vector3f(middle.array() - half_m));
  bounds.Add(Eigen::Vector3f(middle.array() + half_m));
  return bounds;
}

TEST(ViewFrustum, SeesBoxesAroundVisiblePoints) {
  std::mt19937_64 rng(1);
  for (int trial = 0; trial < 2000; ++trial) {
    const Rigid3d pose = RandomPose(2, 5, &rng);
    const ViewFrustum frustum(PosedCamera(SmallCamera(), pose), 3);
    // Up to the border of the margin, except for rounding. Half of the boxes are points.
    const double u = Uniform(-2.99f, 66.99f, &rng), v = Uniform(-2.99f, 50.99f, &rng);
    const float half_m = trial % 2 == 0 ? 0 : Uniform(0, 1, &rng);
    EXPECT_TRUE(frustum.MaySee(BoxAt(u, v, Uniform(0.051f, 8, &rng), half_m, pose)));
  }
}

TEST(ViewFrustum, DoesNotSeeBoxesOutsideOrBehind) {
  std::mt19937_64 rng(2);
  for (int trial = 0; trial < 2000; ++trial) {
    const Rigid3d pose = RandomPose(2, 5, &rng);
    const ViewFrustum frustum(PosedCamera(SmallCamera(), pose), 3);
    // Up to 0.6 m, a centimetre is at least one pixel.
    const double depth_m = Uniform(0.1f, 0.6f, &rng), near = Uniform(-2, 66, &rng);
    EXPECT_FALSE(frustum.MaySee(BoxAt(-30, near, depth_m, 0.01f, pose)));
    EXPECT_FALSE(frustum.MaySee(BoxAt(97, near, depth_m, 0.01f, pose)));
    EXPECT_FALSE(frustum.MaySee(BoxAt(near, -30, depth_m, 0.01f, pose)));
    EXPECT_FALSE(frustum.MaySee(BoxAt(near, 81, depth_m, 0.01f, pose)));
    EXPECT_FALSE(frustum.MaySee(BoxAt(near, near, -depth_m, 0.01f, pose)));
  }
}

TEST(VisibleCells, AreCellsInViewInOrder) {
  SurfelMap map;
  Surfel s;
  for (const float x : {-9.f, 0.f, 9.f, 0.5f}) {
    s.position_in_world = {x, 0, 3};
    map.Append(s);
  }
  const ViewFrustum frustum(PosedCamera(SmallCamera(), {}), 0);
  EXPECT_EQ(VisibleCells(map, frustum), (std::vector<std::int32_t>{1, 3}));
}

}  // namespace
}  // namespace surfit::testing
