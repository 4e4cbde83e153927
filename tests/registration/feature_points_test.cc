#include "registration/global/feature_points.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "registration/simulated_views.h"
#include "testing/matchers.h"

namespace surfit::testing {

namespace {

// A shelf and a picture, in views at a distance of 10 frames.
const SimulatedColoredViews& NearViews() {
  static const auto* const views = new SimulatedColoredViews(MakeColoredViews(48, 10, 12));
  return *views;
}

constexpr int kMaxFeatures = 500;

FeaturePoints FeaturesOf(const ColoredView& view) {
  return FindFeatures(view.color, view.pyramid.levels[0], ErrorModel(), kMaxFeatures);
}

TEST(FindFeatures, FeaturesAreOnSurface) {
  const ColoredView& view = NearViews().source;
  const FeaturePoints features = FeaturesOf(view);
  ASSERT_GT(features.size(), 20);
  ASSERT_LE(features.size(), kMaxFeatures);
  ASSERT_EQ(features.descriptors.size(), features.points.size());
  ASSERT_EQ(features.sigmas_m.size(), features.points.size());
  const FrameLevel& surface = view.pyramid.levels[0];
  for (int i = 0; i < features.size(); ++i) {
    // The depth is the depth of one of the nearest 5 x 5 pixels.
    const Eigen::Vector2d pixel = surface.camera.Project(features.points[i]);
    double nearest_m = 1;
    for (int y = -2; y <= 2; ++y) {
      for (int x = -2; x <= 2; ++x) {
        const int u = static_cast<int>(std::lround(pixel.x())) + x;
        const int v = static_cast<int>(std::lround(pixel.y())) + y;
        if (u < 0 || v < 0 || u >= surface.camera.width || v >= surface.camera.height) continue;
        const double gap_m = surface.vertex.z(u, v) - features.points[i].z();
        nearest_m = std::min(nearest_m, std::abs(gap_m));
      }
    }
    EXPECT_LT(nearest_m, 1e-5) << i;  // single precision of metres
  }
}

TEST(FindFeatures, IsEmptyWithoutColorOrDepth) {
  ColoredView view = NearViews().source;
  view.pyramid.levels[0].vertex = VectorImage(160, 120);
  EXPECT_EQ(FeaturesOf(view).size(), 0);
  view = NearViews().source;
  view.color = {};
  EXPECT_EQ(FeaturesOf(view).size(), 0);
}

// Most distinctive mutual nearest neighbours of near views are correct: within three sigmas of the
// true position.
TEST(MatchFeatures, MostMatchesOfNearViewsAreCorrect) {
  const FeaturePoints source = FeaturesOf(NearViews().source);
  const FeaturePoints target = FeaturesOf(NearViews().target);
  const std::vector<FeatureMatch> matches = MatchFeatures(source, target);
  ASSERT_GT(matches.size(), 10u);
  int right = 0;
  for (const auto& [s, t] : matches) {
    const Eigen::Vector3d moved = NearViews().target_from_source * source.points[s];
    right +=
        (moved - target.points[t]).norm() < 3 * std::hypot(source.sigmas_m[s], target.sigmas_m[t]);
  }
  EXPECT_GT(right, 0.5 * static_cast<double>(matches.size()));
}

TEST(MatchFeatures, MatchesEachFeatureWithItself) {
  const FeaturePoints features = FeaturesOf(NearViews().source);
  const std::vector<FeatureMatch> matches = MatchFeatures(features, features);
  EXPECT_GT(matches.size(), 0.8 * features.size());  // except ambiguous features
  for (const auto& [s, t] : matches) EXPECT_EQ(s, t);
  EXPECT_TRUE(MatchFeatures(features, FeaturePoints()).empty());
}

const Rigid3d kPose(QuaternionExp<double>({0.3, -0.6, 0.2}), {0.5, -0.2, 0.9});

// Points in front of a camera and their transformed points. Matches starting with first_wrong are
// outliers.
struct Matched {
  FeaturePoints source, target;
  std::vector<FeatureMatch> matches;
};

Matched MakeMatched(int count, int first_wrong) {
  std::mt19937_64 generator(3);
  std::uniform_real_distribution<double> side(-1, 1), depth(1, 3);
  Matched matched;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d point(side(generator), side(generator), depth(generator));
    const Eigen::Vector3d elsewhere(side(generator), side(generator), depth(generator));
    matched.source.points.push_back(point);
    matched.target.points.push_back(i < first_wrong ? kPose * point : elsewhere);
    matched.source.sigmas_m.push_back(0.005 * point.z());
    matched.target.sigmas_m.push_back(0.01);
    matched.matches.push_back({i, i});
  }
  return matched;
}

std::vector<int> FirstOnes(int count) {
  std::vector<int> all(count);
  std::iota(all.begin(), all.end(), 0);
  return all;
}

// Exact points in double precision: 1e-12 is about a thousand roundings of metres.
TEST(FitPose, IsExactForExactPoints) {
  for (const int count : {3, 4, 20}) {
    const Matched m = MakeMatched(count, count);
    EXPECT_THAT(FitPose(m.source, m.target, m.matches, FirstOnes(count)),
                RigidNear(kPose, 1e-12, 1e-12));
  }
}

Eigen::Matrix4d ByEigen(const Matched& m) {
  Eigen::Matrix3Xd from(3, m.matches.size()), to(3, m.matches.size());
  for (int i = 0; i < from.cols(); ++i) {
    from.col(i) = m.source.points[i];
    to.col(i) = m.target.points[i];
  }
  return Eigen::umeyama(from, to, false);
}

TEST(FitPose, AgreesWithEigenForEqualWeights) {
  Matched m = MakeMatched(10, 7);
  std::fill(m.source.sigmas_m.begin(), m.source.sigmas_m.end(), 0.01);
  EXPECT_LT((FitPose(m.source, m.target, m.matches, FirstOnes(10)).Matrix() - ByEigen(m)).norm(),
            1e-12);
}

// Points and their mirror images: the result is the nearest rotation, not a reflection.
TEST(FitPose, IsRotationForReflectedPoints) {
  Matched m = MakeMatched(8, 8);
  std::fill(m.source.sigmas_m.begin(), m.source.sigmas_m.end(), 0.01);
  for (Eigen::Vector3d& point : m.target.points) point.x() = -point.x();
  EXPECT_LT((FitPose(m.source, m.target, m.matches, FirstOnes(8)).Matrix() - ByEigen(m)).norm(),
            1e-12);
}

TEST(FindConsensus, FindsPoseWithMostlyWrongMatches) {
  const Matched m = MakeMatched(100, 12);
  const std::vector<Consensus> found = FindConsensus(m.source, m.target, m.matches, 5);
  ASSERT_FALSE(found.empty());
  EXPECT_LE(found.size(), 5u);
  for (int i = 0; i < 12; ++i) {
    EXPECT_TRUE(std::binary_search(found[0].inliers.begin(), found[0].inliers.end(), i)) << i;
  }
  // An outlier within three sigmas (5 cm) has a weight of 1/13.
  EXPECT_THAT(found[0].target_from_source, RigidNear(kPose, 0.05 / 13 * 2, 0.05 / 13 * 2));
}

// Six matches of one point have errors of 2.5 sigmas, in both directions of each axis. So the pose
// of the exact matches is optimal for all matches.
TEST(FindConsensus, CountsMatchesWithinThreeSigmas) {
  constexpr int kExact = 44;
  Matched m = MakeMatched(kExact + 6, kExact + 6);
  for (int i = 0; i < 6; ++i) {
    const int match = kExact + i;
    m.source.points[match] = {0, 0, 2};
    const double sigma_m = std::hypot(m.source.sigmas_m[match], m.target.sigmas_m[match]);
    m.target.points[match] = kPose * m.source.points[match] +
                             (i % 2 == 0 ? 2.5 : -2.5) * sigma_m * Eigen::Vector3d::Unit(i / 2);
  }
  const std::vector<Consensus> found = FindConsensus(m.source, m.target, m.matches, 1);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].inliers, FirstOnes(kExact + 6));
}

TEST(FindConsensus, IsEmptyWithTooFewMatches) {
  const Matched m = MakeMatched(3, 3);
  EXPECT_TRUE(FindConsensus(m.source, m.target, m.matches, 5).empty());
}

}  // namespace

}  // namespace surfit::testing
