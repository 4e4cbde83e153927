
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "registration/global/initial_pose_search.h"
#include "registration/global/view_fit.h"
#include "registration/simulated_views.h"
#include "surfit/core/parallel.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/registration/global_registration.h"
#include "testing/matchers.h"
#include "testing/pixels.h"

namespace surfit::testing {

namespace {

struct WallViews : WallScene {
  using WallScene::WallScene;
  std::vector<BrightnessLevel> source_brightness = BrightnessPyramid(source.color, 160, 120, 1);
  std::vector<BrightnessLevel> target_brightness = BrightnessPyramid(target.color, 160, 120, 1);

  ViewLevel Source() const { return {source.pyramid.levels[0], source_brightness[0]}; }
  ViewLevel Target() const { return {target.pyramid.levels[0], target_brightness[0]}; }
};

DescentOptions Precise() {
  DescentOptions options;
  options.max_steps = 30;
  options.max_distance_m = options.max_distance_end_m = 0.1;
  options.damping = 1e-4;
  return options;
}

// A single point over a target with linear brightness. The brightness adds j j^T / sigma^2 to the
// Hessian, where j is the derivative of the brightness by the left increment. Central differences
// of the projection approximate j to 1e-6. Images are floats: 1e-4 of the largest value.
TEST(LinearizeJointly, BrightnessAgreesWithCentralDifferences) {
  constexpr float kSlopeU = 0.003f, kSlopeV = -0.002f;
  WallViews views((Rigid3d()));
  FrameLevel& source = views.source.pyramid.levels[0];
  const int u = 130, v = 20;
  const Eigen::Vector3f only = source.vertex(u, v);
  ASSERT_GT(only.z(), 0);
  source.vertex = VectorImage(160, 120);
  source.vertex.Set(u, v, only);
  Image<float>& brightness = views.target_brightness[0].value;
  for (const auto [x, y] : PixelsOf(160, 120)) {
    brightness(x, y) = kSlopeU * static_cast<float>(x) + kSlopeV * static_cast<float>(y);
  }
  const Matrix6d added =
      LinearizeJointly(views.Source(), views.Target(), {0.1, true}, Rigid3d()).hessian -
      LinearizeJointly(views.Source(), views.Target(), {0.1, false}, Rigid3d()).hessian;

  Vector6d row;
  for (int i = 0; i < 6; ++i) {
    constexpr double kStep = 1e-4;
    const auto seen = [&](double step) {
      const Rigid3d moved = LeftIncrement<double>(step * Vector6d::Unit(i), Rigid3d());
      const Eigen::Vector2d pixel = source.camera.Project(moved * only.cast<double>());
      return kSlopeU * pixel.x() + kSlopeV * pixel.y();
    };
    row[i] = (seen(kStep) - seen(-kStep)) / (2 * kStep);
  }
  const Matrix6d expected = row * row.transpose();
  const double inverse_variance = added.trace() / expected.trace();
  EXPECT_NEAR(std::sqrt(1 / inverse_variance), 0.05, 1e-4);
  EXPECT_LT((added / inverse_variance - expected).norm(), 1e-4 * expected.norm());
}

// The wall is at 1.5 m. If the depth noise equals the geometric noise of 20 mm, the weights are
// halved.
TEST(LinearizeJointly, WeightsGeometryByNoiseOfSource) {
  const auto weight = [](double inverse_depth_sigma) {
    WallViews views((Rigid3d()));
    views.source.pyramid.levels[0].noise.inverse_depth_sigma = inverse_depth_sigma;
    return LinearizeJointly(views.Source(), views.Target(), {0.1, false}, Rigid3d()).weight;
  };
  EXPECT_NEAR(weight(0.02 / (1.5 * 1.5)) / weight(0), 0.5, 1e-4);
}

// Points at the image border have no normals.
TEST(LinearizeJointly, UsesEveryNthColumnAndRow) {
  const WallViews views((Rigid3d()));
  const auto pairs = [&](int stride) {
    return LinearizeJointly(views.Source(), views.Target(), {0.1, true, stride}, Rigid3d())
        .pair_count;
  };
  EXPECT_GT(pairs(1), 0.9 * 160 * 120);
  EXPECT_NEAR(pairs(2), pairs(1) / 4., 0.03 * pairs(1));
  EXPECT_NEAR(pairs(4), pairs(1) / 16., 0.01 * pairs(1));
}

// A quarter of the points converges to the same pose with twice the error.
TEST(Descend, ConvergesWithQuarterOfPoints) {
  const WallViews views(AlongTheWall());
  DescentOptions options = Precise();
  options.stride = 2;
  EXPECT_THAT(Descend(views.Source(), views.Target(), Rigid3d(), options),
              RigidNear(AlongTheWall(), 2 * kWallToleranceM, 2 * kWallToleranceRad));
}

TEST(Descend, BrightnessConstrainsMotionAlongWall) {
  const WallViews views(AlongTheWall());
  EXPECT_THAT(Descend(views.Source(), views.Target(), Rigid3d(), Precise()),
              RigidNear(AlongTheWall(), kWallToleranceM, kWallToleranceRad));
}

TEST(Descend, DoesNotMoveAlongWallByGeometryOnly) {
  const WallViews views(AlongTheWall());
  DescentOptions options = Precise();
  options.use_brightness = false;
  EXPECT_THAT(Descend(views.Source(), views.Target(), Rigid3d(), options),
              RigidNear(Rigid3d(), kWallToleranceM, kWallToleranceRad));
}

TEST(Descend, ToleratesOtherExposure) {
  WallViews views(AlongTheWall());
  for (float& value : views.source_brightness[0].value) value = 0.8f * value + 0.1f;
  EXPECT_THAT(Descend(views.Source(), views.Target(), Rigid3d(), Precise()),
              RigidNear(AlongTheWall(), kWallToleranceM, kWallToleranceRad));
}

// The view fits at the true pose. After a shift towards the camera, the points violate free space.
// After a shift along the wall, the texture does not fit.
TEST(MeasureFit, MeasuresFreeSpaceAndTexture) {
  const WallViews views((Rigid3d()));
  const auto fit_after = [&](double x_m, double z_m) {
    return MeasureFit(views.Source(), views.Target(), ErrorModel(),
                      Rigid3d(Eigen::Quaterniond::Identity(), {x_m, 0, z_m}));
  };
  const ViewFit right = fit_after(0, 0), near = fit_after(0, -0.2), along = fit_after(0.1, 0);
  EXPECT_GT(right.overlap_ratio, 0.9);
  EXPECT_EQ(right.free_space_violation_ratio, 0);
  EXPECT_NEAR(right.value_correlation, 1, 0.05);  // reduced by the minimum variance
  EXPECT_NEAR(right.detail_correlation, 1, 0.05);
  EXPECT_EQ(near.overlap_ratio, 0);
  EXPECT_EQ(near.free_space_violation_ratio, 1);
  EXPECT_LT(along.detail_correlation, 0.5);
  EXPECT_GT(right.Score(), along.Score());
  EXPECT_GT(along.Score(), near.Score());
}

TEST(RotationGrid, StartsWithIdentityAndReaches60Degrees) {
  const std::vector<Eigen::Quaterniond> grid = RotationGrid();
  EXPECT_EQ(RotationAngle(grid.front()), 0);
  for (std::size_t i = 1; i < grid.size(); ++i) {
    EXPECT_GE(RotationAngle(grid[i]), RotationAngle(grid[i - 1]) - 1e-9);
  }
  EXPECT_LE(RotationAngle(grid.back()), 60 * kRadPerDeg + 1e-9);
}

// The angle between two rotations is at most the distance of their rotation vectors. The largest
// distance to a body-centred lattice with cubes of 19 degrees is 19 sqrt(5) / 4 = 10.6 degrees.
TEST(RotationGrid, CoversAllRotations) {
  const std::vector<Eigen::Quaterniond> grid = RotationGrid();
  std::mt19937_64 generator(1);
  std::uniform_real_distribution<double> side(-28 * kRadPerDeg,
                                              28 * kRadPerDeg);  // |w| < 49 degrees
  for (int i = 0; i < 1000; ++i) {
    const auto any = QuaternionExp<double>({side(generator), side(generator), side(generator)});
    double nearest_rad = M_PI;
    for (const Eigen::Quaterniond& rotation : grid) {
      nearest_rad = std::min(nearest_rad, RotationAngle(rotation.conjugate() * any));
    }
    EXPECT_LE(nearest_rad, 10.7 * kRadPerDeg);
  }
}

}  // namespace

}  // namespace surfit::testing
