#include "surfit/slam/backend.h"

#include <gmock/gmock.h>

#include <Eigen/LU>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <future>
#include <thread>

#include "loop_closure/edge_information.h"
#include "slam/simulated_sequence.h"
#include "surfit/slam/slam.h"
#include "testing/matchers.h"
#include "testing/pixels.h"
#include "testing/threads.h"

namespace surfit::testing {
namespace {

constexpr int kFrames = 200;
constexpr double kTurnError = 0.002;  // odometry error, rad per frame

// Camera that moves once around a circle and returns to its first pose.
Rigid3d TruePose(int frame) {
  const double angle = 2 * M_PI * frame / (kFrames - 1);
  return {Eigen::Quaterniond(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitY())),
          {2 * std::sin(angle), 0, 2 * std::cos(angle) - 2}};
}

// Path of odometry, with a constant rotation error per frame.
std::vector<Rigid3d> DriftingPoses() {
  std::vector<Rigid3d> poses = {TruePose(0)};
  const Rigid3d error(Eigen::Quaterniond(Eigen::AngleAxisd(kTurnError, Eigen::Vector3d::UnitY())),
                      {0, 0, 0});
  for (int i = 1; i < kFrames; ++i) {
    poses.push_back(poses.back() * (TruePose(i - 1).Inverse() * TruePose(i)) * error);
  }
  return poses;
}

FramePyramid FlatPyramid() {
  const PinholeCamera camera = {32, 24, 30, 30, 15.5, 11.5, {}};
  FrameLevel level = {camera, {}, VectorImage(32, 24), VectorImage(32, 24), {}};
  for (const auto [u, v] : PixelsOf(32, 24)) {
    level.vertex.Set(u, v, (2 * camera.Ray(u, v)).cast<float>());
    level.normal.Set(u, v, {0, 0, -1});
  }
  FramePyramid pyramid;
  pyramid.levels.push_back(level);
  return pyramid;
}

IcpResult GoodIcp() {
  IcpResult icp;
  icp.termination = Termination::kConverged;
  icp.information = 1e8 * Matrix6d::Identity();
  icp.covariance = 1e-8 * Matrix6d::Identity();
  return icp;
}

LoopVerification Loop(int source, int target, const Rigid3d& target_from_source) {
  LoopVerification attempt;
  attempt.proposal.source = source;
  attempt.proposal.target = target;
  attempt.verdict.reason = GlobalRegistrationReason::kAccepted;
  attempt.verdict.target_from_source = target_from_source;
  attempt.verdict.information = 1e8 * Matrix6d::Identity();
  return attempt;
}

// Finds true loops from the last frames of the path to the first keyframe.
std::vector<LoopVerification> TrueLoops(int source, const std::vector<Keyframe>& keyframes,
                                        const PlaceIndex&) {
  const int frame = keyframes[source].frame_index;
  if (frame < kFrames - 20) return {};
  std::vector<LoopVerification> loops;  // GCC 12 warns of an initializer list
  loops.push_back(Loop(source, 0, TruePose(0).Inverse() * TruePose(frame)));
  return loops;
}

LoopOptions Enabled() {
  LoopOptions options;
  options.enabled = true;
  options.noise.odometry_rad = 0.01;  // odometry error between two keyframes
  options.noise.odometry_m = 0.01;
  return options;
}

CalibrationOptions NoCalibration() {
  CalibrationOptions options;
  options.enabled = false;
  return options;
}

RgbdFrame Stamped(int index, double stamp_s) {
  RgbdFrame frame;
  frame.index = index;
  frame.stamp_s = stamp_s;
  return frame;
}

struct BackendRun {
  std::vector<PosedFrame> frames;
  BackendCounts counts;
  std::vector<int> corrected_at;  // frames with a preceding world correction
};

// Runs the backend as Slam does: a correction moves all later poses.
BackendRun RunBackend(const LoopOptions& options, const LoopFinder& finder) {
  const std::vector<Rigid3d> odometry = DriftingPoses();
  Backend backend({}, {}, options, NoCalibration(), finder);
  BackendRun run;
  Rigid3d new_from_old;
  const FramePyramid pyramid = FlatPyramid();
  const auto take = [&](const std::vector<WorldCorrection>& corrections, int frame) {
    for (const WorldCorrection& correction : corrections) {
      if (!correction.moves) continue;
      new_from_old = correction.new_from_old_now * new_from_old;
      run.corrected_at.push_back(frame);
    }
  };
  for (int i = 0; i < kFrames; ++i) {
    take(backend.BeginFrame(), i);
    backend.AddFrame(Stamped(i, 0.03 * i), new_from_old * odometry[i], GoodIcp(), pyramid);
  }
  take(backend.Finish(), kFrames);
  run.frames = backend.poses().frames();
  run.counts = backend.counts();
  return run;
}

double RmsError(const std::vector<PosedFrame>& frames) {
  double sum = 0;
  for (const PosedFrame& frame : frames) {
    sum += (frame.world_from_camera.translation - TruePose(frame.index).translation).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(frames.size()));
}

TEST(Backend, ClosesLoop) {
  const LoopFinder none = [](int, const auto&, const auto&) {
    return std::vector<LoopVerification>();
  };
  const BackendRun open = RunBackend(Enabled(), none);
  const BackendRun closed = RunBackend(Enabled(), TrueLoops);
  ASSERT_EQ(open.frames.size(), static_cast<std::size_t>(kFrames));
  ASSERT_EQ(closed.frames.size(), static_cast<std::size_t>(kFrames));
  // A constant rotation error is evenly distributed over the loop, and the pose graph distributes
  // its correction evenly.
  EXPECT_LT(RmsError(closed.frames), 0.25 * RmsError(open.frames));
  EXPECT_THAT(closed.frames.back().world_from_camera, RigidNear(TruePose(kFrames - 1), 0.01, 0.01));
  EXPECT_EQ(open.counts.loop_candidates, 0u);
  EXPECT_EQ(open.counts.corrections, 0u);
  EXPECT_GT(closed.counts.loops_accepted, 0u);
  EXPECT_EQ(closed.counts.loops_rejected, 0u);
  EXPECT_EQ(closed.counts.submaps, 1u);
  EXPECT_EQ(closed.counts.disconnected_submaps, 0u);
}

// There are only two keyframes: the first frame, and one of the last 20 frames due to max_frames.
TEST(Backend, AppliesCorrectionAfterDelayFrames) {
  for (const int delay : {1, 3}) {
    LoopOptions options = Enabled();
    options.keyframes.max_distance_m = 5;   // more than the diameter of the circle
    options.keyframes.max_angle_rad = 3.2;  // more than half a turn
    options.keyframes.min_overlap_ratio = 0;
    options.keyframes.max_frames = kFrames - 20;
    options.delay_frames = delay;
    options.noise.odometry_rad = options.noise.odometry_m =
        1;  // odometry error of all frames between the keyframes
    const BackendRun run = RunBackend(options, TrueLoops);
    ASSERT_EQ(run.counts.keyframes, 2u);
    const auto trigger = std::find_if(run.frames.begin(), run.frames.end(),
                                      [](const PosedFrame& frame) { return frame.keyframe == 1; });
    ASSERT_LT(trigger->index + delay, kFrames);
    EXPECT_THAT(run.corrected_at, ElementsAre(trigger->index + delay));
  }
}

// The loop finder is slow. No frame waits, and the loop is applied after it is found.
TEST(Backend, InRealTimeAppliesLoopsWhenFound) {
  for (const int threads : {1, 2}) {
    const ThreadLimit limit(threads);
    std::promise<void> go_on;
    const std::shared_future<void> may_go_on = go_on.get_future().share();
    const LoopFinder slow = [&](int source, const std::vector<Keyframe>& keyframes,
                                const PlaceIndex& index) {
      may_go_on.wait();
      return TrueLoops(source, keyframes, index);
    };
    const std::vector<Rigid3d> odometry = DriftingPoses();
    Backend backend({}, {}, Enabled(), NoCalibration(), slow, /*real_time=*/true);
    const FramePyramid pyramid = FlatPyramid();
    for (int i = 0; i < kFrames; ++i) {
      EXPECT_TRUE(backend.BeginFrame().empty()) << i;
      backend.AddFrame(Stamped(i, 0.03 * i), odometry[i], GoodIcp(), pyramid);
    }
    go_on.set_value();
    const auto has_moved = [](const std::vector<WorldCorrection>& corrections) {
      return !corrections.empty() && corrections.back().moves;
    };
    bool moved = false;
    for (int i = 0; i < 1000 && !moved; ++i) {
      moved = has_moved(backend.BeginFrame());
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    EXPECT_TRUE(moved);
    EXPECT_EQ(backend.counts().waits, 0u);
    EXPECT_THAT(backend.poses().frames().back().world_from_camera,
                RigidNear(TruePose(kFrames - 1), 0.01, 0.01));
  }
}

TEST(Backend, RejectsWrongLoop) {
  const LoopFinder misled = [](int source, const std::vector<Keyframe>& keyframes,
                               const PlaceIndex& index) {
    std::vector<LoopVerification> attempts = TrueLoops(source, keyframes, index);
    const bool in_the_middle = std::abs(keyframes[source].frame_index - kFrames / 2) < 5;
    if (in_the_middle) attempts.push_back(Loop(source, 0, Rigid3d()));  // half a circle away
    return attempts;
  };
  const BackendRun clean = RunBackend(Enabled(), TrueLoops);
  const BackendRun run = RunBackend(Enabled(), misled);
  EXPECT_GT(run.counts.loops_rejected, 0u);
  EXPECT_EQ(run.counts.loops_accepted, clean.counts.loops_accepted);
  EXPECT_LT(RmsError(run.frames), 1.1 * RmsError(clean.frames));
}

TEST(Backend, ConnectsSubmapByLoop) {
  const auto finder = [](int source, const auto&, const auto&) {
    std::vector<LoopVerification> loops;
    if (source == 1) loops.push_back(Loop(1, 0, {Eigen::Quaterniond::Identity(), {0, 0, 0.5}}));
    return loops;
  };
  Backend backend({}, {}, Enabled(), NoCalibration(), finder);
  const FramePyramid pyramid = FlatPyramid();
  backend.AddFrame(Stamped(0, 0), TruePose(0), {}, pyramid);
  EXPECT_EQ(backend.BeginSubmap(), 1);
  backend.AddFrame(Stamped(50, 1.5), Rigid3d(), {}, pyramid);
  EXPECT_EQ(backend.counts().submaps, 2u);
  EXPECT_EQ(backend.counts().disconnected_submaps, 1u);
  const std::vector<WorldCorrection> corrections = backend.Finish();
  ASSERT_EQ(corrections.size(), 1u);
  EXPECT_TRUE(corrections[0].moves);
  EXPECT_EQ(backend.counts().disconnected_submaps, 0u);
  EXPECT_THAT(corrections[0].piece_of_submap, ElementsAre(0, 0));
  EXPECT_FALSE(backend.PlacePieces({{}, {}}));
  EXPECT_THAT(backend.poses().frames()[0].world_from_camera, RigidNear(TruePose(0), 1e-9, 1e-9));
  EXPECT_THAT(
      backend.poses().frames()[1].world_from_camera,
      RigidNear(TruePose(0) * Rigid3d(Eigen::Quaterniond::Identity(), {0, 0, 0.5}), 1e-6, 1e-6));
}

// Both submaps have the same poses, because each has a world frame of its own.
TEST(Backend, PlacesDisconnectedSubmapsBesideEachOther) {
  const auto none = [](int, const auto&, const auto&) { return std::vector<LoopVerification>(); };
  Backend backend({}, {}, Enabled(), NoCalibration(), none);
  const FramePyramid pyramid = FlatPyramid();
  backend.AddFrame(Stamped(0, 0), TruePose(0), {}, pyramid);
  backend.BeginSubmap();
  backend.AddFrame(Stamped(50, 1.5), TruePose(0), {}, pyramid);
  EXPECT_TRUE(backend.Finish().empty());
  const Eigen::AlignedBox3d box(Eigen::Vector3d(-1, -1, 0), Eigen::Vector3d(2, 1, 3));
  const std::optional<WorldCorrection> apart = backend.PlacePieces({box, box});
  ASSERT_TRUE(apart);
  EXPECT_THAT(backend.poses().frames()[0].world_from_camera, RigidNear(TruePose(0), 1e-12, 1e-12));
  // The second box begins 1 m after the end of the first box, at x = 3 instead of -1.
  const Rigid3d moved(Eigen::Quaterniond::Identity(), {4, 0, 0});
  EXPECT_THAT(backend.poses().frames()[1].world_from_camera,
              RigidNear(moved * TruePose(0), 1e-12, 1e-12));
  EXPECT_THAT(apart->corrections.At(50), RigidNear(moved, 1e-12, 1e-12));
  EXPECT_THAT(apart->corrections.At(0), RigidNear(Rigid3d(), 1e-12, 1e-12));
}

TEST(Backend, MarksRelocalizationAsLoop) {
  const auto none = [](int, const auto&, const auto&) { return std::vector<LoopVerification>(); };
  Backend backend({}, {}, Enabled(), NoCalibration(), none);
  const FramePyramid pyramid = FlatPyramid();
  backend.AddFrame(Stamped(0, 0), TruePose(0), GoodIcp(), pyramid);
  backend.AfterRelocalization(0);
  backend.AddFrame(Stamped(30, 1), TruePose(2), GoodIcp(), pyramid);
  ASSERT_EQ(backend.poses().edges().size(), 1u);
  EXPECT_TRUE(backend.poses().edges()[0].loop);
  ASSERT_EQ(backend.poses().loops().size(), 1u);
  const LoopRecord& loop = backend.poses().loops()[0];
  EXPECT_EQ(loop.source_frame, 30);
  EXPECT_EQ(loop.target_frame, 0);
  EXPECT_TRUE(loop.in_graph);
}

// Odometry connects a keyframe to the last keyframe, except for the first keyframe of a map and
// after relocalisation.
TEST(Backend, ReportsParentsOfKeyframes) {
  const auto none = [](int, const auto&, const auto&) { return std::vector<LoopVerification>(); };
  Backend backend({}, {}, Enabled(), NoCalibration(), none);
  const FramePyramid pyramid = FlatPyramid();
  backend.AddFrame(Stamped(10, 0), TruePose(0), {}, pyramid);
  backend.AddFrame(Stamped(20, 1), TruePose(kFrames / 2), GoodIcp(), pyramid);
  backend.AfterRelocalization(0);
  backend.AddFrame(Stamped(30, 2), TruePose(1), GoodIcp(), pyramid);
  backend.BeginSubmap();
  backend.AddFrame(Stamped(40, 3), TruePose(1), {}, pyramid);
  std::vector<std::vector<int>> links;
  for (const KeyframeLink& link : backend.poses().keyframes()) {
    links.push_back({link.frame, link.parent_frame, link.submap});
  }
  EXPECT_THAT(links, ElementsAre(ElementsAre(10, KeyframeLink::kNone, 0), ElementsAre(20, 10, 0),
                                 ElementsAre(30, 10, 0), ElementsAre(40, KeyframeLink::kNone, 1)));
}

TEST(BackendThreads, AreBitwiseIdentical) {
  const auto runs = AtThreads({1, 2, 4}, [] { return RunBackend(Enabled(), TrueLoops).frames; });
  for (const std::vector<PosedFrame>& frames : runs) ExpectSamePoses(frames, runs[0]);
}

constexpr int kBetween = 12;

// The translation along x is 100 times weaker constrained, as in front of a wall with a vertical
// edge.
IcpResult HeldLittleAlongX() {
  IcpResult icp;
  Vector6d sigmas = Vector6d::Constant(1e-5);
  sigmas[3] = 1e-3;
  icp.covariance = sigmas.cwiseAbs2().asDiagonal();
  icp.information = icp.covariance->inverse();
  return icp;
}

Matrix6d CovarianceOfOdometry(const IcpResult& icp, int frames, const Rigid3d& a_from_b) {
  return OdometryInformation(icp, frames, a_from_b, EdgeNoise()).inverse();
}

// The prior of unobservable directions has a sigma of 0.1. Its effect on the weakest direction is
// (0.017 / 0.1)^2 = 3 %.
TEST(EdgeInformation, OdometryHasRandomWalkDrift) {
  const EdgeNoise noise;
  const Matrix6d covariance = CovarianceOfOdometry(HeldLittleAlongX(), kBetween, Rigid3d());
  const double walk = noise.shared_points * kBetween;
  EXPECT_NEAR(covariance(3, 3), walk * 1e-6 + std::pow(noise.odometry_m, 2), 0.03 * walk * 1e-6);
  EXPECT_NEAR(covariance(4, 4), walk * 1e-10 + std::pow(noise.odometry_m, 2), 1e-10);
  EXPECT_NEAR(covariance(0, 0), walk * 1e-10 + std::pow(noise.odometry_rad, 2), 1e-10);
  EXPECT_GT(covariance(3, 3), 1e3 * covariance(4, 4));
}

// The later camera is rotated by 90 degrees: its x axis is the y axis of the earlier camera.
TEST(EdgeInformation, WeakDirectionRotatesWithCamera) {
  const Rigid3d quarter(Eigen::Quaterniond(Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ())),
                        {0, 0, 0});
  const Matrix6d covariance = CovarianceOfOdometry(HeldLittleAlongX(), kBetween, quarter);
  EXPECT_GT(covariance(4, 4), 50 * covariance(3, 3));
}

// As for odometry, the registration is in the frame of the relocalised camera. Points share errors.
TEST(EdgeInformation, RelocalizationRotatesAndScalesItsRegistration) {
  const EdgeNoise noise;
  const Rigid3d quarter(Eigen::Quaterniond(Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ())),
                        {0, 0, 0});
  const Matrix6d covariance =
      RelocalizationInformation(HeldLittleAlongX(), quarter, noise).inverse();
  const double weak = noise.shared_points * 1e-6;
  EXPECT_NEAR(covariance(4, 4), weak + std::pow(noise.loop_m, 2), 0.03 * weak);
  EXPECT_NEAR(covariance(3, 3), std::pow(noise.loop_m, 2), 1e-6);
}

TEST(EdgeInformation, HasFixedSigmaForUnobservableDirections) {
  IcpResult icp;  // without information
  for (const int frames : {1, 1000}) {
    const Matrix6d covariance = CovarianceOfOdometry(icp, frames, Rigid3d());
    for (int i = 0; i < 6; ++i) EXPECT_NEAR(std::sqrt(covariance(i, i)), 0.1, 1e-3) << frames;
  }
}

}  // namespace
}  // namespace surfit::testing
