#include <gmock/gmock.h>

#include <string>

#include "registration/icp/photometric_term.h"
#include "registration/simulated_views.h"
#include "surfit/core/options.h"
#include "surfit/registration/association.h"
#include "surfit/registration/icp.h"
#include "surfit/registration/pose_solver.h"
#include "testing/matchers.h"

namespace surfit::testing {
namespace {

IcpOptions Options(double photometric_weight, const std::string& solver = "closed_form_ldlt") {
  IcpOptions options;
  options.solver = solver;
  options.error_model.photometric_weight = photometric_weight;
  return options;
}

class PhotometricSolvers : public ::testing::TestWithParam<std::string> {
 protected:
  WallFrames frames_{AlongTheWall()};
};

TEST_P(PhotometricSolvers, ConvergeAlongTexturedWall) {
  const IcpResult result =
      Register(frames_.source, frames_.target, Rigid3d(), Options(0.1, GetParam()));
  EXPECT_TRUE(result.Succeeded()) << ToString(result.termination);
  EXPECT_GT(result.intensity_count, 1000);
  EXPECT_THAT(result.target_from_source,
              RigidNear(frames_.target_from_source, kWallToleranceM, kWallToleranceRad));
}

TEST_P(PhotometricSolvers, WallIsDegenerateWithoutIntensities) {
  const IcpResult result =
      Register(frames_.source, frames_.target, Rigid3d(), Options(0, GetParam()));
  EXPECT_EQ(result.termination, Termination::kSingularSystem);
  EXPECT_EQ(result.degenerate_directions.size(), 3u);
  EXPECT_EQ(result.intensity_count, 0);
  EXPECT_THAT(result.target_from_source, RigidNear(Rigid3d(), kWallToleranceM, kWallToleranceRad));
}

TEST_P(PhotometricSolvers, TolerateOtherExposure) {
  frames_.ChangeExposure(0.8f, 0.1f);
  const IcpResult result =
      Register(frames_.source, frames_.target, Rigid3d(), Options(0.1, GetParam()));
  EXPECT_THAT(result.target_from_source,
              RigidNear(frames_.target_from_source, kWallToleranceM, kWallToleranceRad));
}

INSTANTIATE_TEST_SUITE_P(All, PhotometricSolvers,
                         ::testing::Values("closed_form_ldlt", "closed_form_lu", "closed_form_qr",
                                           "ceres", "ceres_per_point", "tiny"),
                         [](const auto& instance) { return instance.param; });

// Every third row of points, and intensities with a third of the weight, have a third of the
// information in each direction. Geometry constrains three directions, and intensities constrain
// the other three.
TEST(PhotometricIcp, ScalesIntensityWeightWithRowStride) {
  const WallFrames frames(AlongTheWall());
  IcpOptions options = Options(0.1);
  const IcpResult all = Register(frames.source, frames.target, Rigid3d(), options);
  options.min_source_rows = frames.source.levels[0].vertex.height() / 3;
  const IcpResult third = Register(frames.source, frames.target, Rigid3d(), options);
  for (int i = 0; i < 6; ++i) {
    EXPECT_NEAR(third.information(i, i), all.information(i, i) / 3, 0.05 * all.information(i, i))
        << i;
  }
}

Vector6d StepOf(const std::string& solver, const WallFrames& frames) {
  PoseSolverOptions options;
  options.name = solver;
  options.error_model.photometric_weight = 0.1;
  const FrameLevel &source = frames.source.levels[0], &target = frames.target.levels[0];
  const ProjectiveAssociation association(source, target, {}, options.error_model);
  const PhotometricTerm term(source, target, 0.1, options.error_model, Rigid3d());
  const auto pose_solver = MakePoseSolver(options);
  pose_solver->Use(term);
  return pose_solver->Step(association, Rigid3d()).increment;
}

// The tolerance is ten times larger than in solvers_test.cc, because one direction is weakly
// constrained.
TEST(PhotometricStep, AgreesBetweenPerPointAndReducedSolvers) {
  const WallFrames frames(AlongTheWall());
  const Vector6d reduced = StepOf("ceres", frames);
  EXPECT_GT(reduced.norm(), 0.002);
  EXPECT_THAT(StepOf("ceres_per_point", frames), VectorNear(reduced, 1e-6));
  EXPECT_THAT(StepOf("tiny", frames), VectorNear(reduced, 1e-6));
}

TEST(PhotometricStep, AgreesBetweenQrAndNormalEquations) {
  const WallFrames frames(AlongTheWall());
  const Vector6d system = StepOf("closed_form_ldlt", frames);
  EXPECT_THAT(StepOf("closed_form_lu", frames), VectorNear(system, 1e-9));
  EXPECT_THAT(StepOf("closed_form_qr", frames), VectorNear(system, 1e-4 * system.norm()));
}

TEST(PhotometricIcp, SupportsKdTreeAssociation) {
  const WallFrames frames(AlongTheWall());
  IcpOptions options = Options(0.1);
  options.association = "kd_tree";
  options.max_iterations = 30;
  EXPECT_THAT(Register(frames.source, frames.target, Rigid3d(), options).target_from_source,
              RigidNear(frames.target_from_source, kWallToleranceM, kWallToleranceRad));
}

TEST(PhotometricIcp, IsGeometricWithoutColor) {
  WallFrames frames(AlongTheWall());
  for (FrameLevel& level : frames.source.levels) level.intensity = {};
  const IcpResult result = Register(frames.source, frames.target, Rigid3d(), Options(0.1));
  const IcpResult expected = Register(frames.source, frames.target, Rigid3d(), Options(0));
  EXPECT_EQ(result.intensity_count, 0);
  EXPECT_EQ(result.termination, expected.termination);
  EXPECT_EQ(result.target_from_source.Matrix(), expected.target_from_source.Matrix());
  EXPECT_EQ(result.information, expected.information);
}

TEST(PhotometricIcp, RejectsSvd) {
  IcpOptions options = Options(0.1, "svd");
  options.residual = "point_to_point";
  ExpectInputError([&] { Validate(options); }, Names("svd"));
}

}  // namespace
}  // namespace surfit::testing
