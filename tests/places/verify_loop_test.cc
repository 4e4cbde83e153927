#include <gmock/gmock.h>

#include "places/simulated_places.h"
#include "surfit/core/options.h"
#include "surfit/loop_closure/find_loops.h"
#include "testing/matchers.h"
#include "testing/pixels.h"
#include "testing/threads.h"

namespace surfit::testing {
namespace {

const VerifyLoopOptions kOptions;

Rigid3d NearbyPose() {
  return Rigid3d(QuaternionExp<double>({0.03, 0.15, -0.05}), {0.15, 0.04, 0.1});
}

// Squared Mahalanobis distance of the pose error.
double SquaredError(const GlobalRegistrationResult& verdict, const Rigid3d& truth) {
  const Rigid3d off = truth * verdict.target_from_source.Inverse();
  Vector6d error;
  error << QuaternionLog<double>(off.rotation), off.translation;
  return error.dot(verdict.information * error);
}

// 20 views of two rooms, near keyframes. The threshold is chi-square 20 with six degrees of
// freedom: the probability of three sigmas of a normal variable.
TEST(VerifyLoop, AcceptsCorrectLoopsWithinTheirCovariance) {
  int tried = 0, accepted = 0;
  for (const std::uint64_t seed : {1, 2}) {
    const RoomOfKeyframes& room = MakeRoomOfKeyframes(seed);
    for (int i = 0; i < 30; i += 3) {
      const auto [view, truth] = SeeNearby(room, i, NearbyPose());
      const GlobalRegistrationResult verdict = VerifyLoop(view, room.keyframes[i].view, kOptions);
      ++tried;
      if (!verdict.accepted()) continue;
      ++accepted;
      EXPECT_THAT(verdict.target_from_source, RigidNear(truth, 0.02, 0.5 * kRadPerDeg));
      EXPECT_LT(SquaredError(verdict, truth), 20) << seed << ' ' << i;
    }
  }
  EXPECT_GE(accepted, 0.7 * tried);
}

TEST(VerifyLoop, AcceptsPriorInsteadOfFeatures) {
  const RoomOfKeyframes& room = MakeRoomOfKeyframes(2);
  auto [view, truth] = SeeNearby(room, 3, NearbyPose());
  view.features.clear();
  const PlaceView& target = room.keyframes[3].view;
  EXPECT_EQ(VerifyLoop(view, target, kOptions).reason, GlobalRegistrationReason::kNoStart);
  const Rigid3d prior =
      LeftIncrement<double>((Vector6d() << 0.02, -0.03, 0.01, 0.04, -0.03, 0.04).finished(), truth);
  const GlobalRegistrationResult verdict = VerifyLoop(view, target, kOptions, prior);
  EXPECT_EQ(ToString(verdict.reason), "accepted");
  EXPECT_THAT(verdict.target_from_source, RigidNear(truth, 0.01, 0.5 * kRadPerDeg));
}

TEST(VerifyLoop, RejectsViewsWithoutDepth) {
  const PlaceView& view = MakeRoomOfKeyframes(1).keyframes[0].view;
  EXPECT_EQ(VerifyLoop(PlaceView(), view, kOptions).reason, GlobalRegistrationReason::kNoView);
  EXPECT_EQ(VerifyLoop(view, PlaceView(), kOptions).reason, GlobalRegistrationReason::kNoView);
  PlaceView missing = view;
  for (std::uint16_t& units : missing.depth) units = 0;
  EXPECT_EQ(VerifyLoop(missing, view, kOptions, Rigid3d()).reason,
            GlobalRegistrationReason::kNotRegistered);
}

TEST(VerifyLoop, RejectsWallWithoutTexture) {
  const FramePyramid pyramid =
      PreprocessDepth(Image<float>(320, 240, 2.f), {PlaceCamera(), {}}, PreprocessOptions());
  const PlaceView wall =
      MakePlaceView(pyramid, Image<Rgb8>(320, 240, {120, 120, 120}), PlaceViewOptions());
  EXPECT_EQ(VerifyLoop(wall, wall, kOptions).reason, GlobalRegistrationReason::kNoStart);
  EXPECT_FALSE(VerifyLoop(wall, wall, kOptions, Rigid3d()).accepted());
}

TEST(VerifyLoop, RejectsSameGeometryWithOtherTexture) {
  const RoomOfKeyframes& room = MakeRoomOfKeyframes(1);
  PlaceView other = room.keyframes[0].view;
  other.intensity = room.keyframes[15].view.intensity;
  EXPECT_EQ(VerifyLoop(other, room.keyframes[0].view, kOptions, Rigid3d()).reason,
            GlobalRegistrationReason::kLooksDifferent);
  other.intensity = {};
  EXPECT_EQ(VerifyLoop(other, room.keyframes[0].view, kOptions, Rigid3d()).reason,
            GlobalRegistrationReason::kLooksDifferent);
}

// Rooms of two seeds have similar walls and floors. The prior claims the same place.
TEST(VerifyLoop, RejectsOtherPlaces) {
  const RoomOfKeyframes &room = MakeRoomOfKeyframes(1), &other = MakeRoomOfKeyframes(2);
  for (int i = 0; i < 30; i += 3) {
    for (int j = 0; j < 30; j += 6) {
      const GlobalRegistrationResult verdict =
          VerifyLoop(room.keyframes[i].view, other.keyframes[j].view, kOptions, Rigid3d());
      EXPECT_FALSE(verdict.accepted()) << i << ' ' << j;
    }
  }
}

// With prior errors up to 30 cm and 15 degrees, only correct registrations are accepted.
TEST(VerifyLoop, AcceptsOnlyCorrectFitsWithWrongPriors) {
  const RoomOfKeyframes& room = MakeRoomOfKeyframes(2);
  int refused = 0;
  for (int i = 0; i < 30; i += 5) {
    auto [view, truth] = SeeNearby(room, i, NearbyPose());
    view.features.clear();
    for (const double side : {-1., 1.}) {
      Vector6d off;
      off << 0, 0.25 * side, 0, 0.2, 0.1 * side, -0.2 * side;
      const GlobalRegistrationResult verdict =
          VerifyLoop(view, room.keyframes[i].view, kOptions, LeftIncrement<double>(off, truth));
      if (verdict.accepted()) {
        EXPECT_THAT(verdict.target_from_source, RigidNear(truth, 0.02, 0.5 * kRadPerDeg)) << i;
      }
      refused += !verdict.accepted();
    }
  }
  EXPECT_GT(refused, 0);
}

// Wall of a corridor with stripes every 10 cm: geometry does not constrain the translation along
// the wall, and the texture is ambiguous.
PlaceView StripedWall(double shift_m) {
  constexpr double kDepthM = 2, kPeriodM = 0.1;
  Image<float> depth_m(320, 240, static_cast<float>(kDepthM));
  Image<Rgb8> color(320, 240);
  for (const auto [u, v] : PixelsOf(320, 240)) {
    // A depth step across the stripes constrains all directions except along the wall.
    if (v > 160) depth_m(u, v) = 1.6f;
    const double x_m = PlaceCamera().Ray(u, v).x() * depth_m(u, v) + shift_m;
    const double wave = std::sin(2 * M_PI * x_m / kPeriodM);
    const auto grey = static_cast<std::uint8_t>(128 + std::lround(80 * wave));
    color(u, v) = {grey, grey, grey};
  }
  return MakePlaceView(PreprocessDepth(depth_m, {PlaceCamera(), {}}, PreprocessOptions()), color,
                       PlaceViewOptions());
}

TEST(VerifyLoop, RejectsRepetitiveTexture) {
  const GlobalRegistrationResult verdict =
      VerifyLoop(StripedWall(0), StripedWall(0.5), kOptions, Rigid3d());
  EXPECT_FALSE(verdict.accepted()) << ToString(verdict.reason);
  EXPECT_THAT(ToString(verdict.reason), ::testing::AnyOf("ambiguous", "degenerate"));
}

TEST(VerifyLoop, IsTheSameAtAnyNumberOfThreads) {
  const RoomOfKeyframes& room = MakeRoomOfKeyframes(2);
  const PlaceView view = SeeNearby(room, 3, NearbyPose()).view;
  const auto verdicts =
      AtThreads({1, 2, 4}, [&] { return VerifyLoop(view, room.keyframes[3].view, kOptions); });
  ASSERT_TRUE(verdicts[0].accepted());
  for (const GlobalRegistrationResult& verdict : verdicts) {
    EXPECT_EQ(verdict.target_from_source.Matrix(), verdicts[0].target_from_source.Matrix());
    EXPECT_EQ(verdict.information, verdicts[0].information);
    EXPECT_EQ(verdict.agreeing_features, verdicts[0].agreeing_features);
  }
}

TEST(VerifyLoopOptions, RejectInvalidValues) {
  const auto expect_refused = ExpectOptionsRefused<VerifyLoopOptions>;
  Validate(VerifyLoopOptions());
  expect_refused([](auto& o) { o.fit.min_inlier_ratio = 2; }, "fit.min_inlier_ratio", "2");
  expect_refused([](auto& o) { o.fit.max_rmse_m = 0; }, "fit.max_rmse_m", "0");
  expect_refused([](auto& o) { o.fit.min_overlap_ratio = -1; }, "fit.min_overlap_ratio", "-1");
  expect_refused([](auto& o) { o.fit.max_sigma_m = 0; }, "fit.max_sigma_m", "0");
  expect_refused([](auto& o) { o.fit.max_disagreement_rad = 0; }, "fit.max_disagreement_rad", "0");
}

}  // namespace
}  // namespace surfit::testing
