#include <gtest/gtest.h>

#include "registration/global/view_fit.h"
#include "registration/simulated_views.h"
#include "surfit/registration/icp.h"
#include "testing/pixels.h"

namespace surfit::testing {
namespace {

// A wall across the view. Its left part has a separate depth.
FrameLevel Wall(double left_depth_m, double right_depth_m, int left_columns) {
  FrameLevel level;
  level.camera = {40, 30, 40, 40, 19.5, 14.5, {}};
  level.vertex = VectorImage(40, 30);
  level.normal = VectorImage(40, 30);
  for (const auto [u, v] : PixelsOf(40, 30)) {
    const double depth_m = u < left_columns ? left_depth_m : right_depth_m;
    level.vertex.Set(u, v, (depth_m * level.camera.Ray(u, v)).cast<float>());
    level.normal.Set(u, v, {0, 0, -1});
  }
  return level;
}

double Share(const FrameLevel& source, const FrameLevel& target) {
  return FreeSpaceViolationRatio(source, target, ErrorModel(), Rigid3d());
}

TEST(FreeSpaceViolationRatio, CountsPointsInFrontOnly) {
  const FrameLevel wall = Wall(2, 2, 0), left_in_front = Wall(1, 2, 10), all_behind = Wall(4, 4, 0);
  EXPECT_EQ(Share(wall, wall), 0);
  EXPECT_EQ(Share(left_in_front, wall), 0.25);
  EXPECT_EQ(Share(wall, left_in_front), 0);
  EXPECT_EQ(Share(wall, all_behind), 1);
  EXPECT_EQ(Share(all_behind, wall), 0);
}

TEST(FreeSpaceViolationRatio, ToleratesNoiseOfBothDepths) {
  const ErrorModel model;
  const double sigma = std::hypot(model.Sigma(2, {}), DepthNoise().SigmaZ(2));
  // The noise of the nearer depth reduces the 5 sigmas at 2 m (6 cm) by 3 %.
  EXPECT_EQ(Share(Wall(2 - 4.7 * sigma, 2, 20), Wall(2, 2, 0)), 0);
  EXPECT_EQ(Share(Wall(2 - 5.3 * sigma, 2, 20), Wall(2, 2, 0)), 0.5);
}

TEST(FreeSpaceViolationRatio, UsesMovedPointsInTargetView) {
  const Rigid3d nearer(Eigen::Quaterniond::Identity(), {0, 0, -1});
  EXPECT_EQ(FreeSpaceViolationRatio(Wall(2, 2, 0), Wall(1, 1, 0), ErrorModel(), nearer), 0);
  EXPECT_EQ(FreeSpaceViolationRatio(Wall(2, 2, 0), Wall(2, 2, 0), ErrorModel(), nearer), 1);
  const Rigid3d behind(Eigen::Quaterniond::Identity(), {0, 0, -3});
  EXPECT_EQ(FreeSpaceViolationRatio(Wall(2, 2, 0), Wall(2, 2, 0), ErrorModel(), behind), 0);
}

TEST(FreeSpaceViolationRatio, IgnoresMissingDepth) {
  const FrameLevel half = Wall(0, 2, 20);
  EXPECT_EQ(Share(half, Wall(2, 2, 0)), 0);
  EXPECT_EQ(Share(Wall(1, 2, 20), half), 0);
  EXPECT_EQ(Share(Wall(1, 2, 30), half), 0.5);
  EXPECT_EQ(Share(half, Wall(0, 0, 0)), 0);
}

// Frames of rooms at distances of up to 30 frames, from the identity: many are outside the basin of
// convergence of ICP.
TEST(Register, RejectsFreeSpaceViolations) {
  IcpOptions options;
  int wrong = 0, right = 0;
  for (const std::uint64_t seed : {1, 2, 3}) {
    for (const int gap : {2, 8, 15, 30}) {
      const SimulatedViews views = MakeViews(3, gap, seed);
      const auto off_m = [&](const IcpResult& result) {
        return (result.target_from_source.translation - views.target_from_source.translation)
            .norm();
      };
      options.max_free_space_violation_ratio = 1;
      const IcpResult unchecked = Register(views.source, views.target, Rigid3d(), options);
      EXPECT_EQ(unchecked.free_space_violation_ratio, 0);
      options.max_free_space_violation_ratio = 0.02;
      const IcpResult result = Register(views.source, views.target, Rigid3d(), options);
      EXPECT_EQ(result.target_from_source.Matrix(), unchecked.target_from_source.Matrix());
      if (off_m(result) > 0.02) {
        EXPECT_FALSE(result.Succeeded());
        wrong += result.termination == Termination::kFreeSpaceViolation;
      }
      right += result.Succeeded();
    }
  }
  EXPECT_GE(wrong, 3);
  EXPECT_GE(right, 3);
}

}  // namespace
}  // namespace surfit::testing
