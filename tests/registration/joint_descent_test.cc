#include "registration/joint_descent.h"

#include <gtest/gtest.h>

#include "registration/simulated_views.h"
#include "registration/view_fit.h"
#include "testing/matchers.h"

namespace surfit {
namespace {

using testing::RigidNear;

// A textured wall at 1.5 m that fills the view: its shape leaves open a shift along it and a turn
// about its normal.
struct WallViews {
  ColoredView source, target;
  std::vector<BrightnessLevel> source_brightness, target_brightness;
  Rigid3d target_from_source;

  explicit WallViews(const Rigid3d& pose) : target_from_source(pose) {
    const Scene scene = MakeScene("wall");
    Eigen::Matrix3d along_y;
    along_y << 1, 0, 0, 0, 0, 1, 0, -1, 0;
    const Rigid3d world_from_source(along_y, Eigen::Vector3d(0, 0.5, 1));
    source = testing::MakeColoredView(scene, world_from_source);
    target = testing::MakeColoredView(scene, world_from_source * pose.Inverse());
    source_brightness = BrightnessPyramid(source.color, 160, 120, 1);
    target_brightness = BrightnessPyramid(target.color, 160, 120, 1);
  }
  ViewLevel Source() const { return {source.pyramid.levels[0], source_brightness[0]}; }
  ViewLevel Target() const { return {target.pyramid.levels[0], target_brightness[0]}; }
};

const Rigid3d kAlongTheWall(QuaternionExp<double>({0, 0, 0.02}), {0.015, -0.01, 0});
// A tenth of a pixel, which is 11 mm at 1.5 m.
constexpr double kToleranceM = 0.0011, kToleranceRad = 0.0008;

DescentOptions Precise() {
  DescentOptions options;
  options.max_steps = 30;
  options.max_distance_m = options.max_distance_end_m = 0.1;
  options.damping = 1e-4;
  return options;
}

TEST(Descend, BrightnessHoldsWhatAWallLeavesOpen) {
  const WallViews views(kAlongTheWall);
  EXPECT_THAT(Descend(views.Source(), views.Target(), Rigid3d(), Precise()),
              RigidNear(kAlongTheWall, kToleranceM, kToleranceRad));
}

TEST(Descend, ShapesAloneDoNotMoveAlongAWall) {
  const WallViews views(kAlongTheWall);
  DescentOptions options = Precise();
  options.use_brightness = false;
  EXPECT_THAT(Descend(views.Source(), views.Target(), Rigid3d(), options),
              RigidNear(Rigid3d(), kToleranceM, kToleranceRad));
}

TEST(Descend, BearsAnotherExposure) {
  WallViews views(kAlongTheWall);
  for (float& value : views.source_brightness[0].value) value = 0.8f * value + 0.1f;
  EXPECT_THAT(Descend(views.Source(), views.Target(), Rigid3d(), Precise()),
              RigidNear(kAlongTheWall, kToleranceM, kToleranceRad));
}

TEST(Descend, TurnsOnlyIfToldSo) {
  const WallViews views(Rigid3d(QuaternionExp<double>({0.02, -0.03, 0.01}), {0, 0, 0}));
  DescentOptions options = Precise();
  options.rotation_only = true;
  const Rigid3d pose = Descend(views.Source(), views.Target(), Rigid3d(), options);
  EXPECT_EQ(pose.translation, Eigen::Vector3d::Zero());
  EXPECT_THAT(pose, RigidNear(views.target_from_source, 0., kToleranceRad));
}

// At the true pose a view fits; shifted towards the camera its points fill free space, and shifted
// along the wall its texture does not fit.
TEST(MeasureFit, TellsWhatDoesNotFit) {
  const WallViews views((Rigid3d()));
  const auto fit_after = [&](double x_m, double z_m) {
    return MeasureFit(views.Source(), views.Target(), ErrorModel(),
                      Rigid3d(Eigen::Quaterniond::Identity(), {x_m, 0, z_m}));
  };
  const ViewFit right = fit_after(0, 0), near = fit_after(0, -0.2), along = fit_after(0.1, 0);
  EXPECT_GT(right.overlap_share, 0.9);
  EXPECT_EQ(right.free_space_share, 0);
  EXPECT_NEAR(right.value_correlation, 1, 0.05);  // less the floor of the variance
  EXPECT_NEAR(right.detail_correlation, 1, 0.05);
  EXPECT_EQ(near.overlap_share, 0);
  EXPECT_EQ(near.free_space_share, 1);
  EXPECT_LT(along.detail_correlation, 0.5);
  EXPECT_GT(right.Score(), along.Score());
  EXPECT_GT(along.Score(), near.Score());
}

}  // namespace
}  // namespace surfit
