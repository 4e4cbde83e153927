#include <gtest/gtest.h>

#include <cmath>

#include "surfit/evaluation/error_statistics.h"
#include "surfit/evaluation/trajectory_evaluation.h"
#include "testing/matchers.h"
#include "testing/random_pose.h"

namespace surfit::testing {
namespace {

using Points = std::vector<Eigen::Vector3d>;

// Tolerance for exact data near 10 in double precision.
constexpr double kExact = 1e-12;

Points RandomPoints(int count, std::mt19937_64* rng) {
  Points points;
  for (int i = 0; i < count; ++i) points.push_back(RandomVector(3, rng));
  return points;
}

Points Transformed(const Rigid3d& transform, Points points) {
  for (Eigen::Vector3d& point : points) point = transform * point;
  return points;
}

double SumOfSquares(const Rigid3d& target_from_source, const Points& source, const Points& target) {
  double sum = 0;
  for (std::size_t i = 0; i < source.size(); ++i) {
    sum += (target[i] - target_from_source * source[i]).squaredNorm();
  }
  return sum;
}

TEST(AlignPoints, RejectsListsOfOtherSizesAndPointsThatAreNotFinite) {
  std::mt19937_64 rng(2);
  Points source = RandomPoints(4, &rng);
  ExpectInputError([&] { AlignPoints(source, RandomPoints(3, &rng)); }, Names(4, 3));
  source[1].x() = std::nan("");
  ExpectInputError([&] { AlignPoints(source, RandomPoints(4, &rng)); }, Names("finite"));
  ExpectInputError([] { Summarize({}); }, Names("errors"));
}

TEST(AlignPoints, RecoversRigidMotionExactly) {
  std::mt19937_64 rng(1);
  for (int count : {3, 4, 100}) {
    for (int i = 0; i < 20; ++i) {
      const Rigid3d truth = RandomPose(1.8, 5, &rng);
      const Points source = RandomPoints(count, &rng);
      const Alignment alignment = AlignPoints(source, Transformed(truth, source));
      EXPECT_EQ(alignment.status, AlignmentStatus::kAligned);
      EXPECT_THAT(alignment.target_from_source, RigidNear(truth, kExact, kExact));
    }
  }
}

// At a minimum, every small rotation and translation increases the cost.
TEST(AlignPoints, IsMinimumWithNoise) {
  std::mt19937_64 rng(2);
  const Points source = RandomPoints(50, &rng);
  Points target = Transformed(RandomPose(1.8, 5, &rng), source);
  for (Eigen::Vector3d& point : target) point += RandomVector(0.3, &rng);
  const Rigid3d best = AlignPoints(source, target).target_from_source;
  const double least = SumOfSquares(best, source, target);
  for (const auto& increment : EachDirection(1e-4, 1e-4)) {
    EXPECT_GT(SumOfSquares(LeftIncrement<double>(increment, best), source, target), least);
  }
}

TEST(AlignPoints, KeepsScale) {
  std::mt19937_64 rng(3);
  const Points source = RandomPoints(20, &rng);
  Points target = source;
  for (Eigen::Vector3d& point : target) point *= 3;
  const Rigid3d transform = AlignPoints(source, target).target_from_source;
  EXPECT_NEAR((transform * source[0] - transform * source[1]).norm(),
              (source[0] - source[1]).norm(), kExact);
}

// Points mirrored in x, with the smallest spread along x: the best rotation without reflection is
// the identity.
TEST(AlignPoints, NeverReflects) {
  const Points source = {{0.1, 0, 0}, {-0.1, 0, 0}, {0, 2, 0}, {0, -2, 0}, {0, 0, 3}, {0, 0, -3}};
  Points target = source;
  for (Eigen::Vector3d& point : target) point.x() = -point.x();
  const Alignment alignment = AlignPoints(source, target);
  EXPECT_EQ(alignment.status, AlignmentStatus::kAligned);
  EXPECT_NEAR(alignment.target_from_source.rotation.toRotationMatrix().determinant(), 1, kExact);
  EXPECT_THAT(alignment.target_from_source, RigidNear(Rigid3d(), kExact, kExact));
}

TEST(AlignPoints, IsUniqueOnPlane) {
  std::mt19937_64 rng(4);
  for (int i = 0; i < 20; ++i) {
    Points source = RandomPoints(10, &rng);
    for (Eigen::Vector3d& point : source) point.z() = 1;
    const Rigid3d truth = RandomPose(1.8, 5, &rng);
    const Alignment alignment = AlignPoints(source, Transformed(truth, source));
    EXPECT_EQ(alignment.status, AlignmentStatus::kAligned);
    EXPECT_THAT(alignment.target_from_source, RigidNear(truth, kExact, kExact));
  }
}

TEST(AlignPoints, ReportsAmbiguousRotationOfLine) {
  std::mt19937_64 rng(5);
  for (int i = 0; i < 20; ++i) {
    const Eigen::Vector3d start = RandomVector(5, &rng), direction = RandomVector(1, &rng);
    Points source;
    for (int k = 0; k < 10; ++k) source.push_back(start + k * direction);
    const Points target = Transformed(RandomPose(1.8, 5, &rng), source);
    const Alignment alignment = AlignPoints(source, target);
    EXPECT_EQ(alignment.status, AlignmentStatus::kRotationNotUnique);
    for (std::size_t k = 0; k < source.size(); ++k) {
      EXPECT_THAT(alignment.target_from_source * source[k], VectorNear(target[k], 10 * kExact));
    }
  }
}

TEST(AlignPoints, ReportsAmbiguousRotationOfSinglePoint) {
  const Alignment alignment =
      AlignPoints(Points(5, Eigen::Vector3d(1, 2, 3)), Points(5, Eigen::Vector3d(4, 5, 7)));
  EXPECT_EQ(alignment.status, AlignmentStatus::kRotationNotUnique);
  EXPECT_THAT(alignment.target_from_source * Eigen::Vector3d(1, 2, 3),
              VectorNear(Eigen::Vector3d(4, 5, 7), kExact));
}

TEST(AlignPoints, ReportsAmbiguousRotationOfMirroredOctahedron) {
  Points source, target;
  for (int i = 0; i < 3; ++i) {
    for (const double sign : {-1, 1}) {
      source.push_back(sign * Eigen::Vector3d::Unit(i));
      target.push_back(-source.back());
    }
  }
  EXPECT_EQ(AlignPoints(source, target).status, AlignmentStatus::kRotationNotUnique);
}

TEST(AlignPoints, RejectsTwoPoints) {
  EXPECT_EQ(AlignPoints(Points(2), Points(2)).status, AlignmentStatus::kTooFewPoints);
  EXPECT_EQ(AlignPoints({}, {}).status, AlignmentStatus::kTooFewPoints);
}

}  // namespace
}  // namespace surfit::testing
