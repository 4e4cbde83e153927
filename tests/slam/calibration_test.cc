// Tests the calibration of the depth camera during tracking, with exact ground truth.
#include <gtest/gtest.h>

#include <algorithm>

#include "mapping/same_map.h"
#include "slam/simulated_sequence.h"
#include "surfit/frame/rectify_frame.h"
#include "testing/matchers.h"
#include "testing/threads.h"

namespace surfit::testing {
namespace {

constexpr int kCalibratedFrames = 120;

// Half the image size of a Kinect.
PinholeCamera TrueCamera() { return {320, 240, 262.5, 262.5, 159.5, 119.5, {}}; }

SimulatedSequence Room(std::uint64_t seed) {
  return Simulate("room", seed, kCalibratedFrames, Sensor::kKinect, TrueCamera());
}

// A quarter of the image size of a Kinect.
SimulatedSequence SmallRoom() { return Simulate("room", 1, kCalibratedFrames, Sensor::kKinect); }

constexpr double kTilt = 0.03;  // 1/m

// Adds errors of focal length, principal point and depth to the input calibration.
SimulatedSequence WronglyGiven(SimulatedSequence sequence) {
  for (RgbdFrame& frame : sequence.frames) {
    CorrectDepth(sequence.camera, {{0, kTilt, 0, 0, 0, 0}}, &frame.depth_m);
  }
  sequence.camera.fx *= 1.015;
  sequence.camera.fy *= 1.015;
  sequence.camera.cx += 1.5;
  return sequence;
}

struct CalibratedRun {
  double rms_m = 0;  // RMSE of the final positions
  bool is_recalibrated = false;
  std::size_t waits = 0;
  DepthCalibration found;
  std::vector<CalibrationRecord> calibrations;
  Trajectory trajectory;
  SurfelMap map;
};

CalibratedRun CalibratedRunOf(const SimulatedSequence& sequence,
                              const SlamOptions& options = SlamOptions()) {
  Slam slam({sequence.camera, {}}, options, sequence.world_from_camera[0]);
  for (const RgbdFrame& frame : sequence.frames) slam.Process(frame);
  slam.Finish();
  CalibratedRun run;
  const Backend& backend = *slam.backend();
  run.waits = backend.counts().waits;
  run.is_recalibrated = backend.is_recalibrated();
  run.found = *backend.calibration();
  run.calibrations = backend.calibrations();
  run.trajectory = backend.poses().trajectory();
  run.map = slam.map();
  double squares = 0;
  for (std::size_t i = 0; i < run.trajectory.size(); ++i) {
    squares += (run.trajectory[i].world_from_camera.translation -
                sequence.world_from_camera[i].translation)
                   .squaredNorm();
  }
  run.rms_m = std::sqrt(squares / static_cast<double>(run.trajectory.size()));
  return run;
}

double UncalibratedRms(const SimulatedSequence& sequence) {
  SlamOptions options;
  options.calibration.enabled = false;
  return ErrorsOf(RunSlam(sequence, options, sequence.world_from_camera[0]),
                  sequence.world_from_camera)
      .rms_m;
}

TEST(SlamCalibration, KeepsCorrectCalibration) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const SimulatedSequence room = Room(seed);
    const CalibratedRun run = CalibratedRunOf(room);
    EXPECT_FALSE(run.is_recalibrated) << seed;
    EXPECT_GE(run.calibrations.size(), 2u) << seed;
    EXPECT_EQ(run.found.camera.fx, room.camera.fx);
    EXPECT_NEAR(run.rms_m, UncalibratedRms(room), 1e-12) << seed;
  }
}

// Loop closures compare views of keyframes before and after a calibration.
TEST(SlamCalibration, RecalibratesViewsOfKeyframes) {
  const SimulatedSequence room = WronglyGiven(SmallRoom());
  Slam slam({room.camera, {}}, SlamOptions(), room.world_from_camera[0]);
  for (const RgbdFrame& frame : room.frames) slam.Process(frame);
  slam.Finish();
  const Backend& backend = *slam.backend();
  ASSERT_TRUE(backend.is_recalibrated());
  ASSERT_FALSE(backend.keyframe_views().empty());
  for (const Keyframe& keyframe : backend.keyframe_views()) {
    EXPECT_EQ(keyframe.view.field.coefficients, backend.calibration()->field.coefficients);
    EXPECT_EQ(keyframe.view.camera.fx, backend.calibration()->camera.fx);
  }
}

TEST(SlamCalibration, CorrectsWrongCalibration) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const SimulatedSequence room = WronglyGiven(Room(seed));
    const CalibratedRun run = CalibratedRunOf(room);
    ASSERT_TRUE(run.is_recalibrated) << seed;
    EXPECT_LT(run.rms_m, UncalibratedRms(room) / 2) << seed;
    const Eigen::VectorXd sigma =
        run.calibrations.back().summary.calibration_covariance.diagonal().cwiseSqrt();
    const PinholeCamera &found = run.found.camera, truth = TrueCamera();
    const std::array<double, 4> errors = {found.fx - truth.fx, found.fy - truth.fy,
                                          found.cx - truth.cx, found.cy - truth.cy};
    EXPECT_LT(std::abs(run.found.readout_s), 3 * sigma[10]) << seed;
    for (int i = 0; i < 10; ++i) {
      const double error =
          i < 4 ? errors[i] : run.found.field.coefficients[i - 4] + (i == 5) * kTilt;
      EXPECT_LT(std::abs(error), 3 * sigma[i]) << "seed " << seed << ", number " << i;
    }
  }
}

// Frames arrive without pause, so all tasks are late. Loop closure is enabled as well.
TEST(SlamCalibration, InRealTimeNoFrameWaits) {
  SlamOptions options;
  options.real_time = true;
  options.loops.enabled = true;
  for (const int threads : {1, 2}) {
    const ThreadLimit limit(threads);
    const SimulatedSequence room = WronglyGiven(SmallRoom());
    const CalibratedRun run = CalibratedRunOf(room, options);
    EXPECT_EQ(run.waits, 0u);
    EXPECT_TRUE(run.is_recalibrated);
    EXPECT_LT(run.rms_m, UncalibratedRms(room));
  }
}

TEST(SlamCalibration, StopsWithGivenPoses) {
  const SimulatedSequence room = WronglyGiven(SmallRoom());
  Slam slam({room.camera, {}}, SlamOptions(), {});
  for (std::size_t i = 0; i < room.frames.size(); ++i) {
    slam.ProcessAt(room.frames[i], room.world_from_camera[i]);
  }
  slam.Finish();
  EXPECT_TRUE(slam.backend()->calibrations().empty());
  EXPECT_EQ(slam.sensor().camera.fx, room.camera.fx);
  EXPECT_EQ(slam.backend()->poses().trajectory().back().world_from_camera.Matrix(),
            room.world_from_camera.back().Matrix());
}

TEST(SlamCalibrationThreads, AreBitwiseIdentical) {
  const SimulatedSequence room = WronglyGiven(SmallRoom());
  const auto runs = AtThreads({1, 2}, [&] { return CalibratedRunOf(room); });
  EXPECT_TRUE(runs[0].is_recalibrated);
  for (const CalibrationRecord& record : runs[0].calibrations) {
    const int count = static_cast<int>(record.keyframes);
    const int last_without = record.begun_frame + 1 + count / 2 + count * count / 40 - 1;
    EXPECT_EQ(record.frame, std::min(last_without, kCalibratedFrames - 1));
  }
  EXPECT_EQ(runs[0].found.camera.fx, runs[1].found.camera.fx);
  EXPECT_EQ(runs[0].found.field.coefficients, runs[1].found.field.coefficients);
  ExpectSameMap(runs[0].map, runs[1].map);
}

// The loop has an offset of 5 cm to odometry, and closes during calibration. Calibration moves the
// last keyframe as much as without the loop.
TEST(CalibrationAndLoops, CalibrationKeepsCorrectionOfLoop) {
  SlamOptions options;
  options.loops.enabled = true;
  options.loops.delay_frames = 1;
  options.loops.keyframes.max_distance_m = 0.1;
  options.loops.graph.loop_robustness = "none";
  options.loops.noise.odometry_m = options.loops.noise.odometry_rad = 0.1;  // the loop dominates
  options.calibration.first_keyframes = options.calibration.max_keyframes = 5;
  options.calibration.refinement.calibration_sigmas = 0;  // small changes are applied as well
  options.calibration.refinement.model_error_ratio = 0;
  const SimulatedSequence room =
      WronglyGiven(Simulate("room", 1, 60, Sensor::kKinect, SimulatedCamera()));
  const Rigid3d aside(Eigen::Quaterniond::Identity(), {0.03, 0, 0.04});
  const auto first_from_last = [&](bool finds_loop) {
    Slam slam({room.camera, {}}, options, room.world_from_camera[0]);
    slam.UseLoopFinder([&](int source, const std::vector<Keyframe>& keyframes, const PlaceIndex&) {
      std::vector<LoopVerification> loops;
      if (!finds_loop || source != 4) return loops;
      LoopVerification& loop = loops.emplace_back();
      loop.proposal.source = 4;
      loop.proposal.target = 0;
      loop.verdict.reason = GlobalRegistrationReason::kAccepted;
      loop.verdict.target_from_source =
          aside * keyframes[0].world_from_camera.Inverse() * keyframes[4].world_from_camera;
      loop.verdict.information = 1e8 * Matrix6d::Identity();
      return loops;
    });
    for (const RgbdFrame& frame : room.frames) {
      slam.Process(frame);
      if (slam.backend()->is_recalibrated()) break;
    }
    const Backend& backend = *slam.backend();
    EXPECT_TRUE(backend.is_recalibrated());
    EXPECT_EQ(backend.counts().loops_accepted, finds_loop ? 1u : 0u);
    const auto pose_of = [&](int keyframe) {
      return backend.poses().FrameOf(keyframe).world_from_camera;
    };
    return pose_of(0).Inverse() * pose_of(4);
  };
  EXPECT_THAT(first_from_last(true), RigidNear(aside * first_from_last(false), 0.005, 0.005));
}

// Colour is captured 30 ms before depth. The timestamps contain this offset or not.
TEST(ColorLatency, IsOffsetThatTimestampsDoNotContain) {
  constexpr double kEarlier_s = 0.03;
  RgbdCamera camera;
  camera.depth = SimulatedCamera();
  camera.color_latency_s = kEarlier_s;
  SlamOptions options;
  options.loops.keyframes.max_distance_m = 0.05;
  options.calibration.first_keyframes = options.calibration.max_keyframes = 14;
  SimulatedSequence room = Simulate("room", 1, 160, Sensor::kKinect, camera, {}, 2);
  for (const bool is_told : {false, true}) {
    Slam slam({room.camera, {}}, options, room.world_from_camera[0]);
    for (RgbdFrame& frame : room.frames) {
      frame.color_stamp_s = frame.stamp_s - (is_told ? kEarlier_s : 0);
      slam.Process(frame);
      if (!slam.backend()->calibrations().empty()) break;
    }
    slam.Finish();
    ASSERT_EQ(slam.backend()->calibrations().size(), 1u);
    const ColorLatency& found = slam.backend()->calibrations()[0].color_latency;
    EXPECT_GT(found.keyframes, 0);
    EXPECT_NEAR(found.latency_s, is_told ? 0 : kEarlier_s, 3 * found.sigma_s);
    EXPECT_LT(found.sigma_s, kEarlier_s / 5);
  }
}

}  // namespace
}  // namespace surfit::testing
