#include <gtest/gtest.h>

#include "registration/icp/row_finder.h"
#include "registration/three_planes.h"
#include "surfit/core/options.h"
#include "surfit/frame/preprocess.h"
#include "surfit/registration/association.h"
#include "surfit/simulation/camera_path.h"
#include "surfit/simulation/render.h"
#include "surfit/simulation/scene.h"
#include "testing/matchers.h"
#include "testing/pixels.h"

namespace surfit::testing {

namespace {

const Eigen::Vector3d kFacing(0, 0, -1);
const AssociationGates kOff = {0, 0};

Rigid3d Shift(double x, double y, double z) {
  return {Eigen::Quaterniond::Identity(), Eigen::Vector3d(x, y, z)};
}

// One source point, and a target with points at depth 1 in all pixels.
class AssociationTest : public ::testing::Test {
 protected:
  AssociationTest() {
    SetPoint(&source_, 3, 2, 1, kFacing);
    for (const auto [u, v] : PixelsOf(8, 6)) SetPoint(&target_, u, v, 1, kFacing);
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

TEST_F(AssociationTest, MatchesMovedPointWithNearestPixel) {
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

TEST_F(AssociationTest, RotatesAboutSourceCamera) {
  const Rigid3d pose(QuaternionExp<double>({0, 0.2, 0}), {0, 0, 0});  // x = z sin, z = z cos
  const PairBuffer pairs = Collect(pose);
  ASSERT_EQ(pairs.size, 1);
  EXPECT_NEAR(pairs.px[0], std::sin(0.2), 1e-6);
  EXPECT_NEAR(pairs.qx[0], target_.camera.Ray(5, 2).x(), 1e-6);  // 8 tan(0.2) = 1.6
}

// Pixel (u, v) covers the interval [u - 1/2, u + 1/2).
TEST_F(AssociationTest, ImageBorderIsHalfPixelOutsideOuterCentres) {
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

TEST_F(AssociationTest, IgnoresPointsFarOutside) {
  EXPECT_EQ(Count(Shift(1e12, 0, 0)), 0);
  EXPECT_EQ(Count(Shift(0, -1e30, 0)), 0);
  EXPECT_EQ(Count(Shift(0.1, 0, -1 + 1e-7)), 0);
}

TEST_F(AssociationTest, IgnoresPointsBehindTargetCamera) {
  // The optical axis projects to pixel (3, 2), from both sides.
  EXPECT_EQ(Count(Shift(0, 0, -0.5)), 1);
  EXPECT_EQ(Count(Shift(0, 0, -1)), 0);
  EXPECT_EQ(Count(Shift(0, 0, -1.5)), 0);
}

TEST_F(AssociationTest, RequiresSourcePoint) {
  source_.vertex.Set(3, 2, {0, 0, 0});
  EXPECT_EQ(Count(Rigid3d()), 0);
  EXPECT_EQ(Count(Shift(0, 0, 1)), 0);  // the missing point would project into the image
}

TEST_F(AssociationTest, RequiresTargetPoint) {
  target_.vertex.Set(3, 2, {0, 0, 0});
  EXPECT_EQ(Count(Rigid3d()), 0);
}

TEST_F(AssociationTest, RequiresNormalsOfResidual) {
  const auto count = [&](NeededNormals normals) { return Count(Rigid3d(), kOff, normals); };
  source_.normal.Set(3, 2, {0, 0, 0});
  EXPECT_EQ(count(NeededNormals::kTarget), 1);
  EXPECT_EQ(count(NeededNormals::kBoth), 0);
  target_.normal.Set(3, 2, {0, 0, 0});
  EXPECT_EQ(count(NeededNormals::kTarget), 0);
  EXPECT_EQ(count(NeededNormals::kNone), 1);
}

TEST_F(AssociationTest, DistanceGateLimitsDistanceOfPoints) {
  AssociationGates gates = kOff;
  gates.max_distance_m = 0.1;
  EXPECT_EQ(Count(Shift(0, 0, 0.0999), gates), 1);
  EXPECT_EQ(Count(Shift(0, 0, 0.1001), gates), 0);
  // 0.06 m sideways and 0.08 m in depth from the centre of a neighbour pixel: the distance along
  // the plane is included.
  const double pixel_m = 1.0 / 8;
  EXPECT_EQ(Count(Shift(pixel_m + 0.0599, 0, 0.08), gates), 1);
  EXPECT_EQ(Count(Shift(pixel_m + 0.0601, 0, 0.0801), gates), 0);
}

TEST_F(AssociationTest, AcceptsAnyDistanceWithoutDistanceGate) {
  EXPECT_EQ(Count(Shift(0, 0, 50)), 1);
}

TEST_F(AssociationTest, NormalGateLimitsAngleOfRotatedNormals) {
  AssociationGates gates = kOff;
  gates.max_normal_angle_rad = 0.3;
  // The point on the optical axis does not move.
  const auto tilt = [](double angle_rad) {
    return Eigen::Vector3d(std::sin(angle_rad), 0, -std::cos(angle_rad));
  };
  SetPoint(&source_, 3, 2, 1, tilt(0.299));
  EXPECT_EQ(Count(Rigid3d(), gates), 1);
  SetPoint(&source_, 3, 2, 1, tilt(0.301));
  EXPECT_EQ(Count(Rigid3d(), gates), 0);
  EXPECT_EQ(Count(Rigid3d(), kOff), 1);
  // The pose rotates the normal back: 0.301 about y maps (sin a, 0, -cos a) to (0, 0, -1).
  const Rigid3d turn(QuaternionExp<double>({0, 0.301, 0}), {0, 0, 0});
  EXPECT_EQ(Count(turn, gates), 1);
}

TEST_F(AssociationTest, OnlyNormalGateRequiresSourceNormal) {
  source_.normal.Set(3, 2, {0, 0, 0});
  EXPECT_EQ(Count(Rigid3d()), 1);
  AssociationGates gates = kOff;
  gates.max_normal_angle_rad = 1.57;  // the widest gate
  EXPECT_EQ(Count(Rigid3d(), gates), 0);
}

TEST_F(AssociationTest, CountsValidSourcePoints) {
  const auto count = [&] {
    return ProjectiveAssociation(source_, target_, kOff, ErrorModel()).source_count();
  };
  EXPECT_EQ(count(), 1);
  SetPoint(&source_, 0, 0, 1, kFacing);
  EXPECT_EQ(count(), 2);
}

TEST_F(AssociationTest, UsesEveryNthRowOfSource) {
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

TEST(AssociationGates, ValidateRejectsInvalidFieldsByName) {
  Validate(AssociationGates());
  Validate(kOff);
  const auto expect = [](double distance_m, double angle_rad, const auto&... names) {
    const AssociationGates gates = {distance_m, angle_rad};
    ExpectInputError([&] { Validate(gates); }, Names(names...));
  };
  expect(-1, 0.5, "max_distance_m", -1);
  expect(std::nan(""), 0.5, "max_distance_m", "nan");
  expect(0.1, -0.1, "max_normal_angle_rad", -0.1, 1.5708);
  expect(0.1, 1.6, "max_normal_angle_rad", 1.6, 1.5708);
}

// Rows of 83 pixels: ten times eight lanes, and three pixels.
constexpr PinholeCamera kCamera = {83, 60, 70, 70, 41, 29.5, {}};

class RowFinderTest : public ::testing::Test {
 protected:
  RowFinderTest() {
    const Scene scene = MakeScene("room", 1);
    const Trajectory path = MakePath(scene, 10, 1);
    const auto view = [&](int i) {
      return PreprocessDepth(RenderFrame(scene, kCamera, path[i].world_from_camera).depth_m,
                             {kCamera, {}}, PreprocessOptions())
          .levels[0];
    };
    source_ = view(0);
    target_ = view(9);
    pose_ = path[9].world_from_camera.Inverse() * path[0].world_from_camera;
  }
  ProjectiveSearch Search() const {
    return {source_, target_, pose_, gates_, error_model_, NeededNormals::kBoth};
  }
  ProjectiveAssociation Association() const {
    return {source_, target_, gates_, error_model_, NeededNormals::kBoth};
  }

  FrameLevel source_, target_;
  Rigid3d pose_;
  AssociationGates gates_;
  ErrorModel error_model_;
};

// Correspondences are bitwise identical and in the same order for all instruction sets.
TEST_F(RowFinderTest, IsBitwiseIdenticalForAllInstructionSets) {
  const ProjectiveAssociation association = Association();
  const auto finder = association.At(pose_);
  PairBuffer base, best;
  base.SetCapacity(association.block_capacity());
  best.SetCapacity(association.block_capacity());
  int pairs = 0;
  for (int v = 0; v < kCamera.height; ++v) {
    const int count = finder->Find(v, 0, &best);
    WithBaseInstructions([&](auto instructions) {
      ASSERT_EQ(RowFinder<decltype(instructions)>(Search()).Find(v, 0, &base), count);
    });
    for (int k = 0; k < PairBuffer::kArrays; ++k) {
      const auto &a = *base.Arrays()[k], &b = *best.Arrays()[k];
      EXPECT_TRUE(std::equal(a.begin(), a.begin() + count, b.begin())) << v << " " << k;
    }
    pairs += count;
  }
  EXPECT_GT(pairs, kCamera.width * kCamera.height / 2);
}

// The definition of the header in double precision. Rounding (1e-6 of 100 px or of a sigma) can
// change the pixel or the gate of a few points.
TEST_F(RowFinderTest, AgreesWithDefinitionInDoublePrecision) {
  const PairBuffer found = Association().Collect(pose_);
  int next = 0, expected = 0, doubtful = 0;
  for (const auto [u, v] : PixelsOf(kCamera)) {
    const Eigen::Vector3d s = source_.vertex(u, v).cast<double>();
    const Eigen::Vector3d m = pose_.rotation * source_.normal(u, v).cast<double>();
    if (!(s.z() > 0) || m.isZero(0)) continue;
    const Eigen::Vector3d p = pose_ * s;
    const double x = kCamera.fx * p.x() / p.z() + kCamera.cx + 0.5;
    const double y = kCamera.fy * p.y() / p.z() + kCamera.cy + 0.5;
    if (!(p.z() > 0) || x < 0 || y < 0 || x >= kCamera.width || y >= kCamera.height) continue;
    const Eigen::Vector3d q = target_.vertex(x, y).cast<double>();
    const Eigen::Vector3d n = target_.normal(x, y).cast<double>();
    const double distance_m = (p - q).norm(), cosine = m.dot(n);
    const double min_cosine = std::cos(gates_.max_normal_angle_rad);
    if (!(q.z() > 0) || n.isZero(0)) continue;
    if (distance_m > gates_.max_distance_m || cosine < min_cosine) continue;
    ++expected;
    if (next < found.size && (found.p(next).cast<double>() - p).norm() < 1e-5) {
      const bool same_pixel = (found.q(next).cast<double>() - q).isZero(0);
      doubtful += same_pixel ? 0 : 1;
      if (same_pixel) {
        EXPECT_LT((found.n(next).cast<double>() - n).norm(), 1e-6);
        EXPECT_LT((found.m(next).cast<double>() - m).norm(), 1e-5);
        const double sigma_m = error_model_.Sigma(s.z(), {});
        EXPECT_NEAR(found.information[next] * sigma_m * sigma_m, 1, 1e-5);
      }
      ++next;
    } else {
      ++doubtful;
    }
  }
  EXPECT_EQ(next, found.size);
  EXPECT_GT(expected, kCamera.width * kCamera.height / 2);
  EXPECT_LE(doubtful, 3);
}

}  // namespace

}  // namespace surfit::testing
