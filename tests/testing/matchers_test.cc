#include "testing/matchers.h"

#include <gtest/gtest.h>

#include <limits>

namespace surfit::testing {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

TEST(VectorNear, HoldsUpToTheTolerance) {
  const Eigen::Vector3d a(1, 2, 3), b(1, 2, 3.5);
  EXPECT_THAT(a, VectorNear(b, 0.5));
  EXPECT_THAT(a, Not(VectorNear(b, 0.49)));
}

TEST(VectorNear, NeverMatchesNan) {
  const Eigen::Vector3d a(1, 2, 3), nan(1, 2, kNan);
  EXPECT_THAT(nan, Not(VectorNear(a, 1e9)));
  EXPECT_THAT(a, Not(VectorNear(nan, 1e9)));
}

TEST(RigidNear, HoldsUpToEachTolerance) {
  const Rigid3d a;
  const Rigid3d b(QuaternionExp<double>({0, 0, 0.1}), Eigen::Vector3d(0.2, 0, 0));
  EXPECT_THAT(a, RigidNear(b, 0.201, 0.101));
  EXPECT_THAT(a, Not(RigidNear(b, 0.199, 0.101)));
  EXPECT_THAT(a, Not(RigidNear(b, 0.201, 0.099)));
}

TEST(RigidNear, TakesBothSignsOfTheQuaternion) {
  Rigid3d a(QuaternionExp<double>({0.1, 0.2, 0.3}), Eigen::Vector3d(1, 2, 3));
  const Rigid3d b = a;
  a.rotation.coeffs() = -a.rotation.coeffs();
  EXPECT_THAT(a, RigidNear(b, 0, 1e-15));
}

TEST(RigidNear, NeverMatchesNan) {
  Rigid3d nan_rotation, nan_translation;
  nan_rotation.rotation.y() = kNan;
  nan_translation.translation.x() = kNan;
  EXPECT_THAT(nan_rotation, Not(RigidNear(Rigid3d(), 1e9, 1e9)));
  EXPECT_THAT(nan_translation, Not(RigidNear(Rigid3d(), 1e9, 1e9)));
}

}  // namespace
}  // namespace surfit::testing
