#include "tracking/motion/prior_poses.h"

#include <ceres/ceres.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "cost_functions/pose.h"
#include "cost_functions/pose_manifold.h"
#include "cost_functions/pose_prior.h"
#include "slam/simulated_sequence.h"
#include "surfit/core/error.h"
#include "testing/matchers.h"
#include "tracking/motion/motion_prior.h"

namespace surfit::testing {
namespace {

constexpr double kPriorFrame_s = 1. / 30;
constexpr int kPriorFrames = 300;

// True camera poses: a walk with turns about all axes.
Rigid3d CameraOfWalk(int frame) {
  const double s = frame * kPriorFrame_s;
  const Eigen::Vector3d turn(0.3 * std::sin(0.9 * s), 0.5 * std::sin(0.7 * s),
                             0.2 * std::sin(1.3 * s));
  return {QuaternionExp<double>(turn),
          Eigen::Vector3d(0.4 * s, 0.1 * std::sin(2 * s), 0.2 * std::cos(s))};
}

Vector6d PoseNoise(double sigma_rad, double sigma_m, std::mt19937_64* rng) {
  std::normal_distribution<double> normal;
  Vector6d v;
  for (int i = 0; i < 6; ++i) v[i] = (i < 3 ? sigma_rad : sigma_m) * normal(*rng);
  return v;
}

// Adds the motions of a camera with registration noise of 0.5 mm and 0.5 mrad.
PriorPoses Compared(const Trajectory& prior, std::uint64_t seed) {
  // Another sequence than that of DriftingPrior(): the errors of both sources are independent.
  std::mt19937_64 rng(seed + 1000);
  PriorPoses poses(prior);
  Rigid3d last;
  for (int i = 0; i < kPriorFrames; ++i) {
    const Rigid3d registered =
        CameraOfWalk(i) * LeftIncrement<double>(PoseNoise(5e-4, 5e-4, &rng), {});
    if (i > 0) {
      poses.Add({(i - 1) * kPriorFrame_s, i * kPriorFrame_s, last.Inverse() * registered,
                 Matrix6d::Identity() * 1e8});
    }
    last = registered;
  }
  return poses;
}

// Prior of a body, with random-walk drift per frame.
Trajectory DriftingPrior(const Rigid3d& body_from_camera, double sigma_rad, double sigma_m,
                         std::uint64_t seed) {
  std::mt19937_64 rng(seed);
  Trajectory prior;
  Rigid3d drift;
  for (int i = 0; i < kPriorFrames; ++i) {
    drift = drift * LeftIncrement<double>(PoseNoise(sigma_rad, sigma_m, &rng), {});
    prior.push_back({i * kPriorFrame_s, CameraOfWalk(i) * drift * body_from_camera.Inverse()});
  }
  return prior;
}

TEST(PriorPoses, EstimatesOffsetOfRobotBody) {
  Eigen::Matrix3d axes;  // body: x forward, z up; camera: z forward, y down
  axes << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  const Rigid3d body_from_camera(axes, Eigen::Vector3d(0.2, -0.1, 0.3));
  for (const std::uint64_t seed : {1, 2, 3}) {
    const PriorPoses poses = Compared(DriftingPrior(body_from_camera, 1e-4, 2e-4, seed), seed);
    EXPECT_THAT(poses.body_from_camera(), RigidNear(body_from_camera, 0.02, 0.01)) << seed;
    EXPECT_EQ(poses.Summary().frames_rejected, 0) << seed;
    EXPECT_TRUE(poses.Trusted(298 * kPriorFrame_s, 299 * kPriorFrame_s)) << seed;
  }
}

TEST(PriorPoses, EstimatesDrift) {
  constexpr int kSeeds = 20;
  double mean_m = 0, mean_rad = 0;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const PriorPoseSummary summary = Compared(DriftingPrior({}, 1e-3, 2e-3, seed), seed).Summary();
    const double frames_per_s = 1 / kPriorFrame_s;
    const double ratio_m = summary.sigma_m / (2e-3 * std::sqrt(frames_per_s));
    const double ratio_rad = summary.sigma_rad / (1e-3 * std::sqrt(frames_per_s));
    EXPECT_GT(ratio_m, 0.5) << seed;
    EXPECT_LT(ratio_m, 1.5) << seed;
    EXPECT_GT(ratio_rad, 0.5) << seed;
    EXPECT_LT(ratio_rad, 1.5) << seed;
    EXPECT_EQ(summary.frames_rejected, 0) << seed;
    mean_m += ratio_m / kSeeds;
    mean_rad += ratio_rad / kSeeds;
  }
  // The estimate has no bias, except the bounds of single estimates.
  EXPECT_NEAR(mean_m, 1, 0.15);
  EXPECT_NEAR(mean_rad, 1, 0.15);
}

TEST(PriorPoses, RejectsOnlyTheMotionOfAJump) {
  Trajectory prior = DriftingPrior({}, 1e-4, 2e-4, 4);
  for (int i = 150; i < kPriorFrames; ++i) prior[i].world_from_camera.translation.x() += 0.2;
  const PriorPoses poses = Compared(prior, 4);
  EXPECT_EQ(poses.Summary().rejected.size(), 1U);
  EXPECT_LE(poses.Summary().frames_rejected, 2);
  EXPECT_FALSE(poses.Accepted(140 * kPriorFrame_s, 160 * kPriorFrame_s));
  EXPECT_TRUE(poses.Accepted(120 * kPriorFrame_s, 140 * kPriorFrame_s));
  EXPECT_TRUE(poses.Accepted(160 * kPriorFrame_s, 180 * kPriorFrame_s));
}

TEST(PriorPoses, RejectsSlowDriftOfSecondHalf) {
  Trajectory prior = DriftingPrior({}, 1e-4, 2e-4, 5);
  for (int i = 150; i < kPriorFrames; ++i) {
    prior[i].world_from_camera.translation.x() += 0.2 * (i - 150) / 150;
  }
  const PriorPoses poses = Compared(prior, 5);
  EXPECT_GT(poses.Summary().frames_rejected, 130);
  EXPECT_FALSE(poses.Trusted(298 * kPriorFrame_s, 299 * kPriorFrame_s));
  EXPECT_TRUE(poses.Accepted(100 * kPriorFrame_s, 120 * kPriorFrame_s));
}

TEST(PriorPoses, HasNoMotionWithoutPriorPosesAtItsTimes) {
  Trajectory prior = DriftingPrior({}, 1e-4, 2e-4, 6);
  prior.resize(100);
  const PriorPoses poses = Compared(prior, 6);
  EXPECT_EQ(poses.Summary().frames_compared, 99);
  EXPECT_EQ(poses.Summary().frames_without, 200);
  EXPECT_FALSE(poses.Trusted(150 * kPriorFrame_s, 151 * kPriorFrame_s));
  EXPECT_FALSE(poses.Accepted(90 * kPriorFrame_s, 110 * kPriorFrame_s));
}

// Both forms of the solver: the update in closed form, and Ceres with the functor of the prior.
TEST(PriorPoses, CeresGivesTheSamePoseAsTheClosedForm) {
  std::mt19937_64 rng(7);
  for (int i = 0; i < 20; ++i) {
    const Rigid3d expected = CameraOfWalk(i);
    const Rigid3d registered = LeftIncrement<double>(PoseNoise(1e-2, 1e-2, &rng), expected);
    const Matrix6d covariance = Variances(1e-3, 2e-3);
    Matrix6d rows;
    for (int k = 0; k < 6; ++k) rows.row(k) = PoseNoise(1e3, 1e3, &rng);
    const Matrix6d information = rows.transpose() * rows;
    const ExpectedPose likely = MostLikely({expected, covariance}, registered, information, 1e9);
    double block[kPoseSize];
    PoseToBlock(expected, block);
    LeftPoseManifold manifold;
    ceres::Problem::Options options;
    options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    ceres::Problem problem(options);
    problem.AddParameterBlock(block, kPoseSize, &manifold);
    for (const PosePrior& prior :
         {PosePrior(expected, covariance.inverse()), PosePrior(registered, information)}) {
      problem.AddResidualBlock(
          new ceres::AutoDiffCostFunction<PosePrior, 6, kPoseSize>(new PosePrior(prior)), nullptr,
          block);
    }
    ceres::Solver::Options solver;
    solver.function_tolerance = solver.gradient_tolerance = solver.parameter_tolerance = 1e-15;
    ceres::Solver::Summary summary;
    ceres::Solve(solver, &problem, &summary);
    EXPECT_THAT(PoseFromBlock(block), RigidNear(likely.target_from_source, 1e-6, 1e-6)) << i;
  }
}

// Room with a Kinect. After frame 59, depth shows only the floor. The floor does not constrain
// motion along itself.
SimulatedSequence RoomThenFloor(int frames) {
  SimulatedSequence room = SimulateRoom(2, frames, Sensor::kKinect);
  for (int i = 60; i < frames; ++i) {
    Image<float>& depth_m = room.frames[i].depth_m;
    for (int v = 0; v < depth_m.height(); ++v) {
      for (int u = 0; u < depth_m.width(); ++u) {
        const Eigen::Vector3d point = depth_m(u, v) * room.camera.Ray(u, v);
        if ((room.world_from_camera[i] * point).z() > 0.05) depth_m(u, v) = 0;
      }
    }
  }
  return room;
}

// Runs with the true poses, times a drift per frame. The second half of the prior jumps by
// `jump_m`. Returns the largest error of a pose during the run, m.
double LargestErrorWithPrior(const SimulatedSequence& sequence, double sigma_rad, double sigma_m,
                             double jump_m) {
  std::mt19937_64 rng(3);
  Trajectory prior;
  Rigid3d drift;
  for (std::size_t i = 0; i < sequence.frames.size(); ++i) {
    drift = drift * LeftIncrement<double>(PoseNoise(sigma_rad, sigma_m, &rng), {});
    Rigid3d pose = sequence.world_from_camera[i] * drift;
    if (2 * i >= sequence.frames.size()) pose.translation.y() += jump_m;
    prior.push_back({sequence.frames[i].stamp_s, pose});
  }
  Slam slam({sequence.camera, {}}, SlamOptions(), sequence.world_from_camera.front());
  slam.UsePriorPoses(prior);
  SlamRun run;
  for (const RgbdFrame& frame : sequence.frames) run.reports.push_back(slam.Process(frame));
  EXPECT_GT(slam.prior_poses()->frames_used, 20);
  return ErrorsOf(run, sequence.world_from_camera).max_m;
}

double LargestErrorWithoutPrior(const SimulatedSequence& sequence) {
  const SlamRun run = RunSlam(sequence, SlamOptions(), sequence.world_from_camera.front());
  return ErrorsOf(run, sequence.world_from_camera).max_m;
}

TEST(SlamPriorPoses, HoldThePoseWhereDepthDoesNot) {
  const SimulatedSequence room = RoomThenFloor(80);
  const double error_m = LargestErrorWithPrior(room, 1e-4, 2e-4, 0);
  EXPECT_LT(error_m, 0.01);
  EXPECT_LT(error_m, 0.5 * LargestErrorWithoutPrior(room));
}

TEST(SlamPriorPoses, JumpAndDriftDoNotMoveConstrainedFrames) {
  const SimulatedSequence room = SimulateRoom(2, 120, Sensor::kKinect);
  const double without_m = LargestErrorWithoutPrior(room);
  EXPECT_LT(LargestErrorWithPrior(room, 1e-4, 2e-4, 0.2), 1.1 * without_m);
  EXPECT_LT(LargestErrorWithPrior(room, 1e-3, 2e-3, 0), 1.1 * without_m);
}

TEST(SlamPriorPoses, RejectsFewerThanTwoPoses) {
  Slam slam({SimulatedCamera(), {}}, SlamOptions(), {});
  EXPECT_THROW(slam.UsePriorPoses({{0, Rigid3d()}}), InputError);
}

}  // namespace
}  // namespace surfit::testing
