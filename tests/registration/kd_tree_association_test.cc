#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "surfit/registration/association.h"
#include "testing/random_pose.h"
#include "testing/threads.h"

namespace surfit::testing {
namespace {

// Random points in a cube of side 2 with random normals, some of them missing.
PointSet RandomSet(int count, int seed) {
  std::mt19937_64 rng(seed);
  PointSet set;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3f point = RandomVector(1, &rng).cast<float>();
    const Eigen::Vector3f normal = RandomVector(1, &rng).normalized().cast<float>();
    const bool has_normal = i % 7 != 0;
    set.Add(point, has_normal ? normal : Eigen::Vector3f::Zero(), 0.01f * (1 + i % 5));
  }
  return set;
}

Rigid3d SomePose(int seed = 3) {
  std::mt19937_64 rng(seed);
  return RandomPose(0.1, 0.1, &rng);
}

int BruteForceNearest(const std::vector<Eigen::Vector3f>& points, const Eigen::Vector3f& query) {
  int nearest = 0;
  for (std::size_t i = 1; i < points.size(); ++i) {
    if ((points[i] - query).norm() < (points[nearest] - query).norm())
      nearest = static_cast<int>(i);
  }
  return nearest;
}

bool Within(const KdTreeAssociationOptions& options, double distance_m, const Eigen::Vector3f& m,
            const Eigen::Vector3f& n) {
  const AssociationGates& gates = options.gates;
  const bool gated = gates.max_normal_angle_rad > 0;
  const bool needs_n = gated || options.needed_normals != NeededNormals::kNone;
  const bool needs_m = gated || options.needed_normals == NeededNormals::kBoth;
  return !(gates.max_distance_m > 0 && distance_m > gates.max_distance_m) &&
         !(needs_n && n.isZero(0)) && !(needs_m && m.isZero(0)) &&
         !(gated && m.dot(n) < std::cos(gates.max_normal_angle_rad));
}

// Correspondences by definition, sorted: p, q, n, m and information of each.
using PairList = std::vector<std::vector<float>>;
std::vector<float> Row(const Eigen::Vector3f& p, const Eigen::Vector3f& q, const Eigen::Vector3f& n,
                       const Eigen::Vector3f& m, float information) {
  return {p.x(), p.y(), p.z(), q.x(), q.y(), q.z(),      n.x(),
          n.y(), n.z(), m.x(), m.y(), m.z(), information};
}

PairList BruteForcePairs(const PointSet& source, const PointSet& target,
                         const KdTreeAssociationOptions& options, const Rigid3d& pose) {
  const Eigen::Matrix3f rotation = pose.rotation.toRotationMatrix().cast<float>();
  const Eigen::Vector3f translation = pose.translation.cast<float>();
  std::vector<Eigen::Vector3f> moved;
  for (const auto& point : source.points) moved.push_back(rotation * point + translation);
  PairList pairs;
  for (std::size_t i = 0; i < source.size(); ++i) {
    const int j = BruteForceNearest(target.points, moved[i]);
    const Eigen::Vector3f q = target.points[j], n = target.normals[j];
    const Eigen::Vector3f m = rotation * source.normals[i];
    if (!Within(options, (moved[i] - q).norm(), m, n)) continue;
    if (options.reciprocal && BruteForceNearest(moved, q) != static_cast<int>(i)) continue;
    pairs.push_back(Row(moved[i], q, n, m, 1 / (source.sigma_m[i] * source.sigma_m[i])));
  }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

PairList PairsOf(const Association& association, const Rigid3d& pose) {
  const PairBuffer found = association.Collect(pose);
  PairList pairs;
  for (int i = 0; i < found.size; ++i) {
    pairs.push_back(Row(found.p(i), found.q(i), found.n(i), found.m(i), found.information[i]));
  }
  return pairs;
}

PairList Sorted(PairList pairs) {
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

KdTreeAssociation Make(const PointSet& source, const PointSet& target,
                       const KdTreeAssociationOptions& options) {
  return {SearchablePoints(source), SearchablePoints(target), options};
}

TEST(KdTreeAssociation, AgreesWithBruteForce) {
  const PointSet source = RandomSet(700, 1), target = RandomSet(600, 2);
  for (const NeededNormals needed :
       {NeededNormals::kNone, NeededNormals::kTarget, NeededNormals::kBoth}) {
    for (const double distance_m : {0., 0.08}) {
      for (const double angle_rad : {0., 1.2}) {
        for (const bool reciprocal : {false, true}) {
          KdTreeAssociationOptions options{{distance_m, angle_rad}, needed, reciprocal};
          const KdTreeAssociation association = Make(source, target, options);
          const PairList expected = BruteForcePairs(source, target, options, SomePose());
          EXPECT_GT(expected.size(), 5u);
          EXPECT_EQ(Sorted(PairsOf(association, SomePose())), expected);
        }
      }
    }
  }
}

TEST(KdTreeAssociation, IsIndependentOfEarlierSearches) {
  const PointSet source = RandomSet(700, 1), target = RandomSet(600, 2);
  const KdTreeAssociation used = Make(source, target, {});
  for (const int seed : {3, 4, 3, 5}) {
    const KdTreeAssociation fresh = Make(source, target, {});
    EXPECT_EQ(PairsOf(used, SomePose(seed)), PairsOf(fresh, SomePose(seed)));
  }
}

// Every third point in an order along a space-filling curve: each octant of the cube has its share.
TEST(KdTreeAssociation, StrideSubsamplesSourceEvenly) {
  const PointSet source = RandomSet(3000, 1), target = RandomSet(1200, 2);
  KdTreeAssociationOptions options{{0, 0}, NeededNormals::kNone};
  const PairList all = Sorted(PairsOf(Make(source, target, options), Rigid3d()));
  options.source_stride = 3;
  const KdTreeAssociation thinned = Make(source, target, options);
  EXPECT_EQ(thinned.source_count(), 1000);
  const PairList pairs = Sorted(PairsOf(thinned, Rigid3d()));
  EXPECT_EQ(pairs.size(), 1000u);
  EXPECT_TRUE(std::includes(all.begin(), all.end(), pairs.begin(), pairs.end()));
  int counts[8] = {};
  for (const auto& pair : pairs) ++counts[(pair[0] > 0) + 2 * (pair[1] > 0) + 4 * (pair[2] > 0)];
  // The standard deviation of a random count of 125 is 10.5.
  for (const int count : counts) EXPECT_NEAR(count, 125, 3 * 10.5);
}

TEST(KdTreeAssociation, SupportsEmptySets) {
  const PointSet none, some = RandomSet(10, 1);
  EXPECT_EQ(Make(none, some, {}).source_count(), 0);
  EXPECT_TRUE(PairsOf(Make(none, some, {}), Rigid3d()).empty());
  EXPECT_TRUE(PairsOf(Make(some, none, {}), Rigid3d()).empty());
}

TEST(KdTreeAssociation, UsesValidPointsOfFrame) {
  FrameLevel level;
  level.vertex = VectorImage(3, 1);
  level.normal = VectorImage(3, 1);
  level.vertex.Set(0, 0, {0.5f, 0, 2});
  level.normal.Set(0, 0, {0, 0, -1});
  level.vertex.Set(2, 0, {1, 0, 4});
  const ErrorModel error_model;
  const PointSet set = PointSetOf(level, error_model);
  ASSERT_EQ(set.size(), 2u);
  EXPECT_EQ(set.points[1], Eigen::Vector3f(1, 0, 4));
  EXPECT_EQ(set.normals[0], Eigen::Vector3f(0, 0, -1));
  EXPECT_TRUE(set.normals[1].isZero(0));
  EXPECT_EQ(set.sigma_m[1], static_cast<float>(error_model.Sigma(4, {})));
}

TEST(KdTreeAssociation, IsTheSameAtAnyNumberOfThreads) {
  const PointSet source = RandomSet(20000, 1), target = RandomSet(20000, 2);
  const auto pairs = AtThreads({1, 4}, [&] {
    const KdTreeAssociation association = Make(source, target, {});
    PairsOf(association, SomePose(4));
    return PairsOf(association, SomePose());
  });
  EXPECT_EQ(pairs[0], pairs[1]);
}

}  // namespace
}  // namespace surfit::testing
