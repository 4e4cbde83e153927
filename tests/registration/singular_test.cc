#include <gtest/gtest.h>

#include "registration/random_correspondences.h"
#include "registration/three_planes.h"
#include "surfit/registration/icp.h"
#include "surfit/registration/pose_solver.h"
#include "testing/matchers.h"

namespace surfit::testing {
namespace {

// Correspondences on surfaces that are invariant to some motions. Noise is along the normals.
struct Surface {
  Correspondences pairs;
  std::vector<Vector6d> free;  // unobservable increments
};

Vector6d Twist(const Eigen::Vector3d& w, const Eigen::Vector3d& v) {
  Vector6d twist;
  twist << w, v;
  return twist;
}

void AddPair(const Eigen::Vector3d& p, const Eigen::Vector3d& n, std::mt19937_64* rng,
             Correspondences* pairs) {
  pairs->Add(p, p + RandomVector(0.01, rng).x() * n, n, n, 1);
}

Surface OnPlane(std::mt19937_64* rng) {
  Surface plane;
  for (int i = 0; i < 500; ++i) {
    Eigen::Vector3d p = RandomVector(1, rng);
    p.z() = 2;
    AddPair(p, {0, 0, -1}, rng, &plane.pairs);
  }
  const Eigen::Vector3d zero(0, 0, 0);
  plane.free = {Twist({0, 0, 1}, zero), Twist(zero, {1, 0, 0}), Twist(zero, {0, 1, 0})};
  return plane;
}

Surface OnSphere(std::mt19937_64* rng) {
  const Eigen::Vector3d center(0.1, 0.2, 3);
  Surface sphere;
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector3d n = RandomVector(1, rng).normalized();
    AddPair(center + 0.7 * n, n, rng, &sphere.pairs);
  }
  for (int i = 0; i < 3; ++i) {  // rotations about the centre: w x (p - c)
    const Eigen::Vector3d w = Eigen::Vector3d::Unit(i);
    sphere.free.push_back(Twist(w, -w.cross(center)));
  }
  return sphere;
}

// Two walls, floor and ceiling along z.
Surface OnCorridor(std::mt19937_64* rng) {
  Surface corridor;
  for (int i = 0; i < 500; ++i) {
    Eigen::Vector3d p = Eigen::Vector3d(0, 0, 4) + 2 * RandomVector(1, rng);
    const int axis = i % 2;
    const double side = i % 4 < 2 ? -1 : 1;
    p[axis] = side;
    AddPair(p, -side * Eigen::Vector3d::Unit(axis), rng, &corridor.pairs);
  }
  corridor.free = {Twist({0, 0, 0}, {0, 0, 1})};
  return corridor;
}

class Singular : public ::testing::TestWithParam<Surface (*)(std::mt19937_64*)> {};

// For all solvers, the increment is zero along unobservable directions, and converges along the
// other directions.
TEST_P(Singular, MovesOnlyAlongObservableDirections) {
  std::mt19937_64 rng(1);
  const Surface surface = GetParam()(&rng);
  const int degenerate_count = static_cast<int>(surface.free.size());
  Vector6d first_increment = Vector6d::Zero();
  for (const std::string& name : PointToPlaneSolverNames()) {
    PoseSolverOptions options;
    options.name = name;
    options.error_model.kernel.type = RobustKernelType::kNone;
    const StepResult step = MakePoseSolver(options)->Step(surface.pairs);
    const Observability& seen = step.observability;
    EXPECT_TRUE(seen.Degenerate()) << name;
    ASSERT_EQ(seen.degenerate_count, degenerate_count) << name;
    EXPECT_NEAR(seen.eigenvalues[degenerate_count - 1], 0, 1e-14);
    EXPECT_GT(seen.eigenvalues[degenerate_count], 1e-3);
    // The found directions span the known unobservable directions.
    for (const Vector6d& direction : surface.free) {
      EXPECT_THAT(seen.Held(direction), VectorNear(Vector6d::Zero().eval(), 1e-7)) << name;
    }
    EXPECT_TRUE(step.increment.allFinite());
    EXPECT_GT(step.increment.norm(), 1e-5) << name;
    EXPECT_LT(step.increment.norm(), 0.01) << name;
    const Vector6d along = step.increment - seen.Held(step.increment);
    EXPECT_THAT(along, VectorNear(Vector6d::Zero().eval(), 1e-12)) << name;
    if (name == "closed_form_ldlt") first_increment = step.increment;
    // Levenberg-Marquardt converges to the minimum. The error of a Gauss-Newton step is the square
    // of 2e-3.
    EXPECT_THAT(step.increment, VectorNear(first_increment, 1e-4)) << name;
  }
}

std::string SurfaceName(const ::testing::TestParamInfo<Singular::ParamType>& info) {
  const char* const names[] = {"plane", "sphere", "corridor"};
  return names[info.index];
}

INSTANTIATE_TEST_SUITE_P(Surfaces, Singular, ::testing::Values(OnPlane, OnSphere, OnCorridor),
                         SurfaceName);

TEST(SingularSystem, IsSingularWithoutPairs) {
  for (const std::string& name : PointToPlaneSolverNames()) {
    PoseSolverOptions options;
    options.name = name;
    const StepResult step = MakePoseSolver(options)->Step(Correspondences());
    EXPECT_EQ(step.observability.degenerate_count, 6) << name;
    EXPECT_TRUE(step.increment.isZero(0)) << name;
  }
}

// Images with only one or two of three planes, with a motion.
class SingularImages : public ::testing::TestWithParam<std::string> {};

TEST_P(SingularImages, ReportSingularSystem) {
  IcpOptions options;
  options.solver = GetParam();
  const Rigid3d world_from_target = PoseBeforeTheCorner();
  const Rigid3d offset(QuaternionExp<double>({0.003, -0.002, 0.004}), {0.006, -0.004, 0.005});
  // Rounding errors of float normals (2^-24) constrain the unobservable direction with their
  // square.
  for (const int planes : {1, 2}) {
    const FramePyramid target = OneLevel(RenderCorner(world_from_target, planes));
    const IcpResult result = Register(target, target, offset, options);
    EXPECT_EQ(result.termination, Termination::kSingularSystem) << planes;
    EXPECT_FALSE(result.Succeeded());
    EXPECT_LT(result.eigenvalues[0], options.observability.min_eigenvalue);
    EXPECT_FALSE(result.covariance);
    EXPECT_TRUE(result.target_from_source.Matrix().allFinite());
    EXPECT_GT(result.inlier_count, 8000);
    // Observable directions converge. Unobservable directions keep their initial values.
    EXPECT_LT(result.rmse_m, 1e-5);
    const Rigid3d off = world_from_target * result.target_from_source * offset.Inverse() *
                        world_from_target.Inverse();
    EXPECT_EQ(result.degenerate_directions.size(), planes == 1 ? 3u : 1u);
    if (planes == 2) {  // planes x = 0 and y = 0: unobservable along z
      EXPECT_NEAR((off * world_from_target.translation - world_from_target.translation).z(), 0,
                  1e-4);
    }
  }
}

// With noisy normals, a plane seems to constrain all directions. With min_information_ratio,
// directions with only spurious information keep their initial values, to first order.
TEST(Register, IgnoresSpuriousInformationOfNormalNoise) {
  std::mt19937_64 rng(1);
  std::normal_distribution<double> normal(0, 0.05);
  const Rigid3d world_from_camera = PoseBeforeTheCorner();
  const auto noisy_wall = [&] {
    FrameLevel level = RenderCorner(world_from_camera, 1);
    for (int i = 0; i < static_cast<int>(level.normal.z.size()); ++i) {
      const double x = normal(rng), y = normal(rng), z = normal(rng);
      const Eigen::Vector3f n = level.normal(i % 160, i / 160);
      if (n.isZero(0)) continue;
      level.normal.Set(i % 160, i / 160, (n + Eigen::Vector3d(x, y, z).cast<float>()).normalized());
    }
    return OneLevel(level);
  };
  const FramePyramid source = noisy_wall(), target = noisy_wall();
  const Rigid3d start(QuaternionExp<double>({0.003, -0.002, 0.004}), {0.006, -0.004, 0.005});
  IcpOptions options;
  options.max_iterations = 50;
  EXPECT_TRUE(Register(source, target, start, options).Succeeded());
  options.observability.min_information_ratio = 1.5;
  const IcpResult result = Register(source, target, start, options);
  EXPECT_EQ(result.termination, Termination::kSingularSystem);
  EXPECT_EQ(result.degenerate_directions.size(), 3u);
  // The foot point of the camera in the plane x = 0 does not move, up to the second order of 1e-2.
  const auto foot = [&](const Rigid3d& pose) {
    return world_from_camera * (pose * (world_from_camera.Inverse() * Eigen::Vector3d(0, 1, 0.9)));
  };
  const Eigen::Vector3d moved = foot(result.target_from_source) - foot(start);
  EXPECT_NEAR(moved.y(), 0, 3e-4);
  EXPECT_NEAR(moved.z(), 0, 3e-4);
  EXPECT_NEAR(foot(result.target_from_source).x(), 0, 1e-3);
}

INSTANTIATE_TEST_SUITE_P(AllSolvers, SingularImages, ::testing::ValuesIn(PointToPlaneSolverNames()),
                         [](const auto& instance) { return instance.param; });

}  // namespace
}  // namespace surfit::testing
