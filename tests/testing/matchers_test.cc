#include "testing/matchers.h"

#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>
#include <string>

namespace surfit::testing {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

TEST(VectorNear, MatchesUpToTheTolerance) {
  const Eigen::Vector3d a(1, 2, 3), b(1, 2, 3.5);
  EXPECT_THAT(a, VectorNear(b, 0.5));
  EXPECT_THAT(a, Not(VectorNear(b, 0.49)));
}

TEST(VectorNear, NeverMatchesNan) {
  const Eigen::Vector3d a(1, 2, 3), nan(1, 2, kNan);
  EXPECT_THAT(nan, Not(VectorNear(a, 1e9)));
  EXPECT_THAT(a, Not(VectorNear(nan, 1e9)));
}

TEST(RigidNear, MatchesUpToBothTolerances) {
  const Rigid3d a;
  const Rigid3d b(QuaternionExp<double>({0, 0, 0.1}), Eigen::Vector3d(0.2, 0, 0));
  EXPECT_THAT(a, RigidNear(b, 0.201, 0.101));
  EXPECT_THAT(a, Not(RigidNear(b, 0.199, 0.101)));
  EXPECT_THAT(a, Not(RigidNear(b, 0.201, 0.099)));
}

TEST(RigidNear, AcceptsBothSignsOfTheQuaternion) {
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

TEST(Names, MatchesWholeTokensInAnyOrder) {
  const std::string message = "/data/room/camera.yaml: fx is -3.5, must be from 0-9 (--fx=-3.5).";
  EXPECT_THAT(message, Names("fx", -3.5, "camera.yaml", "/data/room/camera.yaml", "--fx=-3.5", 9));
  EXPECT_THAT("depth_scale is 1.", Names("depth_scale", 1));
}

TEST(Names, RejectsPartsOfWordsNumbersFlagsAndFiles) {
  const std::string message = "a/camera.yaml: --depth_scale is -30.25 or 1e-3";
  for (const char* part : {"scale", "depth", "camera", "yaml", "0.25", "30", "30.25", "-3", "25",
                           "-depth_scale", "a/camera", "c"}) {
    EXPECT_THAT(message, Not(Names(part)));
  }
}

TEST(Names, ListsMissingNames) {
  ::testing::StringMatchResultListener listener;
  EXPECT_FALSE(::testing::ExplainMatchResult(Names("fx", "cy", -1), "fx is 1", &listener));
  EXPECT_EQ(listener.str(), "'cy' is missing; '-1' is missing; ");
}

TEST(Names, RejectsProseAndEmptyNames) {
  ::testing::StringMatchResultListener listener;
  EXPECT_FALSE(::testing::ExplainMatchResult(Names("fx is", ""), "fx is 1", &listener));
  EXPECT_EQ(listener.str(),
            "'fx is' is not the name of a file, flag, field or value; "
            "'' is not the name of a file, flag, field or value; ");
}

TEST(ThrowsNaming, MatchesTypeAndNames) {
  const auto call = [] { throw InputError("camera.yaml: fx is ", -3); };
  EXPECT_THAT(call, ThrowsNaming<InputError>("camera.yaml", "fx", -3));
  EXPECT_THAT(call, Not(ThrowsNaming<InputError>("fy")));
  EXPECT_THAT(call, Not(ThrowsNaming<std::logic_error>("fx")));
}

}  // namespace
}  // namespace surfit::testing
