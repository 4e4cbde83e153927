#include "cost_functions/pose_manifold.h"

#include <ceres/manifold_test_utils.h>
#include <gtest/gtest.h>

#include "cost_functions/random_functors.h"
#include "testing/matchers.h"
#include "testing/random_pose.h"

namespace surfit::testing {
namespace {

using Increment = Eigen::Matrix<double, 6, 1>;

Increment RandomIncrement(double size_rad, std::mt19937_64* rng) {
  Increment delta;
  delta << RandomVector(size_rad, rng), RandomVector(2, rng);
  return delta;
}

// Matcher of Ceres: compares Plus, Minus and their Jacobians. Coordinates of a few metres and
// rotations near pi reduce the precision of 1e-16 by a few digits.
template <typename Manifold>
void ExpectInvariants() {
  using namespace ceres;  // NOLINT(google-build-using-namespace): the macro needs it
  constexpr double kTolerance = 1e-9;
  const Manifold manifold;
  std::mt19937_64 rng(1);
  for (int trial = 0; trial < 100; ++trial) {
    // The rotation from x to y is less than pi. Beyond pi, Minus uses the shorter rotation, to -q.
    const PoseBlock x = AsBlock(RandomPose(1.5, 3, &rng));
    PoseBlock y;
    manifold.Plus(x.data(), RandomIncrement(1.5, &rng).eval().data(), y.data());
    const Increment delta = RandomIncrement(trial % 2 == 0 ? 1e-8 : 1.5, &rng);
    EXPECT_THAT_MANIFOLD_INVARIANTS_HOLD(manifold, x, delta, y, kTolerance);
  }
  const PoseBlock identity = AsBlock(Rigid3d());
  const Increment zero = Increment::Zero();
  EXPECT_THAT_MANIFOLD_INVARIANTS_HOLD(manifold, identity, zero, identity, kTolerance);
}

TEST(PoseManifold, InvariantsHold) {
  ExpectInvariants<LeftPoseManifold>();
  ExpectInvariants<ProductPoseManifold>();
}

TEST(LeftPoseManifold, AppliesLeftIncrement) {
  std::mt19937_64 rng(2);
  for (int trial = 0; trial < 20; ++trial) {
    const Rigid3d pose = RandomPose(2, 3, &rng);
    const Increment delta = RandomIncrement(1, &rng);
    PoseBlock moved;
    LeftPoseManifold().Plus(AsBlock(pose).data(), delta.data(), moved.data());
    const Eigen::Vector3d p = RandomVector(3, &rng);
    const Eigen::Vector3d expected =
        QuaternionExp<double>(delta.head<3>()) * (pose * p) + delta.tail<3>();
    EXPECT_THAT(PoseFromBlock(moved.data()) * p, VectorNear(expected, 1e-14 * 10));
  }
}

TEST(ProductPoseManifold, RotatesInPlaceAndAddsTranslations) {
  std::mt19937_64 rng(3);
  for (int trial = 0; trial < 20; ++trial) {
    const Rigid3d pose = RandomPose(2, 3, &rng);
    const Increment delta = RandomIncrement(1, &rng);
    PoseBlock moved;
    ProductPoseManifold().Plus(AsBlock(pose).data(), delta.data(), moved.data());
    const Rigid3d expected(QuaternionExp<double>(delta.head<3>()) * pose.rotation,
                           pose.translation + delta.tail<3>());
    EXPECT_THAT(PoseFromBlock(moved.data()), RigidNear(expected, 1e-15, 1e-14));
  }
}

TEST(PoseBlock, HasOrderOfTumFiles) {
  const Rigid3d pose(Eigen::Quaterniond(0.1, 0.7, 0.5, 0.5).normalized(), {1, 2, 3});
  const PoseBlock block = AsBlock(pose);
  EXPECT_EQ(block[0], pose.rotation.x());
  EXPECT_EQ(block[1], pose.rotation.y());
  EXPECT_EQ(block[2], pose.rotation.z());
  EXPECT_EQ(block[3], pose.rotation.w());
  EXPECT_EQ(block.tail<3>(), pose.translation);
  EXPECT_EQ(PoseFromBlock(block.data()).Matrix(), pose.Matrix());
}

}  // namespace
}  // namespace surfit::testing
