// Tests of the association gates of fusion, and of the removal of overlapping surfels.
#include <gtest/gtest.h>

#include <cmath>

#include "mapping/plane_frame.h"
#include "mapping/random_surfel.h"

namespace surfit::testing {
namespace {

using Eigen::Vector3f;

// One surfel and one measured pixel, the middle of 5 x 5 pixels. At 1 m a pixel is 1 cm wide.
struct OnePair {
  Surfel surfel;
  FrameWithSurface f = BlankFrame({5, 5, 100, 100, 2, 2, {}}, 3);
  FusionOptions options;

  OnePair() {
    surfel.position_in_world = {0, 0, 1};
    surfel.normal_in_world = {0, 0, -1};
    surfel.radius_m = std::sqrt(2.f) / 100;
    surfel.confidence = 4;
    surfel.first_seen = surfel.last_seen = 2;
    SetPixel(2, 2, 1, {0, 0, -1}, &f);
  }

  FusionReport Run(SurfelMap* map) const {
    map->Append(surfel);
    Fusion fusion(options);
    const FusionReport report = Fuse(f, {}, &fusion, map);
    EXPECT_EQ(report.input_points, 1);
    EXPECT_EQ(report.removed, 0);
    return report;
  }
  bool Merges() const {
    SurfelMap map;
    const bool merged = Run(&map).merged_points == 1;
    EXPECT_EQ(map.size(), merged ? 1u : 2u);
    return merged;
  }
};

TEST(FusionGates, LimitDistanceAlongNormal) {
  for (const float sign : {-1.f, 1.f}) {
    OnePair pair;
    pair.surfel.position_in_world.z() = 1 + sign * 0.0499f;
    EXPECT_TRUE(pair.Merges());
    pair.surfel.position_in_world.z() = 1 + sign * 0.0501f;
    EXPECT_FALSE(pair.Merges());
    pair.options.merge_distance_m = 0.06f;
    EXPECT_TRUE(pair.Merges());
  }
}

TEST(FusionGates, LimitAngleBetweenNormals) {
  OnePair pair;
  const auto tilt = [&](float angle) {
    pair.surfel.normal_in_world = {0, std::sin(angle), -std::cos(angle)};
  };
  tilt(0.599f);
  EXPECT_TRUE(pair.Merges());
  tilt(0.601f);
  EXPECT_FALSE(pair.Merges());
  pair.options.merge_angle_rad = 0.7f;
  EXPECT_TRUE(pair.Merges());
}

TEST(FusionGates, LimitDistanceAcrossToSpacingOrRadius) {
  OnePair pair;
  pair.options.max_spacing_m = 0.003f;  // below half a pixel: the point projects to the same pixel
  pair.surfel.position_in_world.x() = 0.00299f;
  EXPECT_TRUE(pair.Merges());
  pair.surfel.position_in_world.x() = 0.00301f;
  EXPECT_FALSE(pair.Merges());

  // With finer pixels, the radius of the point, sqrt(2) / 1000, is the limit if it is below the
  // spacing. Outside its pixel, another measured pixel would match the surfel.
  OnePair fine;
  fine.f = BlankFrame({5, 5, 1000, 1000, 2, 2, {}}, 3);
  SetPixel(2, 2, 1, {0, 0, -1}, &fine.f);
  fine.options.max_spacing_m = 1;
  fine.surfel.normal_in_world = Vector3f(0, 0.5f, -1).normalized();
  // The surfel is below the ray by y and tilted by t. The ray intersects its plane at the distance
  // y / cos t from its centre. In the same pixel, the distance exceeds the limit only at a large
  // tilt.
  fine.options.merge_angle_rad = 1.4f;
  constexpr float kCosine = 0.3f;
  fine.surfel.normal_in_world = {0, std::sqrt(1 - kCosine * kCosine), -kCosine};
  // The limit is at 27.8 steps of a stored position.
  fine.surfel.position_in_world = {0, 27 * SmallCoordinate::kStep, 1};
  EXPECT_TRUE(fine.Merges());
  fine.surfel.position_in_world = {0, 28 * SmallCoordinate::kStep, 1};
  EXPECT_FALSE(fine.Merges());
}

// Depth noise moves a point along its ray. The position of the ray on a slanted surface does not
// change.
TEST(FusionGates, IgnoreDepthNoiseAcrossSurface) {
  OnePair pair;
  pair.options.merge_distance_m = 0.02f;
  pair.surfel.normal_in_world =
      Vector3f(0, 0.5f, -1).normalized();  // 0.46 rad from the normal of the point
  // A surfel at the distance h behind the pixel has the distance n_z h = 0.894 h along its normal.
  pair.surfel.position_in_world = {0, 0, 1 + 0.0199f / 0.8944f};
  EXPECT_TRUE(pair.Merges());
  pair.surfel.position_in_world = {0, 0, 1 + 0.0201f / 0.8944f};
  EXPECT_FALSE(pair.Merges());
}

TEST(FusionGates, CoarsePointsDoNotMoveFineSurfel) {
  OnePair pair;
  pair.surfel.position_in_world.z() = 1.01f;
  pair.surfel.radius_m = 0.0142f / 1.49f;
  SurfelMap fine_enough, too_coarse;
  EXPECT_EQ(pair.Run(&fine_enough).merged, 1);
  EXPECT_NEAR(fine_enough[0].position_in_world.z(), 1.01 - 0.01 / 5, 2 * kPositionRounding);
  EXPECT_EQ(fine_enough[0].radius_m, StoredLength(pair.surfel.radius_m));

  pair.surfel.radius_m = 0.0141f / 1.51f;
  EXPECT_EQ(pair.Run(&too_coarse).merged, 1);
  EXPECT_EQ(too_coarse[0].position_in_world.z(), StoredCoordinate(1.01f));
  EXPECT_EQ(too_coarse[0].confidence, 5);
  EXPECT_EQ(too_coarse[0].last_seen, 3);
  EXPECT_EQ(too_coarse[0].first_seen, 2);
}

TEST(FusionGates, FinerPointReducesRadius) {
  OnePair pair;
  pair.surfel.radius_m = 0.05f;
  SurfelMap map;
  pair.Run(&map);
  EXPECT_FLOAT_EQ(map[0].radius_m, StoredLength(std::sqrt(2.f) / 100));
}

TEST(FusionGates, MergeWithNearestSurfel) {
  OnePair pair;
  pair.options.duplicate_ratio = 0;
  SurfelMap map;
  Surfel other = pair.surfel;
  other.position_in_world.z() = 0.99f;
  map.Append(other);
  other.position_in_world.z() = 1.02f;
  map.Append(other);
  pair.surfel.position_in_world.z() = 1.005f;
  pair.Run(&map);
  EXPECT_EQ(Confidences(map), (std::vector<float>{4, 4, 5}));
}

// Two surfels of one pixel or of neighbour pixels, at a distance of 4 mm, with radii of sqrt(2) cm.
TEST(FusionDoubles, RemovesLessConfidentSurfel) {
  for (const float x : {0.f, 0.004f}) {  // the pixel border is at 5 mm
    OnePair pair;
    SetPixel(3, 2, 1, {0, 0, -1}, &pair.f);
    Surfel other = pair.surfel;
    pair.surfel.position_in_world.x() = x;
    other.position_in_world.x() = x + 0.004f;
    other.confidence = 7;
    SurfelMap map;
    map.Append(pair.surfel);
    map.Append(other);
    Fusion fusion(pair.options);
    EXPECT_EQ(Fuse(pair.f, {}, &fusion, &map).removed, 1);
    ASSERT_EQ(map.size(), 1u);
    EXPECT_GE(map[0].confidence, 7);
  }
}

TEST(FusionDoubles, KeepsDistantAndRotatedSurfels) {
  const auto removed = [](const Surfel& other, float duplicate_ratio) {
    OnePair pair;
    pair.options.duplicate_ratio = duplicate_ratio;
    SurfelMap map;
    map.Append(pair.surfel);
    map.Append(other);
    Fusion fusion(pair.options);
    return Fuse(pair.f, {}, &fusion, &map).removed;
  };
  Surfel other = OnePair().surfel;
  other.confidence = 7;
  other.position_in_world.x() = 0.0049f;  // the spacing of 1 cm is smaller than the radii
  EXPECT_EQ(removed(other, 0.5f), 1);
  EXPECT_EQ(removed(other, 0.48f), 0);
  EXPECT_EQ(removed(other, 0), 0);
  other.radius_m = 0.009f;
  EXPECT_EQ(removed(other, 0.5f), 0);
  other.radius_m = 0.02f;
  other.position_in_world.z() = 1.049f;
  EXPECT_EQ(removed(other, 0.5f), 1);
  other.position_in_world.z() = 1.051f;
  EXPECT_EQ(removed(other, 0.5f), 0);
  other.position_in_world.z() = 1;
  other.normal_in_world = {0, std::sin(0.61f), -std::cos(0.61f)};
  EXPECT_EQ(removed(other, 0.5f), 0);
}

// Two pixels, and one surfel in the first pixel. The second point has no surfel and merges with the
// surfel of the first pixel.
TEST(FusionGates, MergeWithSurfelOfNeighbourPixel) {
  OnePair pair;
  pair.options.max_spacing_m = 0.0125f;
  SetPixel(3, 2, 1, {0, 0, -1}, &pair.f);
  SurfelMap map;
  map.Append(pair.surfel);
  Fusion fusion(pair.options);
  const FusionReport report = Fuse(pair.f, {}, &fusion, &map);
  EXPECT_EQ(report.merged_points, 2);
  EXPECT_EQ(report.merged, 1);
  EXPECT_EQ(report.added, 0);
  const double weight = std::exp(-1. / 8 / 0.72);  // of the second point
  EXPECT_NEAR(map[0].confidence, 5 + weight, kConfidenceRounding);
  EXPECT_NEAR(map[0].position_in_world.x(), 0.01 * weight / (5 + weight), kPositionRounding);

  pair.options.max_spacing_m = 0.0075f;
  Fusion tighter(pair.options);
  SurfelMap two;
  two.Append(pair.surfel);
  EXPECT_EQ(Fuse(pair.f, {}, &tighter, &two).added, 1);
}

}  // namespace
}  // namespace surfit::testing
