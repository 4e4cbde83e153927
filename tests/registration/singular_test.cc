#include <gtest/gtest.h>

#include "registration/random_correspondences.h"
#include "registration/three_planes.h"
#include "surfit/registration/icp.h"
#include "surfit/registration/pose_solver.h"

namespace surfit {
namespace {

// Pairs (p, p + small) on surfaces that some motion leaves as they are. The points are exact to
// 1e-16, so that the smallest eigenvalue is 0 to about as much.
Correspondences OnPlane(std::mt19937_64* rng) {
  Correspondences pairs;
  for (int i = 0; i < 500; ++i) {
    Eigen::Vector3d p = Eigen::Vector3d(0, 0, 2) + testing::RandomVector(1, rng);
    p.z() = 2;
    pairs.Add(p, p + testing::RandomVector(0.01, rng), {0, 0, -1}, 1);
  }
  return pairs;
}

Correspondences OnSphere(std::mt19937_64* rng) {
  Correspondences pairs;
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector3d n = testing::RandomVector(1, rng).normalized();
    const Eigen::Vector3d p = Eigen::Vector3d(0.1, 0.2, 3) + 0.7 * n;
    pairs.Add(p, p + testing::RandomVector(0.01, rng), n, 1);
  }
  return pairs;
}

// Two walls, floor and ceiling along z.
Correspondences OnCorridor(std::mt19937_64* rng) {
  Correspondences pairs;
  for (int i = 0; i < 500; ++i) {
    Eigen::Vector3d p = Eigen::Vector3d(0, 0, 4) + 2 * testing::RandomVector(1, rng);
    const int axis = i % 2;
    const double side = i % 4 < 2 ? -1 : 1;
    p[axis] = side;
    pairs.Add(p, p + testing::RandomVector(0.01, rng), -side * Eigen::Vector3d::Unit(axis), 1);
  }
  return pairs;
}

class Singular : public ::testing::TestWithParam<Correspondences (*)(std::mt19937_64*)> {};

TEST_P(Singular, IsSaidAndGivesNoIncrement) {
  std::mt19937_64 rng(1);
  const Correspondences pairs = GetParam()(&rng);
  const NormalSystem system = BuildNormalSystem(pairs);
  const double min_eigenvalue = IcpOptions().min_eigenvalue;
  for (const StepResult& step : {SolveLdlt(system, min_eigenvalue), SolveLu(system, min_eigenvalue),
                                 SolveQr(pairs, min_eigenvalue)}) {
    EXPECT_TRUE(step.singular);
    EXPECT_TRUE(step.increment.isZero(0));
    EXPECT_NEAR(step.smallest_eigenvalue, 0, 1e-14);
    EXPECT_EQ(step.system.pair_count, 500);
  }
}

std::string NameOf(const ::testing::TestParamInfo<Singular::ParamType>& info) {
  const char* const names[] = {"plane", "sphere", "corridor"};
  return names[info.index];
}

INSTANTIATE_TEST_SUITE_P(Surfaces, Singular, ::testing::Values(OnPlane, OnSphere, OnCorridor),
                         NameOf);

TEST(SingularSystem, NoPairsAreSingularToo) {
  EXPECT_TRUE(SolveLdlt(NormalSystem(), 1e-6).singular);
  EXPECT_TRUE(SolveLu(NormalSystem(), 1e-6).singular);
  EXPECT_TRUE(SolveQr(Correspondences(), 1e-6).singular);
  EXPECT_TRUE(SolveLdlt(NormalSystem(), 0).singular);
}

// The same through images: of three planes only one or two are there.
class SingularImages : public ::testing::TestWithParam<std::string> {};

TEST_P(SingularImages, EndInTheirOwnTermination) {
  IcpOptions options;
  options.solver = GetParam();
  // Float normals are off by 2^-24, which the direction that is free holds with its square.
  for (const int planes : {1, 2}) {
    const FramePyramid view =
        testing::OneLevel(testing::RenderCorner(testing::PoseBeforeTheCorner(), planes));
    const IcpResult result = Register(view, view, Rigid3d(), options);
    EXPECT_EQ(result.termination, Termination::kSingularSystem) << planes;
    EXPECT_FALSE(result.Succeeded());
    EXPECT_LT(result.smallest_eigenvalue, options.min_eigenvalue);
    EXPECT_TRUE(result.target_from_source.Matrix().allFinite());
    EXPECT_EQ(result.iterations.size(), 1u);
    EXPECT_GT(result.inlier_count, 10000);
  }
}

INSTANTIATE_TEST_SUITE_P(AllSolvers, SingularImages, ::testing::ValuesIn(PoseSolverNames()),
                         [](const auto& instance) { return instance.param; });

}  // namespace
}  // namespace surfit
