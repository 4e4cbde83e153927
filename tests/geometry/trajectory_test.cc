#include "surfit/geometry/trajectory.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <utility>

#include "surfit/geometry/sensor.h"
#include "testing/matchers.h"

namespace surfit::testing {
namespace {

Rigid3d Pose(double turn_rad, double x_m) {
  return Rigid3d(QuaternionExp<double>({0, turn_rad, 0}), {x_m, 0, 0});
}

const Trajectory kTrajectory = {{1.0, Pose(0, 0)}, {1.1, Pose(0.4, 2)}, {2.1, Pose(1, 5)}};

TEST(InterpolatePose, IsLinearBetweenNearPoses) {
  const auto pose = InterpolatePose(kTrajectory, 1.025, 0.11);
  ASSERT_TRUE(pose);
  EXPECT_THAT(*pose, RigidNear(Pose(0.1, 0.5), 1e-12, 1e-12));
}

TEST(InterpolatePose, IsExactAtStamp) {
  EXPECT_THAT(*InterpolatePose(kTrajectory, 1.1), RigidNear(Pose(0.4, 2), 0, 0));
}

TEST(InterpolatePose, IsNearestPoseInWideGapsAndAtEnds) {
  EXPECT_THAT(*InterpolatePose(kTrajectory, 1.115), RigidNear(Pose(0.4, 2), 0, 0));
  EXPECT_THAT(*InterpolatePose(kTrajectory, 2.085), RigidNear(Pose(1, 5), 0, 0));
  EXPECT_THAT(*InterpolatePose(kTrajectory, 0.985), RigidNear(Pose(0, 0), 0, 0));
  EXPECT_THAT(*InterpolatePose(kTrajectory, 2.115), RigidNear(Pose(1, 5), 0, 0));
}

TEST(InterpolatePose, IsNulloptFarFromAllPoses) {
  EXPECT_FALSE(InterpolatePose(kTrajectory, 1.5));
  EXPECT_FALSE(InterpolatePose(kTrajectory, 0.9));
  EXPECT_FALSE(InterpolatePose(kTrajectory, 2.2));
  EXPECT_FALSE(InterpolatePose({}, 1));
}

std::vector<std::pair<int, int>> Pairs(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<std::pair<int, int>> pairs;
  for (const auto [i, j] : MatchStamps(a, b, 0.02)) pairs.emplace_back(i, j);
  return pairs;
}

using P = std::vector<std::pair<int, int>>;

TEST(MatchStamps, PairsNearestNeighbours) {
  EXPECT_EQ(Pairs({1.0, 1.1, 1.2}, {1.01, 1.095, 1.205}), (P{{0, 0}, {1, 1}, {2, 2}}));
}

TEST(MatchStamps, IgnoresStampsWithoutPartner) {
  EXPECT_EQ(Pairs({1.0, 1.1, 1.2}, {1.021, 1.119, 1.3}), (P{{1, 1}}));
  EXPECT_EQ(Pairs({}, {1.0}), P{});
  EXPECT_EQ(Pairs({1.0}, {}), P{});
}

TEST(MatchStamps, PrefersClosestPairAndUsesEachStampOnce) {
  // 1.012 matches 1.010, which is nearer than 1.000. So 1.000 has no match.
  EXPECT_EQ(Pairs({1.000, 1.010}, {1.012}), (P{{1, 0}}));
  // 1.000 matches 0.985, the other stamp within 0.02 s.
  EXPECT_EQ(Pairs({1.000, 1.010}, {0.985, 1.012}), (P{{0, 0}, {1, 1}}));
}

TEST(MatchStamps, MatchesAtTheLimit) {
  // Powers of two, so that the differences are exact.
  for (const double other : {0.75, 1.25}) {
    EXPECT_EQ(MatchStamps({1.0}, {other}, 0.25).size(), 1u);
    EXPECT_TRUE(MatchStamps({1.0}, {other}, 0.2499999).empty());
  }
}

TEST(MatchStamps, MatchesEqualStampsOnce) {
  const auto matches = MatchStamps({1, 1, 2}, {1, 2, 2}, 0);
  ASSERT_EQ(matches.size(), 2u);
  EXPECT_EQ(std::make_pair(matches[0].first, matches[0].second), std::make_pair(0, 0));
  EXPECT_EQ(std::make_pair(matches[1].first, matches[1].second), std::make_pair(2, 1));
}

// The closest pair is 1.010 and 1.009, so 1.000 and 1.019 remain. These two matches would cross.
TEST(MatchStamps, NeverCross) {
  EXPECT_EQ(Pairs({1.000, 1.010}, {1.009, 1.019}), (P{{0, 0}, {1, 1}}));
}

// Algorithm of associate.py: matches the closest remaining pair within the limit until no pair is
// left. The matches of a crossing exchange their partners.
std::vector<std::pair<int, int>> BruteForce(const std::vector<double>& a,
                                            const std::vector<double>& b) {
  std::vector<bool> used_a(a.size()), used_b(b.size());
  std::vector<std::pair<int, int>> pairs;
  for (;;) {
    double best = std::numeric_limits<double>::infinity();
    std::pair<int, int> pair;
    for (std::size_t i = 0; i < a.size(); ++i) {
      for (std::size_t j = 0; j < b.size(); ++j) {
        const double difference = std::abs(a[i] - b[j]);
        if (used_a[i] || used_b[j] || difference > 0.02 || difference >= best) continue;
        best = difference;
        pair = {static_cast<int>(i), static_cast<int>(j)};
      }
    }
    if (std::isinf(best)) break;
    used_a[pair.first] = used_b[pair.second] = true;
    pairs.push_back(pair);
  }
  std::sort(pairs.begin(), pairs.end());
  std::vector<int> second;
  for (const auto& pair : pairs) second.push_back(pair.second);
  std::sort(second.begin(), second.end());
  for (std::size_t i = 0; i < pairs.size(); ++i) pairs[i].second = second[i];
  return pairs;
}

TEST(MatchStamps, AgreesWithBruteForce) {
  std::mt19937_64 rng(11);
  for (int trial = 0; trial < 50; ++trial) {
    std::vector<double> a(40), b(35);
    for (auto* list : {&a, &b}) {
      for (double& stamp : *list) stamp = static_cast<double>(rng() % 100000) * 1e-5;
      std::sort(list->begin(), list->end());
    }
    EXPECT_EQ(Pairs(a, b), BruteForce(a, b));
  }
}

const Eigen::Matrix3d kMirror = Eigen::Vector3d(1, -1, 1).asDiagonal();

Rigid3d SomePose() { return Rigid3d(QuaternionExp<double>({0.4, -0.7, 0.2}), {0.5, -1.5, 2.5}); }

TEST(Mirror, MirroredPoseIsConjugateByS) {
  Eigen::Matrix4d s = Eigen::Matrix4d::Identity();
  s(1, 1) = -1;
  const Eigen::Matrix4d expected = s * SomePose().Matrix() * s;
  EXPECT_LT((Mirrored(SomePose()).Matrix() - expected).norm(), 1e-14);
  EXPECT_LT((Mirrored(Mirrored(SomePose())).Matrix() - SomePose().Matrix()).norm(), 1e-14);
}

TEST(Mirror, MirroredCameraProjectsMirroredPointToSamePixel) {
  PinholeCamera camera;
  camera.fx = 481.2;
  camera.fy = -480;
  camera.cx = 319.5;
  camera.cy = 239.5;
  const Eigen::Vector3d point_in_camera(0.3, 0.4, 2);  // y up: above the optical axis
  const Eigen::Vector2d pixel = camera.Project(point_in_camera);
  EXPECT_LT(pixel.y(), camera.cy);  // the upper half of the image
  const PinholeCamera mirrored = Mirrored(camera);
  EXPECT_EQ(mirrored.fy, 480);
  EXPECT_LT((mirrored.Project(kMirror * point_in_camera) - pixel).norm(), 1e-12);
}

TEST(Mirror, MirrorsWorldPointsThroughPoseAndCamera) {
  const Eigen::Vector3d point_in_camera(0.3, 0.4, 2);
  const Eigen::Vector3d expected = kMirror * (SomePose() * point_in_camera);
  EXPECT_LT((Mirrored(SomePose()) * (kMirror * point_in_camera) - expected).norm(), 1e-14);
}

}  // namespace
}  // namespace surfit::testing
