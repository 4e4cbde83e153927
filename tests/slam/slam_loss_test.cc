#include <gmock/gmock.h>

#include <algorithm>
#include <iterator>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "mapping/same_map.h"
#include "slam/simulated_sequence.h"
#include "surfit/core/error.h"
#include "surfit/slam/slam.h"
#include "testing/matchers.h"

namespace surfit::testing {
namespace {

TEST(Slam, LostFrameIsNotFusedAndTrackingContinues) {
  const SimulatedSequence& room = IdealRoom();
  for (const char* tracking : {"frame_to_model", "frame_to_frame"}) {
    SlamOptions options;
    options.tracking = tracking;
    Slam slam({room.camera, {}}, options, room.world_from_camera[0]);
    for (int i = 0; i < 8; ++i) slam.Process(room.frames[i]);
    const SurfelMap before = slam.map();
    for (int i = 8; i < 10; ++i) {  // the second frame is a duplicate of the first lost frame
      const FrameReport lost = slam.Process(Blank(i));
      EXPECT_EQ(lost.state, FrameState::kLost);
      EXPECT_EQ(lost.icp.termination, Termination::kTooFewInliers);
      EXPECT_EQ(lost.fusion.input_points, 0);
    }
    ExpectSameMap(slam.map(), before);
    for (int i = 10; i < 14; ++i) {
      const FrameReport report = slam.Process(room.frames[i]);
      EXPECT_EQ(report.state, FrameState::kTracked) << tracking << i;
      EXPECT_THAT(report.world_from_camera,
                  RigidNear(room.world_from_camera[i], kPixelAt2m, kPixelRad));
    }
  }
}

// Registration of the frame after a weakly constrained frame uses all rows of the images.
TEST(LostFrame, HasTheIcpOptionsInUse) {
  const SimulatedSequence& room = IdealRoom();
  for (const bool is_weak : {false, true}) {
    SlamOptions options;
    if (is_weak) options.min_turn_eigenvalue = 1e9;
    Slam slam({room.camera, {}}, options, room.world_from_camera[0]);
    std::vector<int> rows;
    slam.OnLostFrame(
        [&](const LostFrame& lost) { rows.push_back(lost.icp_options.min_source_rows); });
    for (int i = 0; i < 3; ++i) slam.Process(room.frames[i]);
    slam.Process(Blank(3));
    EXPECT_THAT(rows, ElementsAre(is_weak ? 0 : options.icp.min_source_rows));
  }
}

// The motion is four times larger than at the frame rate, and twelve times larger after two lost
// frames. There is no global registration. A second frame confirms the pose.
TEST(Slam, ContinuesOverLostFramesWithMotionPrior) {
  const SimulatedSequence room = SimulateRoom(12, 100, Sensor::kIdeal);
  SlamOptions options;
  options.initialize = "identity";
  options.loops.enabled = options.loops.relocalization = false;
  const auto state_after_loss = [&] {
    Slam slam({room.camera, {}}, options, room.world_from_camera[0]);
    FrameReport report;
    for (int i = 0; i < 13; ++i) {
      RgbdFrame frame = room.frames[4 * i];
      frame.stamp_s = room.frames[i].stamp_s;
      if (i == 9 || i == 10) frame.depth_m = Blank(0).depth_m;
      report = slam.Process(frame);
    }
    return report.state;
  };
  EXPECT_EQ(state_after_loss(), FrameState::kLost);
  options.acceleration_m_per_s2 = 2;
  EXPECT_EQ(state_after_loss(), FrameState::kTracked);
}

TEST(Slam, LosesFrameOfOtherPlace) {
  const SimulatedSequence& room = IdealRoom();
  const Scene elsewhere = MakeScene("sphere");
  Slam slam({room.camera, {}}, SlamOptions(), {});
  for (int i = 0; i < 4; ++i) slam.Process(room.frames[i]);
  const SurfelMap before = slam.map();
  Eigen::Matrix3d along_y;
  along_y << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  const Rigid3d pose(along_y, Eigen::Vector3d(0, 1.1, 1));  // 0.4 m in front of the ball
  const FrameReport report = slam.Process(RenderFrame(elsewhere, room.camera, pose, 4));
  EXPECT_EQ(report.state, FrameState::kLost);
  ExpectSameMap(slam.map(), before);
  EXPECT_EQ(slam.Process(room.frames[5]).state, FrameState::kTracked);
}

// Skips 57 frames: 0.8 m, outside the range of tracking.
TEST(Slam, RelocalisesAfterJump) {
  const SimulatedSequence room = SimulateRoom(12, 122, Sensor::kIdeal);
  for (const char* tracking : {"frame_to_model", "frame_to_frame"}) {
    for (const char* initialize : {"identity", "features"}) {
      SlamOptions options;
      options.tracking = tracking;
      options.initialize = initialize;
      Slam slam({room.camera, {}}, options, room.world_from_camera[60]);
      for (int i = 60; i < 63; ++i) slam.Process(room.frames[i]);
      const SurfelMap before = slam.map();
      const FrameReport report = slam.Process(room.frames[120]);
      if (options.initialize == "identity") {
        EXPECT_EQ(report.state, FrameState::kLost) << tracking;
        ExpectSameMap(slam.map(), before);
      } else {
        EXPECT_EQ(report.state, FrameState::kTracked) << tracking;
        EXPECT_TRUE(report.found_by_search);
        EXPECT_THAT(report.world_from_camera,
                    RigidNear(room.world_from_camera[120], kPixelAt2m, kPixelRad));
        const FrameReport next = slam.Process(room.frames[121]);
        EXPECT_EQ(next.state, FrameState::kTracked) << tracking;
        EXPECT_FALSE(next.found_by_search);
      }
    }
  }
}

// After a long loss, the pose is accepted if the next frame agrees. Then the previous frame gets
// its pose, also in the trajectory.
TEST(Slam, NextFrameConfirmsPoseAfterLongLoss) {
  const SimulatedSequence room = SimulateRoom(12, 20, Sensor::kIdeal);
  const RgbdFrame nothing = {0, 0, 0, Image<float>(room.camera.width, room.camera.height), {}};
  for (const bool loops : {false, true}) {
    SlamOptions options;
    options.loops.enabled = loops;
    Slam slam({room.camera, {}}, options, room.world_from_camera[0]);
    int held = 0;
    for (int i = 0; i < 20; ++i) {
      RgbdFrame frame = i >= 5 && i < 14 ? nothing : room.frames[i];
      frame.index = i, frame.stamp_s = room.frames[i].stamp_s;
      const FrameReport report = slam.Process(frame);
      held += report.state != FrameState::kLost;
      if (!report.confirmed) continue;
      ++held;
      EXPECT_EQ(report.confirmed->index, i - 1);
      EXPECT_EQ(report.confirmed->stamp_s, room.frames[i - 1].stamp_s);
      EXPECT_THAT(report.confirmed->world_from_camera,
                  RigidNear(room.world_from_camera[i - 1], kPixelAt2m, kPixelRad));
    }
    EXPECT_EQ(held, 11) << loops;
    slam.Finish();
    ASSERT_TRUE(slam.backend());
    EXPECT_EQ(slam.backend()->poses().trajectory().size(), 11u);
  }
}

// Every 25th frame: most motions are 0.3 m and 11 degrees. Tracking can converge to a wrong pose
// with 75 % of the points within the gates.
TEST(Slam, DistantFramesAreTrackedOrLostButNotWrong) {
  constexpr int kStride = 25;
  int held = 0;
  for (const int seed : {3, 5, 8}) {
    const SimulatedSequence room =
        Simulate("room", seed, 500, Sensor::kKinect, SimulatedCamera(), kStride);
    SlamOptions options;
    options.loops.new_map_after = 0;  // a submap has its own world frame
    const SlamRun run = RunSlam(room, options, room.world_from_camera[0]);
    for (std::size_t i = 0; i < run.reports.size(); ++i) {
      if (run.reports[i].state == FrameState::kLost) continue;
      ++held;
      EXPECT_THAT(run.reports[i].world_from_camera,
                  RigidNear(room.world_from_camera[i], 4 * kPixelAt2m, 4 * kPixelRad))
          << "seed " << seed << ", frame " << i;
    }
  }
  EXPECT_GE(held, 30) << "of 60";
}

// Frames at 7.5 Hz. Registration from the first pose converges 0.3 m off, with 90 % inliers.
TEST(Slam, SecondFrameIsVerifiedByGlobalRegistration) {
  const PinholeCamera camera = {320, 240, 262.5, 262.5, 159.5, 119.5, {}};
  SimulatedSequence room = Simulate("room", 4, 90, Sensor::kIdeal, camera, 4);
  room.frames.resize(2);
  const SlamRun run = RunSlam(room, SlamOptions(), room.world_from_camera[0]);
  ASSERT_NE(run.reports[1].state, FrameState::kLost);
  EXPECT_THAT(run.reports[1].world_from_camera, RigidNear(room.world_from_camera[1], 0.01, 0.01));
}

// Ratio of the first and the last loss on the coarsest level. It is near 1 if the prediction is the
// registered pose.
double LossRatio(const IcpResult& icp) {
  const auto is_finer = [&](const IcpIteration& i) { return i.level < icp.iterations[0].level; };
  const auto end = std::find_if(icp.iterations.begin(), icp.iterations.end(), is_finer);
  return icp.iterations[0].average_loss / std::prev(end)->average_loss;
}

// The motion across lost frames must not be extrapolated: the camera stands still after them. The
// motion before them is larger than the noise, so its repetition would increase the loss.
TEST(Slam, PredictsNoMotionAfterLoss) {
  const SimulatedSequence& room = IdealRoom();
  Slam slam({room.camera, {}}, SlamOptions(), {});
  for (int i = 0; i < 4; ++i) slam.ProcessAt(room.frames[i], room.world_from_camera[i]);
  for (int i = 4; i < 8; ++i) slam.Process(Blank(i));
  EXPECT_EQ(slam.Process(room.frames[8]).state, FrameState::kTracked);
  RgbdFrame still = room.frames[8];
  still.index = 9;
  still.stamp_s = room.frames[9].stamp_s;
  still.depth_m(0, 0) = 0;  // not a duplicate
  EXPECT_LT(LossRatio(slam.Process(still).icp), 1.1);
  EXPECT_GT(LossRatio(slam.Process(room.frames[10]).icp), 1.5);
}

// The camera repeats a motion that is constant in its frame. So the prediction is the true pose,
// and ICP starts there. The prediction of frame 1 is the pose of frame 0, because no motion is
// known.
TEST(Slam, PredictsConstantMotionInCameraFrame) {
  const Scene scene = MakeScene("room", 1);
  const Rigid3d motion(QuaternionExp<double>({0.02, 0.03, 0}), {0.03, 0, 0.02});
  SlamOptions options;
  options.initialize = "identity";
  Rigid3d world_from_camera = IdealRoom().world_from_camera[0];
  Slam slam({IdealRoom().camera, {}}, options, world_from_camera);
  std::vector<double> first_losses;
  for (int i = 0; i < 4; ++i) {
    const FrameReport report =
        slam.Process(RenderFrame(scene, IdealRoom().camera, world_from_camera, i, i / 30.));
    world_from_camera = world_from_camera * motion;
    if (i == 0) continue;
    EXPECT_EQ(report.state, FrameState::kTracked) << i;
    first_losses.push_back(report.icp.iterations.at(0).average_loss);
  }
  EXPECT_LT(first_losses.back(), 0.1 * first_losses.front());
}

// A Kinect needs a few frames until it measures depth. These frames must not create an empty map.
TEST(Slam, StartsWithFirstFrameWithDepth) {
  const SimulatedSequence& room = IdealRoom();
  Slam slam({room.camera, {}}, SlamOptions(), room.world_from_camera[2]);
  EXPECT_EQ(slam.Process(Blank(0)).state, FrameState::kLost);
  EXPECT_EQ(slam.Process(Blank(1)).state, FrameState::kLost);
  EXPECT_EQ(slam.map().size(), 0u);
  const FrameReport first = slam.Process(room.frames[2]);
  EXPECT_EQ(first.state, FrameState::kFirst);
  EXPECT_EQ(first.world_from_camera.Matrix(), room.world_from_camera[2].Matrix());
  EXPECT_EQ(slam.Process(room.frames[3]).state, FrameState::kTracked);
}

// Actions per frame: f = fused, v = new model view, b = both, - = none. `periods` are changes of
// the map period, by frame.
std::string TurnsOf(const SlamOptions& options, int frames,
                    const std::map<int, int>& periods = {}) {
  Slam slam({IdealRoom().camera, {}}, options, {});
  std::string turns;
  for (int i = 0; i < frames; ++i) {
    if (periods.count(i) > 0) slam.SetMapPeriod(periods.at(i));
    const std::size_t before = slam.map().size();
    const FrameReport report = slam.Process(IdealRoom().frames[i]);
    turns += report.is_fused && report.has_own_view ? 'b'
             : report.is_fused                      ? 'f'
             : report.has_own_view                  ? 'v'
                                                    : '-';
    EXPECT_EQ(report.fusion.input_points > 0, report.is_fused) << i;
    if (!report.is_fused) {
      EXPECT_EQ(slam.map().size(), before) << i;
    }
  }
  return turns;
}

TEST(Slam, AlternatesFusionAndRendering) {
  SlamOptions options;
  options.max_view_shift = 1e9;
  options.min_turn_eigenvalue = 0;
  options.map_period = 1;
  EXPECT_EQ(TurnsOf(options, 5), "fbbbb");
  options.map_period = 2;
  EXPECT_EQ(TurnsOf(options, 6), "fvfvfv");
  options.map_period = 4;
  EXPECT_EQ(TurnsOf(options, 10), "fv--fv--fv");
}

TEST(Slam, SupportsChangesOfMapPeriod) {
  SlamOptions options;
  options.max_view_shift = 1e9;
  options.min_turn_eigenvalue = 0;
  options.map_period = 1;
  EXPECT_EQ(TurnsOf(options, 11, {{3, 3}, {9, 1}}), "fbbv-fv-fbb");
}

// The image has 120 rows.
TEST(Slam, RegistersHalfOfTheRowsWithLongerMapPeriod) {
  SlamOptions options;
  options.icp.min_source_rows = 40;
  options.min_turn_eigenvalue = 0;
  const auto last_pairs = [&options](bool is_hurried) {
    Slam slam({IdealRoom().camera, {}}, options, {});
    for (int i = 0; i < 3; ++i) slam.Process(IdealRoom().frames[i]);
    if (is_hurried) slam.SetMapPeriod(2 * options.map_period);
    const FrameReport report = slam.Process(IdealRoom().frames[3]);
    EXPECT_EQ(report.state, FrameState::kTracked);
    return static_cast<double>(report.icp.system.pair_count);
  };
  const double all = last_pairs(false);
  EXPECT_NEAR(last_pairs(true) / all, 0.5, 0.05);
}

TEST(Slam, FusesAndRendersAfterLargeMotion) {
  SlamOptions options;
  options.map_period = 4;
  options.max_view_shift = 0;
  options.min_turn_eigenvalue = 0;
  EXPECT_EQ(TurnsOf(options, 6), "fbbbbb");
}

TEST(Slam, AllowsLargerMotionWithLongerMapPeriod) {
  constexpr int kFrames = 20, kPeriod = 100;
  const auto turns_of = [&](double max_view_shift, int map_period) {
    SlamOptions options;
    options.min_turn_eigenvalue = 0;
    options.max_view_shift = max_view_shift;
    options.map_period = map_period;
    return TurnsOf(options, kFrames, {{0, kPeriod}});
  };
  const std::string given = turns_of(0.04, kPeriod);
  const std::string longer = turns_of(0.04, kPeriod / 2);
  EXPECT_EQ(longer, turns_of(1.5 * 0.04, kPeriod));
  EXPECT_LT(std::count(longer.begin(), longer.end(), '-'), kFrames - 2);
  EXPECT_GT(std::count(longer.begin(), longer.end(), '-'),
            std::count(given.begin(), given.end(), '-'));
}

TEST(Slam, FusesAndRendersAfterWeaklyConstrainedFrame) {
  SlamOptions options;
  options.map_period = 4;
  options.min_turn_eigenvalue = 1;  // above the eigenvalues of all frames
  EXPECT_EQ(TurnsOf(options, 5), "fvbbb");
}

TEST(Slam, MapPeriodIsAtLeastOne) {
  Slam slam({IdealRoom().camera, {}}, SlamOptions(), {});
  EXPECT_THROW(slam.SetMapPeriod(0), InputError);
}

TEST(Slam, FusesWeaklyConstrainedFramesPeriodicallyWithLargeMapPeriod) {
  SlamOptions options;
  options.map_period = 2;
  options.min_turn_eigenvalue = 1;
  EXPECT_EQ(TurnsOf(options, 6, {{0, 4}}), "fvvvbv");
}

TEST(Slam, TreatsFewerFramesAsWeaklyConstrainedWithLargeMapPeriod) {
  SlamOptions options;
  options.map_period = 2;
  options.max_view_shift = 1e9;
  options.min_turn_eigenvalue = 0;
  Slam slam({IdealRoom().camera, {}}, options, {});
  double least = std::numeric_limits<double>::infinity(), most = 0;
  for (int i = 0; i < 6; ++i) {
    const FrameReport report = slam.Process(IdealRoom().frames[i]);
    if (i == 0) continue;
    least = std::min(least, report.icp.eigenvalues[0]);
    most = std::max(most, report.icp.eigenvalues[0]);
  }
  ASSERT_LT(most, 1.5 * least);
  options.min_turn_eigenvalue = 1.1 * most;
  EXPECT_EQ(TurnsOf(options, 6), "fvbbbb");
  EXPECT_EQ(TurnsOf(options, 6, {{0, 4}}), "fv--fv");
}

TEST(Slam, FusesAndRendersFrameAfterLoss) {
  SlamOptions options;
  options.map_period = 8;
  Slam slam({IdealRoom().camera, {}}, options, {});
  for (int i = 0; i < 4; ++i) slam.Process(IdealRoom().frames[i]);
  EXPECT_EQ(slam.Process(Blank(4)).state, FrameState::kLost);
  const FrameReport next = slam.Process(IdealRoom().frames[5]);
  EXPECT_EQ(next.state, FrameState::kTracked);
  EXPECT_TRUE(next.is_fused);
  EXPECT_TRUE(next.has_own_view);
}

}  // namespace
}  // namespace surfit::testing
