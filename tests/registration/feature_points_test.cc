#include "registration/feature_points.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "registration/simulated_views.h"

namespace surfit {
namespace {

// A shelf and a picture, seen from 10 frames apart.
const testing::SimulatedColoredViews& NearViews() {
  static const auto* const views =
      new testing::SimulatedColoredViews(testing::MakeColoredViews(48, 10, 12));
  return *views;
}

FeaturePoints FeaturesOf(const ColoredView& view) {
  return FindFeatures(view.color, view.pyramid.levels[0], ErrorModel());
}

TEST(FindFeatures, LiftsFeaturesToTheSurface) {
  const ColoredView& view = NearViews().source;
  const FeaturePoints features = FeaturesOf(view);
  ASSERT_GT(features.size(), 20);
  ASSERT_EQ(features.descriptors.width(), 128);
  ASSERT_EQ(features.descriptors.height(), features.size());
  const FrameLevel& surface = view.pyramid.levels[0];
  for (int i = 0; i < features.size(); ++i) {
    // The depth is that of one of the nearest 5 x 5 pixels.
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
    float square_sum = 0;
    for (int j = 0; j < 128; ++j) {
      square_sum += features.descriptors(j, i) * features.descriptors(j, i);
    }
    EXPECT_NEAR(square_sum, 1, 1e-5) << i;
  }
}

TEST(FindFeatures, FindsNoneWithoutColorOrDepth) {
  ColoredView view = NearViews().source;
  view.pyramid.levels[0].vertex = VectorImage(160, 120);
  EXPECT_EQ(FeaturesOf(view).size(), 0);
  view = NearViews().source;
  view.color = {};
  EXPECT_EQ(FeaturesOf(view).size(), 0);
}

// Mutual nearest neighbours that are clear are mostly right between near views: within three
// sigmas of where the true pose takes them.
TEST(MatchFeatures, AreMostlyRightBetweenNearViews) {
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
  EXPECT_GT(matches.size(), 0.8 * features.size());  // less those that look like others
  for (const auto& [s, t] : matches) EXPECT_EQ(s, t);
  EXPECT_TRUE(MatchFeatures(features, FeaturePoints()).empty());
}

}  // namespace
}  // namespace surfit
