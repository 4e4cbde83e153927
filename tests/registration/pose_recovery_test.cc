// Pose test of BAD SLAM: three exact planes, with perturbations of every degree of freedom in both
// directions.
#include <gtest/gtest.h>

#include "registration/three_planes.h"
#include "surfit/registration/icp.h"
#include "surfit/registration/pose_solver.h"
#include "testing/matchers.h"
#include "testing/random_pose.h"

namespace surfit::testing {
namespace {

// Points within 2.5 m and poses are rounded to float, and p' = R p + t has three more roundings. In
// the worst case, the common error of all p' is 5 * 2^-24 * 2.5 m = 7e-7 m.
constexpr double kExactToM = 1e-6;
constexpr double kExactToRad = 1e-6;

class PoseRecovery : public ::testing::TestWithParam<std::string> {};

// "solver_with_residual", for residuals that vanish in this test. The other residuals do not:
// projective correspondences differ by up to half a pixel along the surface.
std::vector<std::string> SurfaceCombinations() {
  std::vector<std::string> all;
  for (const std::string& solver : PointToPlaneSolverNames()) {
    for (const char* residual : {"point_to_plane", "symmetric_point_to_plane"}) {
      all.push_back(solver + "_with_" + residual);
    }
  }
  return all;
}

TEST_P(PoseRecovery, ConvergesFromEveryDirection) {
  const Rigid3d world_from_target = PoseBeforeTheCorner();
  Vector6d motion;
  motion << 0.01, -0.02, 0.015, 0.02, 0.01, -0.03;
  const Rigid3d target_from_source = LeftIncrement(motion, Rigid3d());
  const FramePyramid target = OneLevel(RenderCorner(world_from_target));
  const FramePyramid source = OneLevel(RenderCorner(world_from_target * target_from_source));
  IcpOptions options;
  const std::size_t with = GetParam().find("_with_");
  options.solver = GetParam().substr(0, with);
  options.residual = GetParam().substr(with + 6);
  options.max_iterations = 20;
  options.min_relative_rmse_change = 0;
  options.min_increment = 1e-7;
  for (const Vector6d& perturbation : EachDirection(0.5 * M_PI / 180, 0.01)) {
    const IcpResult result =
        Register(source, target, LeftIncrement(perturbation, target_from_source), options);
    EXPECT_TRUE(result.Succeeded());
    EXPECT_THAT(result.target_from_source, RigidNear(target_from_source, kExactToM, kExactToRad))
        << perturbation.transpose();
    EXPECT_LT(result.rmse_m, kExactToM);
  }
}

INSTANTIATE_TEST_SUITE_P(All, PoseRecovery, ::testing::ValuesIn(SurfaceCombinations()),
                         [](const auto& instance) { return instance.param; });

// Nearest neighbours are other correspondences of the same planes. The normal gate rejects
// correspondences across an edge.
TEST(Register, FindsSamePoseByNearestNeighbours) {
  const Rigid3d world_from_target = PoseBeforeTheCorner();
  const Rigid3d target_from_source(QuaternionExp<double>({0.01, -0.02, 0.015}),
                                   {0.02, 0.01, -0.03});
  IcpOptions options;
  options.association = "kd_tree";
  options.max_iterations = 20;
  options.min_relative_rmse_change = 0;
  options.min_increment = 1e-7;
  const IcpResult result = Register(OneLevel(RenderCorner(world_from_target * target_from_source)),
                                    OneLevel(RenderCorner(world_from_target)), Rigid3d(), options);
  EXPECT_TRUE(result.Succeeded());
  EXPECT_THAT(result.target_from_source, RigidNear(target_from_source, kExactToM, kExactToRad));
}

// The result depends on the relative pose of the cameras only, not on the origin of the world.
TEST(Register, IsIndependentOfWorldFrame) {
  const Rigid3d world_from_target = PoseBeforeTheCorner();
  const FramePyramid target = OneLevel(RenderCorner(world_from_target));
  const IcpResult result = Register(target, target, Rigid3d(), IcpOptions());
  EXPECT_THAT(result.target_from_source, RigidNear(Rigid3d(), kExactToM, kExactToRad));
  EXPECT_EQ(result.inlier_count, 160 * 120);
  EXPECT_EQ(result.inlier_ratio, 1);
  EXPECT_GT(result.eigenvalues[0], 1e-3);
}

}  // namespace
}  // namespace surfit::testing
