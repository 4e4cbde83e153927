#include <gtest/gtest.h>

#include "registration/tiny_levels.h"
#include "surfit/core/options.h"
#include "surfit/registration/projective_association.h"
#include "testing/expect_input_error.h"
#include "testing/matchers.h"

namespace surfit {
namespace {

using testing::EmptyLevel;
using testing::SetPoint;
using testing::VectorNear;

const Eigen::Vector3d kFacing(0, 0, -1);
const AssociationGates kOff = {0, 0};

Rigid3d Shift(double x, double y, double z) {
  return {Eigen::Quaterniond::Identity(), Eigen::Vector3d(x, y, z)};
}

// One source point, a target full of points at depth 1.
class AssociationTest : public ::testing::Test {
 protected:
  AssociationTest() {
    SetPoint(&source_, 3, 2, 1, kFacing);
    for (int v = 0; v < 6; ++v) {
      for (int u = 0; u < 8; ++u) SetPoint(&target_, u, v, 1, kFacing);
    }
  }
  PairBuffer Collect(const Rigid3d& pose, const AssociationGates& gates = kOff,
                     NeededNormals normals = NeededNormals::kTarget) const {
    const ProjectiveAssociation association(source_, target_, gates, ErrorModel(), normals);
    return association.Collect(pose);
  }
  int Count(const Rigid3d& pose, const AssociationGates& gates = kOff,
            NeededNormals normals = NeededNormals::kTarget) const {
    return Collect(pose, gates, normals).size;
  }

  FrameLevel source_ = EmptyLevel(), target_ = EmptyLevel();
};

TEST_F(AssociationTest, MatchesTheMovedPointWithTheNearestPixel) {
  target_.normal.Set(5, 3, {0.6f, 0, -0.8f});
  const Rigid3d pose = Shift(0.3, 0.1, 0.2);  // to u = 3 + 8 * 0.25, v = 2 + 8 * 0.0833
  const PairBuffer pairs = Collect(pose);
  ASSERT_EQ(pairs.size, 1);
  EXPECT_THAT(pairs.p(0), VectorNear(Eigen::Vector3f(0.3f, 0.1f, 1.2f), 1e-6));
  EXPECT_THAT(pairs.q(0), VectorNear(target_.camera.Ray(5, 3).cast<float>().eval(), 1e-6));
  EXPECT_THAT(pairs.n(0), VectorNear(Eigen::Vector3f(0.6f, 0, -0.8f), 1e-6));
  EXPECT_THAT(pairs.m(0), VectorNear(Eigen::Vector3f(0, 0, -1), 1e-6));
  EXPECT_NEAR(pairs.information[0], 1 / std::pow(ErrorModel().Sigma(1, {}), 2), 1);  // 1e-6 of 5e4
}

TEST_F(AssociationTest, RotatesAboutTheSourceCamera) {
  const Rigid3d pose(QuaternionExp<double>({0, 0.2, 0}), {0, 0, 0});  // x = z sin, z = z cos
  const PairBuffer pairs = Collect(pose);
  ASSERT_EQ(pairs.size, 1);
  EXPECT_NEAR(pairs.px[0], std::sin(0.2), 1e-6);
  EXPECT_NEAR(pairs.qx[0], target_.camera.Ray(5, 2).x(), 1e-6);  // 8 tan(0.2) = 1.6
}

// Pixel (u, v) reaches from u - 1/2 up to but not including u + 1/2.
TEST_F(AssociationTest, ImageBordersAreHalfAPixelOutsideTheOuterCentres) {
  const double hair = 1e-5;
  const auto to_pixel = [](double u, double v) { return Shift((u - 3) / 8, (v - 2) / 8, 0); };
  EXPECT_EQ(Count(to_pixel(-0.5 + hair, 2)), 1);
  EXPECT_EQ(Count(to_pixel(-0.5 - hair, 2)), 0);
  EXPECT_EQ(Count(to_pixel(7.5 - hair, 2)), 1);
  EXPECT_EQ(Count(to_pixel(7.5 + hair, 2)), 0);
  EXPECT_EQ(Count(to_pixel(3, -0.5 + hair)), 1);
  EXPECT_EQ(Count(to_pixel(3, -0.5 - hair)), 0);
  EXPECT_EQ(Count(to_pixel(3, 5.5 - hair)), 1);
  EXPECT_EQ(Count(to_pixel(3, 5.5 + hair)), 0);
}

TEST_F(AssociationTest, PointsFarOutsideAreNoOverflow) {
  EXPECT_EQ(Count(Shift(1e12, 0, 0)), 0);
  EXPECT_EQ(Count(Shift(0, -1e30, 0)), 0);
  EXPECT_EQ(Count(Shift(0.1, 0, -1 + 1e-7)), 0);
}

TEST_F(AssociationTest, PointsBehindTheTargetCameraHaveNoPartner) {
  // On the optical axis, whose pixel is (3, 2) from both sides.
  EXPECT_EQ(Count(Shift(0, 0, -0.5)), 1);
  EXPECT_EQ(Count(Shift(0, 0, -1)), 0);
  EXPECT_EQ(Count(Shift(0, 0, -1.5)), 0);
}

TEST_F(AssociationTest, NeedsASourcePoint) {
  source_.vertex.Set(3, 2, {0, 0, 0});
  EXPECT_EQ(Count(Rigid3d()), 0);
  EXPECT_EQ(Count(Shift(0, 0, 1)), 0);  // the missing point would move to a good place
}

TEST_F(AssociationTest, NeedsATargetPoint) {
  target_.vertex.Set(3, 2, {0, 0, 0});
  EXPECT_EQ(Count(Rigid3d()), 0);
}

TEST_F(AssociationTest, NeedsTheNormalsOfTheResidual) {
  const auto count = [&](NeededNormals normals) { return Count(Rigid3d(), kOff, normals); };
  source_.normal.Set(3, 2, {0, 0, 0});
  EXPECT_EQ(count(NeededNormals::kTarget), 1);
  EXPECT_EQ(count(NeededNormals::kBoth), 0);
  target_.normal.Set(3, 2, {0, 0, 0});
  EXPECT_EQ(count(NeededNormals::kTarget), 0);
  EXPECT_EQ(count(NeededNormals::kNone), 1);
}

TEST_F(AssociationTest, DistanceGateIsTheDistanceOfThePoints) {
  AssociationGates gates = kOff;
  gates.max_distance_m = 0.1;
  EXPECT_EQ(Count(Shift(0, 0, 0.0999), gates), 1);
  EXPECT_EQ(Count(Shift(0, 0, 0.1001), gates), 0);
  // Sideways, 0.06 and 0.08 m from the centre of pixel (3, 2)'s neighbours: along the plane counts.
  const double pixel_m = 1.0 / 8;
  EXPECT_EQ(Count(Shift(pixel_m + 0.0599, 0, 0.08), gates), 1);
  EXPECT_EQ(Count(Shift(pixel_m + 0.0601, 0, 0.0801), gates), 0);
}

TEST_F(AssociationTest, WithoutDistanceGateAnyDistanceWillDo) {
  EXPECT_EQ(Count(Shift(0, 0, 50)), 1);
}

TEST_F(AssociationTest, NormalGateIsTheAngleOfTheRotatedNormals) {
  AssociationGates gates = kOff;
  gates.max_normal_angle_rad = 0.3;
  // About the optical axis through the point, the point stays where it is.
  const auto tilt = [](double angle_rad) {
    return Eigen::Vector3d(std::sin(angle_rad), 0, -std::cos(angle_rad));
  };
  SetPoint(&source_, 3, 2, 1, tilt(0.299));
  EXPECT_EQ(Count(Rigid3d(), gates), 1);
  SetPoint(&source_, 3, 2, 1, tilt(0.301));
  EXPECT_EQ(Count(Rigid3d(), gates), 0);
  EXPECT_EQ(Count(Rigid3d(), kOff), 1);
  // A pose that turns the normal back: about y by 0.301 takes (sin a, 0, -cos a) to (0, 0, -1).
  const Rigid3d turn(QuaternionExp<double>({0, 0.301, 0}), {0, 0, 0});
  EXPECT_EQ(Count(turn, gates), 1);
}

TEST_F(AssociationTest, OnlyTheNormalGateNeedsASourceNormal) {
  source_.normal.Set(3, 2, {0, 0, 0});
  EXPECT_EQ(Count(Rigid3d()), 1);
  AssociationGates gates = kOff;
  gates.max_normal_angle_rad = 1.57;  // the widest
  EXPECT_EQ(Count(Rigid3d(), gates), 0);
}

TEST_F(AssociationTest, CountsTheValidSourcePoints) {
  const auto count = [&] {
    return ProjectiveAssociation(source_, target_, kOff, ErrorModel()).source_count();
  };
  EXPECT_EQ(count(), 1);
  SetPoint(&source_, 0, 0, 1, kFacing);
  EXPECT_EQ(count(), 2);
}

TEST_F(AssociationTest, UsesEverySoManythRowOfTheSource) {
  SetPoint(&source_, 0, 0, 1, kFacing);
  SetPoint(&source_, 0, 1, 1, kFacing);
  const auto count = [&](int row_stride) {
    const ProjectiveAssociation association(source_, target_, kOff, ErrorModel(),
                                            NeededNormals::kTarget, row_stride);
    EXPECT_EQ(association.block_count(), (source_.vertex.height() + row_stride - 1) / row_stride);
    return association.source_count();
  };
  EXPECT_EQ(count(1), 3);  // rows 0, 1 and 2
  EXPECT_EQ(count(2), 2);
  EXPECT_EQ(count(3), 1);
}

TEST(AssociationGates, ValidateNamesFieldValueAndConstraint) {
  Validate(AssociationGates());
  Validate(kOff);
  const auto expect = [](double distance_m, double angle_rad, const char* message) {
    const AssociationGates gates = {distance_m, angle_rad};
    testing::ExpectInputError([&] { Validate(gates); }, ::testing::StrEq(message));
  };
  expect(-1, 0.5, "max_distance_m is -1, must be zero (off) or positive");
  expect(std::nan(""), 0.5, "max_distance_m is nan, must be zero (off) or positive");
  expect(0.1, -0.1,
         "max_normal_angle_rad is -0.1, must be zero (off) or positive and below 1.5708");
  expect(0.1, 1.6, "max_normal_angle_rad is 1.6, must be zero (off) or positive and below 1.5708");
}

}  // namespace
}  // namespace surfit
