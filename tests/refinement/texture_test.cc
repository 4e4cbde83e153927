// Refinement of keyframes that see one textured wall: its shape says nothing of motion along it.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "surfit/refinement/refine.h"

namespace surfit {
namespace {

constexpr double kDepth = 2;  // m, of a wall that all keyframes face

PinholeCamera Camera() { return {160, 120, 131.25, 131.25, 79.75, 59.75, {}}; }

// Waves some dozens of pixels long.
float TextureAt(double x, double y) {
  return static_cast<float>(0.5 + 0.2 * std::sin(20 * x + 5 * y) + 0.2 * std::cos(18 * y - 7 * x));
}

// What a camera shifted by this sees.
KeyframeImages ImagesAt(const Eigen::Vector2d& shift, float brighter) {
  const PinholeCamera camera = Camera();
  KeyframeImages images;
  images.inverse_depth = Image<float>(camera.width, camera.height, 1 / kDepth);
  images.slope_u = images.slope_v = Image<float>(camera.width, camera.height, 0.f);
  images.intensity = Image<float>(camera.width, camera.height);
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const Eigen::Vector2d at = kDepth * camera.Ray(u, v).head<2>() + shift;
      images.intensity(u, v) = TextureAt(at.x(), at.y()) + brighter;
    }
  }
  return images;
}

struct Wall {
  std::vector<Eigen::Vector2d> truth;
  std::vector<RefinementKeyframe> keyframes;

  // The largest error of a position along the wall, metres.
  double Error() const {
    double error = 0;
    for (std::size_t k = 0; k < truth.size(); ++k) {
      const Eigen::Vector2d found = keyframes[k].world_from_camera.translation.head<2>();
      error = std::max(error, (found - truth[k]).norm());
    }
    return error;
  }
};

// Each keyframe but the first is believed to be 12 mm beside where it is, 0.8 px, and sees all as
// much brighter as its exposure is longer.
Wall MakeWall() {
  Wall wall;
  for (int k = 0; k < 5; ++k) {
    const Eigen::Vector2d shift(0.06 * k, 0.03 * (k % 3));
    const Eigen::Vector2d error = k == 0 ? Eigen::Vector2d(0, 0) : Eigen::Vector2d(0.0096, -0.0072);
    Rigid3d pose;
    pose.translation.head<2>() = shift + (k % 2 == 0 ? error : -error);
    wall.truth.push_back(shift);
    wall.keyframes.push_back({pose, ImagesAt(shift, 0.02f * static_cast<float>(k))});
  }
  return wall;
}

RefinementSummary RefineWall(double photometric_weight, Wall* wall) {
  RefinementOptions options;
  options.free_intrinsics = options.free_depth_offset = false;
  options.motion_sigma_m = 0;
  options.error_model.photometric_weight = photometric_weight;
  return Refine(options, {Camera(), {}}, &wall->keyframes, [](const RefinementRound&) {});
}

TEST(RefineTexture, FindsMotionAlongAWallThatShapeDoesNotTell) {
  Wall wall = MakeWall(), shape_only = MakeWall();
  const double before = wall.Error();
  const RefinementSummary summary = RefineWall(1, &wall);
  ASSERT_TRUE(summary.Succeeded()) << ToString(summary.termination);
  EXPECT_GT(summary.rounds.back().texture_observations, 0u);
  EXPECT_LT(summary.after.rms_intensity, summary.before.rms_intensity / 5);
  EXPECT_LT(wall.Error(), before / 10);

  const RefinementSummary without = RefineWall(0, &shape_only);
  EXPECT_EQ(without.rounds.back().texture_observations, 0u);
  EXPECT_EQ(without.after.rms_intensity, 0);
  EXPECT_GT(shape_only.Error(), before / 2);
}

TEST(RefineTexture, HasNoTextureWhereIntensitiesAreUnknown) {
  Wall wall = MakeWall();
  for (RefinementKeyframe& keyframe : wall.keyframes) {
    keyframe.images.intensity =
        Image<float>(Camera().width, Camera().height, std::numeric_limits<float>::quiet_NaN());
  }
  const RefinementSummary summary = RefineWall(1, &wall);
  ASSERT_TRUE(summary.Succeeded()) << ToString(summary.termination);
  EXPECT_EQ(summary.rounds.back().texture_observations, 0u);
}

}  // namespace
}  // namespace surfit
