// Tests whole runs in simulated rooms at sensor resolution, without and with wrong loops.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <random>

#include "slam/simulated_sequence.h"
#include "surfit/evaluation/trajectory_evaluation.h"

namespace surfit::testing {
namespace {

class RoomsSweep : public ::testing::TestWithParam<int> {};

// The bound is documented for these rooms. Both paths start at the same pose without alignment, so
// the error is at least the ATE.
TEST_P(RoomsSweep, TracksKinectWithin8MillimetresOver300Frames) {
  constexpr int kCount = 300;
  const PinholeCamera camera{640, 480, 525, 525, 319.5, 239.5, {}};
  const auto seed = static_cast<std::uint64_t>(GetParam());
  const Scene scene = MakeScene("room", seed);
  std::vector<Rigid3d> truth;
  SlamRun run;
  std::unique_ptr<Slam> slam;
  for (const StampedPose& pose : MakePath(scene, kCount, seed)) {
    const int index = static_cast<int>(truth.size());
    truth.push_back(pose.world_from_camera);
    RgbdFrame frame = RenderFrame(scene, camera, pose.world_from_camera, index, pose.stamp_s);
    frame.depth_m = KinectDepth(frame.depth_m, camera, (seed << 32) + index);
    if (!slam) slam = std::make_unique<Slam>(DepthSensor{camera, {}}, SlamOptions(), truth[0]);
    run.reports.push_back(slam->Process(frame));
    EXPECT_NE(run.reports.back().state, FrameState::kLost) << index;
  }
  const double rms_m = ErrorsOf(run, truth).rms_m;
  std::printf("room %d: %.2f mm\n", GetParam(), 1e3 * rms_m);
  EXPECT_LE(rms_m, 0.008);
}

INSTANTIATE_TEST_SUITE_P(Seeds, RoomsSweep, ::testing::Values(1, 2, 3, 4, 5));

// Five walks per seed through ordinary rooms, where floor and furniture constrain the pose weakly.
class WalksSweep : public ::testing::TestWithParam<int> {};

// Positions are compared without alignment, so errors include the drift of a walk.
TEST_P(WalksSweep, AreTrackedWithin20Millimetres) {
  constexpr int kFrames = 600, kWalk = 220, kStep = 95;
  const PinholeCamera camera = {320, 240, 262.5, 262.5, 159.5, 119.5, {}};
  const auto whole = Simulate("three_rooms", static_cast<std::uint64_t>(GetParam()), kFrames,
                              Sensor::kKinect, camera);
  int lost = 0;
  for (int first = 0; first + kWalk <= kFrames; first += kStep) {
    SimulatedSequence walk;
    walk.camera = camera;
    walk.frames.assign(whole.frames.begin() + first, whole.frames.begin() + first + kWalk);
    walk.world_from_camera.assign(whole.world_from_camera.begin() + first,
                                  whole.world_from_camera.begin() + first + kWalk);
    const SlamRun run = RunSlam(walk, SlamOptions(), walk.world_from_camera[0]);
    double square_sum = 0, worst_m = 0;
    int tracked = 0;
    for (int i = 0; i < kWalk; ++i) {
      if (run.reports[i].state == FrameState::kLost) continue;
      const double error_m =
          (walk.world_from_camera[i].Inverse() * run.reports[i].world_from_camera)
              .translation.norm();
      square_sum += error_m * error_m;
      worst_m = std::max(worst_m, error_m);
      ++tracked;
    }
    ASSERT_GT(tracked, 0);
    lost += kWalk - tracked;
    const double rms_m = std::sqrt(square_sum / tracked);
    std::printf("walk %d from frame %d: %.2f mm, worst %.2f mm, %d lost\n", GetParam(), first,
                1e3 * rms_m, 1e3 * worst_m, kWalk - tracked);
    EXPECT_LT(rms_m, 0.02) << "from frame " << first;
    EXPECT_LT(worst_m, 0.05) << "from frame " << first;
  }
  EXPECT_LE(lost, 2);
}

// Seeds 1 to 48 chose the rules of tracking.
INSTANTIATE_TEST_SUITE_P(Seeds, WalksSweep, ::testing::Range(101, 141));

// Half of the resolution of a Kinect. At lower resolutions, the differences due to rounding are as
// large as the effect of some wrong loops.
const PinholeCamera kCamera = {320, 240, 262.5, 262.5, 159.5, 119.5, {}};
constexpr int kLength = 1500;
constexpr int kRightPerWrong = 9;  // 10 % of all loops are wrong

enum class Wrong {
  kNone,      // no wrong loops
  kAnywhere,  // to any earlier keyframe, with any pose in a room
  kNear,      // at the pose of odometry, with an error of 0.3 m and 10 degrees
};

double Uniform(std::mt19937_64* rng) { return 2 * std::ldexp((*rng)() >> 11, -53) - 1; }

Rigid3d RandomMotion(double way_m, double turn_rad, std::mt19937_64* rng) {
  const Eigen::Vector3d axis =
      Eigen::Vector3d(Uniform(rng), Uniform(rng), Uniform(rng)).normalized();
  const Eigen::Vector3d way(Uniform(rng), Uniform(rng), Uniform(rng));
  return {Eigen::Quaterniond(Eigen::AngleAxisd(turn_rad, axis)), way_m * way.normalized()};
}

LoopVerification WrongLoop(Wrong wrong, int source, const std::vector<Keyframe>& keyframes,
                           const GlobalRegistrationResult& as_sure_as, std::mt19937_64* rng) {
  LoopVerification attempt;
  attempt.proposal.source = source;
  attempt.proposal.target = static_cast<int>((*rng)() % static_cast<std::uint64_t>(source));
  attempt.verdict = as_sure_as;
  attempt.verdict.target_from_source =
      wrong == Wrong::kAnywhere
          ? RandomMotion(3 * std::abs(Uniform(rng)), M_PI * Uniform(rng), rng)
          : keyframes[attempt.proposal.target].world_from_camera.Inverse() *
                keyframes[source].world_from_camera * RandomMotion(0.3, M_PI / 18, rng);
  return attempt;
}

// Loop finder of the library that adds wrong loops with the covariance of correct loops.
LoopFinder Misled(Wrong wrong, const FindLoopsOptions& options, int* planted) {
  return [=, rng = std::mt19937_64(5), right = 0](
             int source, const std::vector<Keyframe>& keyframes, const PlaceIndex& index) mutable {
    std::vector<LoopVerification> attempts = FindLoops(source, keyframes, index, options);
    if (wrong == Wrong::kNone) return attempts;
    for (std::size_t i = 0, found = attempts.size(); i < found; ++i) {
      if (!attempts[i].verdict.accepted() || ++right % kRightPerWrong != 0) continue;
      attempts.push_back(WrongLoop(wrong, source, keyframes, attempts[i].verdict, &rng));
      ++*planted;
    }
    return attempts;
  };
}

struct Outcome {
  double ate_m = 0;
  BackendCounts counts;
  int planted = 0;
};

Outcome RunMisled(const SimulatedSequence& sequence, Wrong wrong) {
  SlamOptions options;
  options.loops.enabled = true;
  Slam slam({sequence.camera, {}}, options, sequence.world_from_camera[0]);
  Outcome outcome;
  slam.UseLoopFinder(Misled(wrong, options.loops.find, &outcome.planted));
  for (const RgbdFrame& frame : sequence.frames) slam.Process(frame);
  slam.Finish();
  std::vector<MatchedPose> poses;
  for (const PosedFrame& frame : slam.backend()->poses().frames()) {
    poses.push_back(
        {frame.stamp_s, sequence.world_from_camera[frame.index], frame.world_from_camera});
  }
  outcome.ate_m = ComputeAbsoluteTrajectoryError(poses).value().translation_m.rmse;
  outcome.counts = slam.backend()->counts();
  std::printf("%d wrong loops: %zu of %zu accepted, ATE %.2f mm\n", outcome.planted,
              outcome.counts.loops_accepted, outcome.counts.loop_candidates, 1e3 * outcome.ate_m);
  return outcome;
}

TEST(WrongLoopsSweep, TenPercentHardlyChangeTrajectory) {
  const auto sequence = Simulate("three_rooms", 4, kLength, Sensor::kKinect, kCamera);
  const Outcome clean = RunMisled(sequence, Wrong::kNone);
  ASSERT_EQ(clean.planted, 0);
  for (const Wrong wrong : {Wrong::kAnywhere, Wrong::kNear}) {
    const Outcome misled = RunMisled(sequence, wrong);
    // The number of loops can differ slightly from the clean run.
    EXPECT_GE(kRightPerWrong * misled.planted,
              0.8 * static_cast<double>(clean.counts.loops_accepted));
    EXPECT_LE(misled.ate_m, 1.1 * clean.ate_m);
  }
}

}  // namespace
}  // namespace surfit::testing
