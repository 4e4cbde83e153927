#include <gtest/gtest.h>

#include "mapping/brute_force_fusion.h"
#include "mapping/random_surfel.h"
#include "testing/pixels.h"
#include "testing/random_pose.h"

namespace surfit::testing {
namespace {

PinholeCamera TinyCamera() { return {20, 15, 100, 100, 9.3, 7.1, {}}; }

// Random frame at about 1 m, with holes and random normals.
FrameWithSurface RandomFrame(std::mt19937_64* rng) {
  FrameWithSurface f = BlankFrame(TinyCamera(), 12);
  for (const auto [u, v] : PixelsOf(f.frame.depth_m)) {
    f.frame.color(u, v) = RandomColor(rng);
    const float chance = Uniform(0, 1, rng);
    const double depth_m = chance < 0.02f ? 0 : Uniform(0.97f, 1.03f, rng);
    const Eigen::Vector3d normal = RandomNormal(0.6f, rng).cast<double>();
    if (depth_m > 0) SetPixel(u, v, depth_m, chance < 0.1f ? normal * 0 : normal, &f);
  }
  return f;
}

// Surfels inside and outside the view, near the points and far from the points.
SurfelMap RandomMap(int count, const Rigid3d& world_from_camera, std::mt19937_64* rng) {
  SurfelMap map;
  for (int i = 0; i < count; ++i) {
    const double z = i % 10 == 0 ? Uniform(-1, 2, rng) : Uniform(0.92f, 1.08f, rng);
    const Eigen::Vector3d ray = TinyCamera().Ray(Uniform(-2, 21, rng), Uniform(-2, 16, rng));
    Surfel s;
    s.position_in_world = (world_from_camera * Eigen::Vector3d(z * ray)).cast<float>();
    s.normal_in_world =
        (world_from_camera.rotation * RandomNormal(0.5f, rng).cast<double>()).cast<float>();
    s.color = RandomColor(rng);
    s.radius_m = Uniform(0.005f, 0.02f, rng);
    s.confidence = Uniform(1, 199.5f, rng);
    s.color_weight = WeightByte::ToFloat(static_cast<std::uint8_t>(150 + i % 40));
    s.first_seen = s.last_seen = 11;
    s.at_edge = i % 3 == 0;
    map.Append(s);
  }
  return map;
}

// Both maps have the same merges, in single precision. Their positions differ by rounding: a few
// 1e-7 of coordinates up to 4 m, and one step of storage per axis.
void ExpectNear(const Surfel& a, const Surfel& b) {
  constexpr float kTolerance = 4e-6f;
  EXPECT_LT((a.position_in_world - b.position_in_world).norm(), kTolerance + 2 * kPositionRounding);
  // One rounding step per axis.
  EXPECT_LT((a.normal_in_world - b.normal_in_world).norm(), kTolerance + 2 * kNormalRounding);
  // A position error of 4e-6 m is 4e-4 px, and changes the colour by at most 0.1 before rounding.
  EXPECT_LE((ColorAsVector(a.color) - ColorAsVector(b.color)).lpNorm<Eigen::Infinity>(), 1);
  EXPECT_NEAR(a.color_weight, b.color_weight, a.color_weight / 7);  // one rounding step
  EXPECT_NEAR(a.radius_m, b.radius_m, b.radius_m / 2048);           // one rounding step
  EXPECT_EQ(a.confidence, b.confidence);
  EXPECT_EQ(a.first_seen, b.first_seen);
  EXPECT_EQ(a.last_seen, b.last_seen);
  EXPECT_EQ(a.at_edge, b.at_edge);
}

FusionOptions OptionsOfTrial(int trial) {
  FusionOptions options;
  options.max_spacing_m = trial % 2 == 0 ? 0.01f : 0.03f;
  options.merge_angle_rad = trial % 3 == 0 ? 0.6f : 0.9f;
  options.merge_distance_m = trial % 5 == 0 ? 0.02f : 0.05f;
  options.free_space_margin_m = 0.02f;
  return options;
}

TEST(Fusion, AgreesWithBruteForce) {
  FusionReport sum;
  int compared = 0;
  for (int trial = 0; trial < 80; ++trial) {
    std::mt19937_64 rng(trial);
    const Rigid3d pose = RandomPose(2, 2, &rng);
    const FusionOptions options = OptionsOfTrial(trial);
    const FrameWithSurface f = RandomFrame(&rng);
    SurfelMap expected = RandomMap(500, pose, &rng), actual = expected;
    BruteForceFusion brute_force(f, pose, options);
    const FusionReport expected_report = brute_force.Fuse(&expected);
    // Positions up to 4 m have a few rounding errors of 2.4e-7. Trials with closer decisions are
    // skipped.
    if (brute_force.margin() < 2e-6) continue;
    ++compared;

    Fusion fusion(options);
    const FusionReport report = fusion.Fuse(f.frame, f.surface, pose, &actual);
    EXPECT_EQ(report.input_points, expected_report.input_points);
    EXPECT_EQ(report.merged_points, expected_report.merged_points);
    EXPECT_EQ(report.merged, expected_report.merged);
    EXPECT_EQ(report.added, expected_report.added);
    EXPECT_EQ(report.removed, expected_report.removed);
    EXPECT_EQ(report.covered_points, expected_report.covered_points);
    ASSERT_EQ(actual.size(), expected.size());
    ASSERT_EQ(actual.Ids(), expected.Ids());
    for (const std::int32_t id : actual.Ids()) ExpectNear(actual[id], expected[id]);
    sum.merged_points += report.merged_points - report.merged;
    sum.added += report.added;
    sum.removed += report.removed;
    sum.covered_points += report.covered_points;
  }
  // All kinds of changes occur often.
  EXPECT_GT(compared, 15);
  EXPECT_GT(sum.merged_points, 100);
  EXPECT_GT(sum.added, 100);
  EXPECT_GT(sum.removed, 100);
  EXPECT_GT(sum.covered_points, 100);
}

}  // namespace
}  // namespace surfit::testing
