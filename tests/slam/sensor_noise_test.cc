// All stages use the configured sensor noise, here an unusual value.

#include <gmock/gmock.h>

#include <vector>

#include "mapping/plane_frame.h"
#include "places/simulated_places.h"
#include "registration/simulated_views.h"
#include "slam/simulated_sequence.h"
#include "surfit/loop_closure/find_loops.h"
#include "surfit/optimization/refine.h"
#include "surfit/slam/slam.h"
#include "testing/matchers.h"

namespace surfit::testing {
namespace {

constexpr double kOdd = 0.0031;  // 1/m

void AddNoises(const FramePyramid& pyramid, std::vector<double>* noises) {
  for (const FrameLevel& level : pyramid.levels) {
    noises->push_back(level.noise.inverse_depth_sigma);
  }
}

void SetNoise(double inverse_depth_sigma, FramePyramid* pyramid) {
  for (FrameLevel& level : pyramid->levels) level.noise.inverse_depth_sigma = inverse_depth_sigma;
}

// The target of a lost frame is a rendered model view.
TEST(SensorNoise, IsSetInFramesAndModelViews) {
  const SimulatedSequence& room = IdealRoom();
  Slam slam({room.camera, {kOdd}}, SlamOptions(), room.world_from_camera[0]);
  std::vector<double> noises;
  slam.OnLostFrame([&](const LostFrame& lost) {
    AddNoises(lost.source, &noises);
    AddNoises(lost.target, &noises);
  });
  for (int i = 0; i < 3; ++i) slam.Process(room.frames[i]);
  slam.Process(Blank(3));
  EXPECT_THAT(noises, Not(IsEmpty()));
  EXPECT_THAT(noises, Each(kOdd));
}

TEST(SensorNoise, IsSetInKeyframes) {
  const SimulatedSequence& room = IdealRoom();
  SlamOptions options;
  options.loops.enabled = true;
  options.loops.keyframes.max_distance_m = 0.02;
  Slam slam({room.camera, {kOdd}}, options, room.world_from_camera[0]);
  std::vector<double> noises;
  slam.UseLoopFinder([&](int, const std::vector<Keyframe>& keyframes, const PlaceIndex&) {
    for (const Keyframe& keyframe : keyframes) {
      noises.push_back(keyframe.view.noise.inverse_depth_sigma);
      AddNoises(PyramidOf(keyframe.view, {}), &noises);
    }
    return std::vector<LoopVerification>();
  });
  for (const RgbdFrame& frame : room.frames) slam.Process(frame);
  slam.Finish();
  EXPECT_THAT(noises, Not(IsEmpty()));
  EXPECT_THAT(noises, Each(kOdd));
}

// Without a noise floor, twice the noise is a quarter of the information.
TEST(SensorNoise, DeterminesWeightsOfRegistration) {
  const SimulatedViews views = MakeViews(0, 3);
  IcpOptions options;
  options.error_model.floor_sigma_m = 1e-6;
  options.error_model.kernel.type = RobustKernelType::kNone;
  const auto information = [&](double sigma) {
    FramePyramid source = views.source;
    SetNoise(sigma, &source);
    return Register(source, views.target, views.target_from_source, options).information;
  };
  const Matrix6d one = information(kOdd), half = information(2 * kOdd);
  EXPECT_LT((one - 4 * half).norm(), 1e-3 * one.norm());
}

// At 2 m, free space ends 50 mm + 4 sigma in front of the measurement: 82 mm with the default
// noise, and 210 mm with a sigma of 40 mm.
TEST(SensorNoise, IncreasesFreeSpaceMarginOfFusion) {
  const PinholeCamera camera = SimulatedCamera();
  const auto removed = [&](double sigma) {
    SurfelMap map;
    Fusion fusion((FusionOptions()));
    FrameWithSurface seen = WallFrame(camera, {}, 1.9, 0);
    fusion.Fuse(seen.frame, seen.surface, {}, &map);
    seen = WallFrame(camera, {}, 2, 1);
    seen.surface.noise.inverse_depth_sigma = sigma;
    return fusion.Fuse(seen.frame, seen.surface, {}, &map).removed;
  };
  EXPECT_GT(removed(0.002), 1000);
  EXPECT_EQ(removed(0.01), 0);
}

// At 2 m, sigma is 4 mm with the noise floor only, and ten times larger with the largest noise.
TEST(SensorNoise, DeterminesWeightsOfGlobalRegistration) {
  const SimulatedColoredViews views = MakeColoredViews(70, 50, 12);
  const auto information = [&](double sigma) {
    ColoredView source = views.source, target = views.target;
    SetNoise(sigma, &source.pyramid);
    SetNoise(sigma, &target.pyramid);
    InitializeOptions options;
    options.method = "features";
    const IcpResult icp = RegisterGlobally(source, target, options, GlobalIcpOptions()).icp;
    EXPECT_TRUE(icp.Succeeded());
    return icp.information.trace();
  };
  EXPECT_LT(information(0.01), 0.1 * information(0.0001));
}

TEST(SensorNoise, IncreasesInlierRatioOfRelocalisation) {
  const RoomOfKeyframes& room = MakeRoomOfKeyframes(1);
  const auto inliers = [&](double sigma) {
    std::vector<Keyframe> keyframes = {room.keyframes[0]};
    PlaceView view = room.keyframes[1].view;
    keyframes[0].view.noise.inverse_depth_sigma = view.noise.inverse_depth_sigma = sigma;
    PlaceIndex index;
    index.Add(0, keyframes[0].view);
    const Relocalization found = Relocalize(view, keyframes, index, {});
    return found.attempts.empty() ? -1 : found.attempts.back().verdict.inlier_ratio;
  };
  const double exact = inliers(0.0005), noisy = inliers(0.01);
  EXPECT_GT(exact, 0);
  EXPECT_GT(noisy, exact);
}

// Without noise floor and kernel, doubling the noise halves the residuals in sigmas.
TEST(SensorNoise, ScalesResidualsOfRefinement) {
  const SimulatedSequence room = SimulateRoom(7, 24, Sensor::kKinect);
  RefinementOptions options;
  options.error_model.floor_sigma_m = 1e-6;
  options.error_model.kernel.type = RobustKernelType::kNone;
  options.max_rounds = 1;
  const auto sigmas = [&](double sigma) {
    std::vector<RefinementKeyframe> keyframes;
    for (std::size_t i = 0; i < room.frames.size(); i += 6) {
      keyframes.push_back({room.world_from_camera[i],
                           MakeKeyframeImages(room.frames[i], {room.camera, {kOdd}}, {}, {})});
      EXPECT_EQ(keyframes.back().images.noise.inverse_depth_sigma, kOdd);
      keyframes.back().images.noise.inverse_depth_sigma = sigma;
    }
    return Refine(options, {room.camera, {}}, &keyframes, [](const RefinementRound&) {})
        .before.rms_sigmas;
  };
  const double one = sigmas(kOdd), twice = sigmas(2 * kOdd);
  EXPECT_GT(one, 0);
  EXPECT_NEAR(one / twice, 2, 1e-3);
}

}  // namespace
}  // namespace surfit::testing
