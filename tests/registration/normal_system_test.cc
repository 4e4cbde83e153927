#include "surfit/registration/normal_system.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "registration/pair_buffer.h"
#include "registration/random_correspondences.h"
#include "surfit/geometry/rigid3.h"
#include "testing/matchers.h"

namespace surfit {
namespace {

using testing::VectorNear;

using Jet = ceres::Jet<double, 6>;
using JetVector = Eigen::Matrix<Jet, 3, 1>;

// The residual n . (exp(w) p + v - q) at (w, v) = 0, with its derivatives by automatic
// differentiation: the definition from which the rows of A and b are derived.
Jet DualResidual(const Eigen::Vector3d& p, const Eigen::Vector3d& q, const Eigen::Vector3d& n) {
  JetVector w, v;
  for (int i = 0; i < 3; ++i) {
    w[i] = Jet(0, i);
    v[i] = Jet(0, i + 3);
  }
  const JetVector moved = QuaternionExp<Jet>(w) * JetVector(p.cast<Jet>()) + v;
  return n.cast<Jet>().dot(JetVector(moved - q.cast<Jet>()));
}

// A^T W A and so on from dual numbers.
NormalSystem DualSystem(const Correspondences& c) {
  NormalSystem system;
  for (std::size_t i = 0; i < c.size(); ++i) {
    const Jet r =
        DualResidual(testing::PointOf(c, i), testing::TargetOf(c, i), testing::NormalOf(c, i));
    system.hessian += c.weight[i] * r.v * r.v.transpose();
    system.right_side -= c.weight[i] * r.a * r.v;
    system.weighted_square_sum += c.weight[i] * r.a * r.a;
    system.weight_sum += c.weight[i];
    system.weighted_point_square_sum += c.weight[i] * testing::PointOf(c, i).squaredNorm();
    ++system.pair_count;
  }
  system.inlier_count = c.inlier_count;
  return system;
}

// Each sum is within `relative` of the expected one, measured by sums of absolute values.
void ExpectNear(const NormalSystem& actual, const NormalSystem& expected, double relative) {
  const Vector6d root = expected.hessian.diagonal().cwiseSqrt();
  const double residual_root = std::sqrt(expected.weighted_square_sum);
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 6; ++j) {
      // Cauchy and Schwarz: sum |w a_i a_j| <= root_i root_j.
      EXPECT_NEAR(actual.hessian(i, j), expected.hessian(i, j), relative * root[i] * root[j]);
    }
    EXPECT_NEAR(actual.right_side[i], expected.right_side[i], relative * root[i] * residual_root);
  }
  EXPECT_NEAR(actual.weighted_square_sum, expected.weighted_square_sum,
              relative * expected.weighted_square_sum);
  EXPECT_NEAR(actual.weight_sum, expected.weight_sum, relative * expected.weight_sum);
  EXPECT_NEAR(actual.weighted_point_square_sum, expected.weighted_point_square_sum,
              relative * expected.weighted_point_square_sum);
  EXPECT_EQ(actual.pair_count, expected.pair_count);
  EXPECT_EQ(actual.inlier_count, expected.inlier_count);
}

TEST(BuildNormalSystem, RowsAreTheDerivativesOfTheResidual) {
  std::mt19937_64 rng(1);
  for (int i = 0; i < 100; ++i) {
    const Correspondences one = testing::RandomCorrespondences(1, 0.1, &rng);
    // A handful of roundings of numbers of the same size.
    ExpectNear(BuildNormalSystem(one), DualSystem(one), 1e-14);
  }
}

TEST(BuildNormalSystem, SumsAllRows) {
  std::mt19937_64 rng(2);
  const Correspondences pairs = testing::RandomCorrespondences(1000, 0.1, &rng);
  // 1000 additions, each rounded by 2^-53 of the sum so far at most.
  ExpectNear(BuildNormalSystem(pairs), DualSystem(pairs), 1000 * 1.2e-16);
}

TEST(BuildNormalSystem, IsZeroWithoutPairs) {
  const NormalSystem system = BuildNormalSystem(Correspondences());
  EXPECT_EQ(system.pair_count, 0);
  EXPECT_EQ(system.RmsDistance(), 0);
  EXPECT_TRUE(system.hessian.isZero(0));
  EXPECT_EQ(system.AverageLoss(), 0);
  EXPECT_TRUE(system.ScaledEigenvalues().isZero(0));
}

// The fused sums over lanes of floats, against the same values in double precision. A product of
// the weight and two columns, each of at most 5 roundings, has 12; at most 8 are summed in a lane.
constexpr double kLaneTolerance = 20.0 / (1 << 24);

TEST(AddPairs, AgreesWithDoublePrecisionForAnyNumberOfPairs) {
  std::mt19937_64 rng(3);
  for (const int count : {0, 1, 7, 8, 9, 63, 64, 65, 640}) {
    const Correspondences pairs = testing::RandomCorrespondences(count, 0.1, &rng);
    PairBuffer buffer(640);
    Correspondences rounded;  // to what the buffer holds
    // Left over from a longer row: must not count.
    for (auto* array : {&buffer.px, &buffer.qy, &buffer.nz, &buffer.weight}) {
      std::fill(array->begin(), array->end(), 1e6f);
    }
    for (int i = 0; i < count; ++i) {
      const Eigen::Vector3f p = testing::PointOf(pairs, i).cast<float>();
      const Eigen::Vector3f q = testing::TargetOf(pairs, i).cast<float>();
      const Eigen::Vector3f n = testing::NormalOf(pairs, i).cast<float>();
      const float weight = static_cast<float>(pairs.weight[i]);
      buffer.px[i] = p.x(), buffer.py[i] = p.y(), buffer.pz[i] = p.z();
      buffer.qx[i] = q.x(), buffer.qy[i] = q.y(), buffer.qz[i] = q.z();
      buffer.nx[i] = n.x(), buffer.ny[i] = n.y(), buffer.nz[i] = n.z();
      buffer.weight[i] = weight;
      rounded.Add(p.cast<double>(), q.cast<double>(), n.cast<double>(), weight);
    }
    buffer.size = count;
    buffer.inlier_count = count / 2;
    NormalSystem system;
    AddPairs(&buffer, &system);
    // Columns p x n are differences of products of size |p| <= 4.6 (a cube about 3 m): relative to
    // root_i, which can be as small as for a single pair, cancellation costs that factor.
    rounded.inlier_count = buffer.inlier_count;
    const NormalSystem expected = DualSystem(rounded);
    if (count >= 63) ExpectNear(system, expected, 5 * kLaneTolerance);
    const double size = expected.weight_sum * 4.6 * 4.6;
    EXPECT_THAT(system.hessian, VectorNear(expected.hessian, 6 * kLaneTolerance * size));
    EXPECT_THAT(system.right_side, VectorNear(expected.right_side, 6 * kLaneTolerance * size));
    EXPECT_EQ(system.pair_count, count);
    EXPECT_EQ(system.inlier_count, buffer.inlier_count);
  }
}

TEST(NormalSystem, SumIsThatOfAllPairs) {
  std::mt19937_64 rng(4);
  Correspondences all;
  NormalSystem sum;
  for (int part = 0; part < 3; ++part) {
    Correspondences pairs = testing::RandomCorrespondences(50, 0.1, &rng);
    pairs.inlier_count = 20 + part;
    all.inlier_count += pairs.inlier_count;
    sum += BuildNormalSystem(pairs);
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      all.Add(testing::PointOf(pairs, i), testing::TargetOf(pairs, i), testing::NormalOf(pairs, i),
              pairs.weight[i]);
    }
  }
  ExpectNear(sum, BuildNormalSystem(all), 1e-14);
}

TEST(NormalSystem, AverageLossIsTheWeightedMeanOfSquares) {
  Correspondences pairs;
  pairs.Add({0, 0, 2}, {0, 0, 2.1}, {0, 0, -1}, 1);  // r = 0.1
  pairs.Add({0, 0, 2}, {0, 1, 2.3}, {0, 0, -1}, 3);  // r = 0.3
  EXPECT_NEAR(BuildNormalSystem(pairs).AverageLoss(), (0.01 + 3 * 0.09) / 4, 1e-15);
}

TEST(NormalSystem, RmsDistanceIsThatOfTheMovedPoints) {
  Correspondences pairs;
  pairs.Add({0, 3, 4}, {0, 0, 1}, {0, 0, -1}, 1);  // 5 m
  pairs.Add({0, 0, 1}, {0, 0, 1}, {0, 0, -1}, 3);  // 1 m
  EXPECT_NEAR(BuildNormalSystem(pairs).RmsDistance(), std::sqrt((25.0 + 3 * 1) / 4), 1e-15);
}

TEST(ScaledEigenvalues, DoNotDependOnUnitsOrWeights) {
  std::mt19937_64 rng(5);
  const Correspondences pairs = testing::RandomCorrespondences(200, 0.1, &rng);
  Correspondences scaled;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    scaled.Add(100 * testing::PointOf(pairs, i), 100 * testing::TargetOf(pairs, i),
               testing::NormalOf(pairs, i), 7 * pairs.weight[i]);
  }
  const Vector6d eigenvalues = BuildNormalSystem(pairs).ScaledEigenvalues();
  EXPECT_THAT(BuildNormalSystem(scaled).ScaledEigenvalues(), VectorNear(eigenvalues, 1e-13));
  // A mean of a a^T: the trace is that of the mean of |p x n|^2 / mean |p|^2 + |n|^2, at most 2.
  EXPECT_GT(eigenvalues[0], 0);
  EXPECT_LE(eigenvalues.sum(), 2);
  EXPECT_TRUE(std::is_sorted(eigenvalues.data(), eigenvalues.data() + 6));
}

TEST(ScaledEigenvalues, VanishForDirectionsThatTheDataDoesNotHold) {
  // The plane z = 2: two translations and one rotation are free, exactly.
  Correspondences plane;
  std::mt19937_64 rng(6);
  for (int i = 0; i < 100; ++i) {
    Eigen::Vector3d p = testing::RandomVector(1, &rng);
    p.z() = 2;
    plane.Add(p, p, {0, 0, -1}, 1);
  }
  const Vector6d eigenvalues = BuildNormalSystem(plane).ScaledEigenvalues();
  EXPECT_NEAR(eigenvalues[2], 0, 1e-14);
  EXPECT_GT(eigenvalues[3], 1e-3);
}

}  // namespace
}  // namespace surfit
