#include "surfit/places/keyframe_selector.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "places/simulated_places.h"
#include "surfit/core/options.h"
#include "testing/expect_input_error.h"

namespace surfit {
namespace {

using testing::ExpectInputError;
using ::testing::HasSubstr;

FrameLevel Wall(float depth_m) {
  return PreprocessDepth(Image<float>(320, 240, depth_m), {testing::PlaceCamera(), {}},
                         PreprocessOptions())
      .levels.front();
}

// Sees a wall 2 m away from the origin.
Keyframe KeyframeAtOrigin() {
  return {100, 0, Rigid3d(), MakePlaceView({{Wall(2)}}, {}, PlaceViewOptions())};
}

Rigid3d Shifted(double x_m) { return Rigid3d(Eigen::Quaterniond::Identity(), {x_m, 0, 0}); }
Rigid3d Turned(double rad) { return Rigid3d(QuaternionExp<double>({0, rad, 0}), {0, 0, 0}); }

bool IsKeyframeAt(const Rigid3d& pose, int frames_later = 1) {
  return IsKeyframe(KeyframeAtOrigin(), 100 + frames_later, Wall(2), pose, KeyframeOptions());
}

TEST(IsKeyframe, GoesByMotion) {
  const KeyframeOptions options;
  EXPECT_FALSE(IsKeyframeAt(Shifted(0.95 * options.max_distance_m)));
  EXPECT_TRUE(IsKeyframeAt(Shifted(1.05 * options.max_distance_m)));
  EXPECT_FALSE(IsKeyframeAt(Turned(0.95 * options.max_angle_rad)));
  EXPECT_TRUE(IsKeyframeAt(Turned(1.05 * options.max_angle_rad)));
}

TEST(IsKeyframe, GoesByTimeUnlessTheCameraRests) {
  const int frames = KeyframeOptions().max_frames;
  EXPECT_FALSE(IsKeyframeAt(Shifted(0.05), frames - 1));
  EXPECT_TRUE(IsKeyframeAt(Shifted(0.05), frames));
  EXPECT_FALSE(IsKeyframeAt(Shifted(0.01), 10 * frames));
}

TEST(IsKeyframe, GoesByOverlap) {
  KeyframeOptions options;
  options.max_distance_m = options.max_angle_rad = 100;
  options.min_overlap_share = 0.7;
  // A turn by t moves the image by f tan t = 0.3 of its width.
  const double turn = std::atan(0.3 * 320 / 262);
  const auto is_keyframe = [&](double rad) {
    return IsKeyframe(KeyframeAtOrigin(), 101, Wall(2), Turned(rad), options);
  };
  EXPECT_FALSE(is_keyframe(0.9 * turn));
  options.max_angle_rad = 1;  // so that the turn is not little
  EXPECT_TRUE(is_keyframe(1.3 * turn));
}

TEST(OverlapShare, CountsWhatIsInTheImageAndNotHidden) {
  const Keyframe keyframe = KeyframeAtOrigin();
  EXPECT_EQ(OverlapShare(keyframe, Wall(2), Rigid3d()), 1);
  EXPECT_EQ(OverlapShare(keyframe, Wall(1), Rigid3d()), 0);
  EXPECT_EQ(OverlapShare(keyframe, Wall(3), Rigid3d()), 1);
  // A quarter of the width, f 2 m / z: half a pixel column in eight may fall to either side.
  EXPECT_NEAR(OverlapShare(keyframe, Wall(2), Shifted(0.25 * 320 * 2 / 262)), 0.75, 8. / 320);
  EXPECT_EQ(OverlapShare(Keyframe(), Wall(2), Rigid3d()), 0);
}

TEST(KeyframeOptions, RefuseWhatMakesNoSense) {
  const auto expect_refused = [](auto change, const char* message) {
    KeyframeOptions options;
    change(options);
    ExpectInputError([&] { Validate(options); }, HasSubstr(message));
  };
  Validate(KeyframeOptions());
  expect_refused([](auto& o) { o.max_distance_m = 0; }, "max_distance_m is 0, must be positive");
  expect_refused([](auto& o) { o.max_angle_rad = -1; }, "max_angle_rad is -1, must be positive");
  expect_refused([](auto& o) { o.min_overlap_share = 2; }, "min_overlap_share is 2");
  expect_refused([](auto& o) { o.max_frames = 0; }, "max_frames is 0");
}

}  // namespace
}  // namespace surfit
