// Slam with prior poses, on rendered frames.
#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <optional>
#include <random>
#include <vector>

#include "slam/simulated_sequence.h"
#include "surfit/core/parallel.h"
#include "surfit/slam/slam.h"
#include "testing/matchers.h"

namespace surfit::testing {
namespace {

constexpr int kRoomFrames = 120;

struct PriorRoom {
  explicit PriorRoom(std::uint64_t room_seed)
      : seed(room_seed), sequence(SimulateRoom(room_seed, kRoomFrames, Sensor::kKinect)) {}

  // True poses in another world, of a body with another orientation, with random-walk drift.
  Trajectory Prior(double sigma_rad, double sigma_m) const {
    const Rigid3d world(QuaternionExp<double>({0.4, 1, -2}), {3, -4, 5});
    const Rigid3d body_from_camera(QuaternionExp<double>({-1.2, 1.2, -1.2}), {0.05, 0.02, -0.03});
    std::mt19937_64 rng(seed);
    std::normal_distribution<double> normal;
    Rigid3d drift;
    Trajectory prior;
    for (int i = 0; i < kRoomFrames; ++i) {
      Vector6d step;
      for (int k = 0; k < 6; ++k) step[k] = (k < 3 ? sigma_rad : sigma_m) * normal(rng);
      drift = drift * LeftIncrement<double>(step, Rigid3d());
      prior.push_back({sequence.frames[i].stamp_s,
                       world * sequence.world_from_camera[i] * drift * body_from_camera.Inverse()});
    }
    return prior;
  }

  std::uint64_t seed;
  SimulatedSequence sequence;
};

struct PriorRun {
  std::vector<FrameReport> reports;
  Trajectory poses;  // after the run
  std::optional<PriorPoseSummary> summary;
};

PriorRun RunWithPrior(const SimulatedSequence& sequence, const Trajectory& prior) {
  Slam slam({sequence.camera, {}}, SlamOptions(), sequence.world_from_camera[0]);
  if (!prior.empty()) slam.UsePriorPoses(prior);
  PriorRun run;
  for (const RgbdFrame& frame : sequence.frames) {
    run.reports.push_back(slam.Process(frame));
    if (!run.reports.back().HasPose()) continue;
    run.poses.push_back({frame.stamp_s, run.reports.back().world_from_camera});
  }
  slam.Finish();
  if (slam.backend()) run.poses = slam.backend()->poses().trajectory();
  run.summary = slam.prior_poses();
  return run;
}

// Mean squared position error after alignment of all positions, m^2.
double SquaredError(const SimulatedSequence& sequence, const Trajectory& poses) {
  Eigen::Matrix3Xd estimate(3, poses.size()), truth(3, poses.size());
  std::size_t frame = 0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    while (sequence.frames[frame].stamp_s != poses[i].stamp_s) ++frame;
    estimate.col(i) = poses[i].world_from_camera.translation;
    truth.col(i) = sequence.world_from_camera[frame].translation;
  }
  const Eigen::Matrix4d aligned = Eigen::umeyama(estimate, truth, false);
  return ((aligned.topLeftCorner<3, 3>() * estimate).colwise() +
          Eigen::Vector3d(aligned.topRightCorner<3, 1>()) - truth)
      .colwise()
      .squaredNorm()
      .mean();
}

TEST(SlamWithPrior, IsBetterThanEitherSource) {
  double of_both = 0, of_slam = 0, of_prior = 0;
  for (const std::uint64_t seed : {1, 2, 3, 4}) {
    const PriorRoom room(seed);
    const Trajectory prior = room.Prior(3e-4, 4e-4);
    const PriorRun run = RunWithPrior(room.sequence, prior);
    EXPECT_EQ(run.summary->frames_rejected, 0) << seed;
    EXPECT_GT(run.summary->frames_used, 60) << seed;
    of_both += SquaredError(room.sequence, run.poses);
    of_slam += SquaredError(room.sequence, RunWithPrior(room.sequence, {}).poses);
    Trajectory of_camera = prior;
    for (StampedPose& pose : of_camera) {
      pose.world_from_camera = pose.world_from_camera * run.summary->body_from_camera;
    }
    of_prior += SquaredError(room.sequence, of_camera);
  }
  EXPECT_LT(of_both, of_slam);
  EXPECT_LT(of_both, of_prior);
}

TEST(SlamWithPrior, RejectsAJumpAndKeepsTheAccuracy) {
  double with_jump = 0, of_slam = 0;
  for (const std::uint64_t seed : {1, 2, 3}) {
    const PriorRoom room(seed);
    Trajectory prior = room.Prior(3e-4, 4e-4);
    for (int i = kRoomFrames / 2; i < kRoomFrames; ++i) {
      prior[i].world_from_camera.translation.x() += 0.2;
    }
    const PriorRun run = RunWithPrior(room.sequence, prior);
    ASSERT_EQ(run.summary->rejected.size(), 1U) << seed;
    EXPECT_LE(run.summary->frames_rejected, 2) << seed;
    EXPECT_EQ(run.summary->rejected[0].first, prior[kRoomFrames / 2].stamp_s) << seed;
    EXPECT_EQ(run.poses.size(), room.sequence.frames.size()) << seed;
    with_jump += SquaredError(room.sequence, run.poses);
    of_slam += SquaredError(room.sequence, RunWithPrior(room.sequence, {}).poses);
  }
  EXPECT_LT(with_jump, of_slam);
}

TEST(SlamWithPrior, RejectsASlowErrorAndKeepsTheAccuracy) {
  double with_error = 0, of_slam = 0;
  for (const std::uint64_t seed : {1, 2, 3}) {
    const PriorRoom room(seed);
    Trajectory prior = room.Prior(3e-4, 4e-4);
    for (int i = kRoomFrames / 2; i < kRoomFrames; ++i) {
      prior[i].world_from_camera.translation.x() += 0.4 * (2. * i / kRoomFrames - 1);
    }
    const PriorRun run = RunWithPrior(room.sequence, prior);
    EXPECT_GT(run.summary->frames_rejected, kRoomFrames / 4) << seed;
    with_error += SquaredError(room.sequence, run.poses);
    of_slam += SquaredError(room.sequence, RunWithPrior(room.sequence, {}).poses);
  }
  EXPECT_LT(with_error, 1.1 * of_slam);
}

// The motion model does not follow the camera through the gap, so only the prior has the pose.
TEST(SlamWithPrior, HoldsThePoseThroughFramesWithoutDepth) {
  constexpr int kGapBegin = 70, kGapEnd = 95;
  PriorRoom room(4);
  const Trajectory prior = room.Prior(1e-4, 2e-4);
  for (int i = kGapBegin; i < kGapEnd; ++i) {
    // One pixel differs, so that blind frames are no duplicates.
    Image<float>& depth_m = room.sequence.frames[i].depth_m;
    depth_m = Image<float>(depth_m.width(), depth_m.height());
    depth_m(i, 0) = 1;
  }
  const PriorRun run = RunWithPrior(room.sequence, prior);
  for (int i = kGapBegin; i < kGapEnd; ++i) EXPECT_FALSE(run.reports[i].HasPose()) << i;
  for (int i = kGapEnd; i < kRoomFrames; ++i) {
    ASSERT_TRUE(run.reports[i].HasPose()) << i;
    EXPECT_FALSE(run.reports[i].found_by_search) << i;
    EXPECT_THAT(run.reports[i].world_from_camera,
                RigidNear(room.sequence.world_from_camera[i], 0.03, 0.02))
        << i;
  }
}

TEST(SlamWithPrior, ResultIsTheSameForOneAndTwoThreads) {
  const PriorRoom room(1);
  const Trajectory prior = room.Prior(3e-4, 4e-4);
  Trajectory poses[2];
  for (const int threads : {1, 2}) {
    const ThreadLimit limit(threads);
    poses[threads - 1] = RunWithPrior(room.sequence, prior).poses;
  }
  ASSERT_EQ(poses[0].size(), poses[1].size());
  for (std::size_t i = 0; i < poses[0].size(); ++i) {
    EXPECT_EQ(poses[0][i].world_from_camera, poses[1][i].world_from_camera) << i;
  }
}

}  // namespace
}  // namespace surfit::testing
