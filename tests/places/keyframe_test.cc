#include "surfit/loop_closure/keyframe.h"

#include <gmock/gmock.h>

#include "places/simulated_places.h"
#include "surfit/core/options.h"
#include "surfit/frame/frame_pyramid.h"
#include "surfit/frame/rectify_frame.h"
#include "testing/matchers.h"
#include "testing/pixels.h"

namespace surfit::testing {

namespace {

// Wall of one colour at 2 m. The colour of the upper left quarter is unknown.
struct Wall {
  FramePyramid pyramid =
      PreprocessDepth(Image<float>(320, 240, 2.f), {PlaceCamera(), {}}, PreprocessOptions());
  Image<Rgb8> color = Image<Rgb8>(320, 240, Rgb8{100, 100, 100});

  Wall() {
    for (const auto [u, v] : PixelsOf(160, 120)) color(u, v) = Rgb8();
  }
};

TEST(MakePlaceView, KeepsDepthAndIntensityUpToRounding) {
  const Wall wall;
  const PlaceView view = MakePlaceView(wall.pyramid, wall.color, PlaceViewOptions());
  const FramePyramid again = PyramidOf(view, PreprocessOptions());
  ASSERT_EQ(again.levels.size(), wall.pyramid.levels.size());
  const FrameLevel& level = again.levels.front();
  for (int v = 7; v < 233; v += 7) {  // the border has no normals
    for (int u = 7; u < 313; u += 7) {
      EXPECT_NEAR(level.vertex.z(u, v), 2, 0.5 / PlaceView::kDepthUnitsPerMetre + 1e-6);
      EXPECT_LT((level.normal(u, v) - Eigen::Vector3f(0, 0, -1)).norm(), 1e-3);
      if (u < 160 && v < 120) {
        EXPECT_TRUE(std::isnan(level.intensity(u, v)));
      } else {
        EXPECT_NEAR(level.intensity(u, v), 100 / 255., 0.5 / 254 + 1e-6);
      }
    }
  }
}

TEST(MakePlaceView, HalvesWideImages) {
  const Wall wall;
  PlaceViewOptions options;
  options.max_width = 160;
  const PlaceView view = MakePlaceView(wall.pyramid, wall.color, options);
  EXPECT_EQ(view.camera.width, 160);
  EXPECT_EQ(view.camera.fx, PlaceCamera().Binned(2).fx);
  EXPECT_EQ(view.depth.width(), 160);
  EXPECT_EQ(view.intensity.height(), 120);
}

TEST(MakePlaceView, RemovesDepthBeyondRange) {
  const FramePyramid far =
      PreprocessDepth(Image<float>(320, 240, 14.f), {PlaceCamera(), {}}, PreprocessOptions());
  for (const std::uint16_t units : MakePlaceView(far, {}, PlaceViewOptions()).depth) {
    EXPECT_EQ(units, 0);
  }
}

TEST(MakePlaceView, HasNoFeaturesWithoutTextureOrColor) {
  const Wall wall;
  const Image<Rgb8> even(320, 240, Rgb8{90, 90, 90});
  EXPECT_TRUE(MakePlaceView(wall.pyramid, even, PlaceViewOptions()).features.empty());
  const PlaceView colorless = MakePlaceView(wall.pyramid, {}, PlaceViewOptions());
  EXPECT_TRUE(colorless.features.empty());
  EXPECT_TRUE(colorless.intensity.empty());
  EXPECT_TRUE(PyramidOf(colorless, PreprocessOptions()).levels.front().intensity.empty());
}

// Input of a view: depth in m that is linear in both pixel coordinates.
Image<float> SlopingDepth() {
  Image<float> depth_m(320, 240);
  for (const auto [u, v] : PixelsOf(320, 240)) {
    depth_m(u, v) = 2.f + 0.002f * static_cast<float>(u) - 0.001f * static_cast<float>(v);
  }
  return depth_m;
}

// The calibration corrects the depth before or after the view is made. Without a depth filter, the
// views differ by the rounding of depth, twice.
TEST(Recalibrate, GivesViewOfCorrectedDepth) {
  DepthCalibration calibration = {PlaceCamera(), {{0.01, -0.02, 0.005, 0.01, 0, -0.01}}, 0};
  calibration.camera.fx += 4;
  calibration.camera.cy -= 3;
  PreprocessOptions preprocess;
  preprocess.filter_radius_px = 0;
  PlaceViewOptions options;
  for (const int width : {320, 160}) {
    options.max_width = width;
    PlaceView view = MakePlaceView(PreprocessDepth(SlopingDepth(), {PlaceCamera(), {}}, preprocess),
                                   {}, options);
    Recalibrate(calibration, &view);
    Image<float> corrected_m = SlopingDepth();
    CorrectDepth(calibration.camera, calibration.field, &corrected_m);
    const PlaceView expected = MakePlaceView(
        PreprocessDepth(corrected_m, {calibration.camera, {}}, preprocess), {}, options);
    EXPECT_EQ(view.field.coefficients, calibration.field.coefficients);
    EXPECT_DOUBLE_EQ(view.camera.fx, expected.camera.fx);
    EXPECT_DOUBLE_EQ(view.camera.cy, expected.camera.cy);
    ASSERT_EQ(view.depth.size(), expected.depth.size());
    for (std::size_t i = 0; i < view.depth.size(); ++i) {
      ASSERT_NEAR(view.depth[i], expected.depth[i], 2) << width << ", pixel " << i;
    }
  }
}

TEST(Recalibrate, MovesFeaturesWithTheirPixels) {
  const DepthCalibration calibration = {PlaceCamera(), {{0.02, 0, 0, 0, 0, 0}}, 0};
  PlaceView view = MakePlaceView(Wall().pyramid, {}, PlaceViewOptions());
  view.features = {{{0.5f, -0.25f, 2}, {}}, {{0, 0, 100}, {}}};
  Recalibrate({PlaceCamera(), {{-0.02, 0, 0, 0, 0, 0}}, 0}, &view);
  ASSERT_EQ(view.features.size(), 1u) << "the inverse depth of the second feature is negative";
  Recalibrate(calibration, &view);
  const Eigen::Vector3f expected = Eigen::Vector3f(0.5f, -0.25f, 2) / (1 + 2 * 0.02f);
  EXPECT_LT((view.features[0].point - expected).norm(), 1e-5);
}

TEST(Recalibrate, KeepsViewWithSameCalibration) {
  PlaceView view = MakePlaceView(Wall().pyramid, {}, PlaceViewOptions());
  const PlaceView before = view;
  Recalibrate({PlaceCamera(), {}, 0.01}, &view);
  EXPECT_EQ(view.depth, before.depth);
  PlaceView empty;
  Recalibrate({PlaceCamera(), {}, 0}, &empty);
  EXPECT_TRUE(empty.empty());
}

// 320 x 240 pixels of three bytes, and at most 500 features of 48 bytes.
TEST(MakePlaceView, HasSizeOfBytes) {
  const PlaceView& view = MakeRoomOfKeyframes(1).keyframes.front().view;
  EXPECT_GT(view.features.size(), 100);
  EXPECT_LE(view.features.size(), 500);
  EXPECT_EQ(view.Bytes(), 320 * 240 * 3 + view.features.size() * sizeof(PlaceFeature));
  EXPECT_LT(view.Bytes(), 260'000);
}

TEST(MakePlaceView, FeaturesAreOnSurface) {
  const PlaceView& view = MakeRoomOfKeyframes(1).keyframes.front().view;
  int near = 0;
  for (const PlaceFeature& feature : view.features) {
    const Eigen::Vector2d pixel = view.camera.Project(feature.point.cast<double>());
    const int u = static_cast<int>(std::lround(pixel.x()));
    const int v = static_cast<int>(std::lround(pixel.y()));
    ASSERT_TRUE(u >= 0 && v >= 0 && u < 320 && v < 240);
    const double depth_m = view.depth(u, v) / PlaceView::kDepthUnitsPerMetre;
    near += std::abs(depth_m - feature.point.z()) < 0.05;
  }
  // At edges the median of the neighbours can be on the other surface.
  EXPECT_GT(near, 0.8 * static_cast<double>(view.features.size()));
}

TEST(PlaceViewOptions, RejectInvalidValues) {
  const auto expect_refused = ExpectOptionsRefused<PlaceViewOptions>;
  expect_refused([](auto& o) { o.max_width = 79; }, "max_width", "79");
  expect_refused([](auto& o) { o.max_features = 47; }, "max_features", "47");
}

FrameLevel WallAt(float depth_m) {
  return PreprocessDepth(Image<float>(320, 240, depth_m), {PlaceCamera(), {}}, PreprocessOptions())
      .levels.front();
}

Keyframe KeyframeAtOrigin() {
  return {100, 0, Rigid3d(), MakePlaceView({{WallAt(2)}}, {}, PlaceViewOptions())};
}

Rigid3d Shifted(double x_m) { return Rigid3d(Eigen::Quaterniond::Identity(), {x_m, 0, 0}); }
Rigid3d Turned(double rad) { return Rigid3d(QuaternionExp<double>({0, rad, 0}), {0, 0, 0}); }

bool IsKeyframeAt(const Rigid3d& pose, int frames_later = 1) {
  return IsKeyframe(KeyframeAtOrigin(), 100 + frames_later, WallAt(2), pose, KeyframeOptions());
}

TEST(IsKeyframe, DependsOnMotion) {
  const KeyframeOptions options;
  EXPECT_FALSE(IsKeyframeAt(Shifted(0.95 * options.max_distance_m)));
  EXPECT_TRUE(IsKeyframeAt(Shifted(1.05 * options.max_distance_m)));
  EXPECT_FALSE(IsKeyframeAt(Turned(0.95 * options.max_angle_rad)));
  EXPECT_TRUE(IsKeyframeAt(Turned(1.05 * options.max_angle_rad)));
}

TEST(IsKeyframe, DependsOnFrameCountOfMovingCamera) {
  const int frames = KeyframeOptions().max_frames;
  EXPECT_FALSE(IsKeyframeAt(Shifted(0.05), frames - 1));
  EXPECT_TRUE(IsKeyframeAt(Shifted(0.05), frames));
  EXPECT_FALSE(IsKeyframeAt(Shifted(0.01), 10 * frames));
}

TEST(IsKeyframe, DependsOnOverlap) {
  KeyframeOptions options;
  options.max_distance_m = options.max_angle_rad = 100;
  options.min_overlap_ratio = 0.7;
  // A rotation by t shifts the image by f tan t = 0.3 of its width.
  const double turn = std::atan(0.3 * 320 / 262);
  const auto is_keyframe = [&](double rad) {
    return IsKeyframe(KeyframeAtOrigin(), 101, WallAt(2), Turned(rad), options);
  };
  EXPECT_FALSE(is_keyframe(0.9 * turn));
  options.max_angle_rad = 1;  // the rotation exceeds the small-motion threshold
  EXPECT_TRUE(is_keyframe(1.3 * turn));
}

TEST(OverlapRatio, CountsVisiblePoints) {
  const Keyframe keyframe = KeyframeAtOrigin();
  EXPECT_EQ(OverlapRatio(keyframe, WallAt(2), Rigid3d()), 1);
  EXPECT_EQ(OverlapRatio(keyframe, WallAt(1), Rigid3d()), 0);
  EXPECT_EQ(OverlapRatio(keyframe, WallAt(3), Rigid3d()), 1);
  // A quarter of the width, f 2 m / z. The error is half a pixel column of the grid of eight.
  EXPECT_NEAR(OverlapRatio(keyframe, WallAt(2), Shifted(0.25 * 320 * 2 / 262)), 0.75, 8. / 320);
  EXPECT_EQ(OverlapRatio(Keyframe(), WallAt(2), Rigid3d()), 0);
}

// The camera moves 1 m towards the wall at 2 m. The wall is twice as large in the image, so a
// quarter of the points stay in the image. The error is one row or column of eight pixels.
TEST(OverlapRatio, IsQuarterAtHalfDistance) {
  const Rigid3d nearer(Eigen::Quaterniond::Identity(), {0, 0, 1});
  EXPECT_NEAR(OverlapRatio(KeyframeAtOrigin(), WallAt(1), nearer), 0.25, 8. / 240);
}

TEST(KeyframeOptions, RejectInvalidValues) {
  const auto expect_refused = ExpectOptionsRefused<KeyframeOptions>;
  Validate(KeyframeOptions());
  expect_refused([](auto& o) { o.max_distance_m = 0; }, "max_distance_m", "0");
  expect_refused([](auto& o) { o.max_angle_rad = -1; }, "max_angle_rad", "-1");
  expect_refused([](auto& o) { o.min_overlap_ratio = 2; }, "min_overlap_ratio", "2");
  expect_refused([](auto& o) { o.max_frames = 0; }, "max_frames", "0");
}

}  // namespace

}  // namespace surfit::testing
