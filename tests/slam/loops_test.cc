// Tests loop closure, tracking loss and relocalisation of the whole pipeline in simulated rooms.

#include <gtest/gtest.h>

#include <algorithm>

#include "mapping/same_map.h"
#include "slam/simulated_sequence.h"
#include "testing/threads.h"

namespace surfit::testing {
namespace {

SlamOptions WithLoops() {
  SlamOptions options;
  options.loops.enabled = true;
  return options;
}

// Path in a room, then a path in an unmapped room, then the begin of the first path.
SimulatedSequence KidnappedAndBack(int known, int unknown, int seen_again) {
  const SimulatedSequence room = SimulateRoom(1, known, Sensor::kKinect);
  const SimulatedSequence other = SimulateRoom(3, unknown, Sensor::kKinect);
  SimulatedSequence sequence = room;
  const auto add = [&](const SimulatedSequence& from, int begin, int end) {
    for (int i = begin; i < end; ++i) {
      sequence.frames.push_back(from.frames[i]);
      sequence.frames.back().index = static_cast<int>(sequence.frames.size()) - 1;
      sequence.frames.back().stamp_s = sequence.frames.back().index / 30.;
      sequence.world_from_camera.push_back(from.world_from_camera[i]);
    }
  };
  add(other, 0, unknown);
  add(room, 0, seen_again);
  return sequence;
}

struct LoopRun {
  std::vector<FrameReport> reports;
  std::vector<PosedFrame> frames;
  BackendCounts counts;
  SurfelMap map;
};

LoopRun RunLoops(const SimulatedSequence& sequence, const SlamOptions& options) {
  Slam slam({sequence.camera, {}}, options, sequence.world_from_camera[0]);
  LoopRun run;
  for (const RgbdFrame& frame : sequence.frames) run.reports.push_back(slam.Process(frame));
  slam.Finish();
  run.frames = slam.backend()->poses().frames();
  run.counts = slam.backend()->counts();
  run.map = slam.map();
  return run;
}

TEST(SlamLoops, RelocalisesKidnappedCamera) {
  constexpr int kKnown = 60, kUnknown = 12, kAgain = 15;
  const SimulatedSequence sequence = KidnappedAndBack(kKnown, kUnknown, kAgain);
  SlamOptions options = WithLoops();
  options.loops.new_map_after = 0;
  const LoopRun run = RunLoops(sequence, options);
  for (int i = kKnown; i < kKnown + kUnknown; ++i) {
    EXPECT_EQ(run.reports[i].state, FrameState::kLost) << i;
    EXPECT_EQ(run.reports[i].fusion.merged_points, 0) << i;
  }
  const auto found =
      std::find_if(run.reports.begin() + kKnown + kUnknown, run.reports.end(),
                   [](const FrameReport& report) { return report.state != FrameState::kLost; });
  ASSERT_NE(found, run.reports.end());
  EXPECT_EQ(found->state, FrameState::kRelocalized);
  EXPECT_LE(found - run.reports.begin(), kKnown + kUnknown + 10);
  EXPECT_EQ(run.counts.relocalisations, 1u);
  EXPECT_EQ(run.counts.submaps, 1u);
  // The tolerance is the accuracy of the map: two pixels at 2 m.
  for (auto report = found; report != run.reports.end(); ++report) {
    const Rigid3d& truth = sequence.world_from_camera[report->index];
    EXPECT_LT((report->world_from_camera.translation - truth.translation).norm(), 0.03);
  }
}

TEST(SlamLoops, StartsNewSubmapAfterLongLoss) {
  SlamOptions options = WithLoops();
  options.loops.new_map_after = 5;
  const LoopRun run = RunLoops(KidnappedAndBack(30, 20, 0), options);
  EXPECT_EQ(run.reports[30 + 3].state, FrameState::kLost);
  EXPECT_EQ(run.reports[30 + 4].state, FrameState::kNewMap);
  EXPECT_EQ(run.counts.submaps, 2u);
  EXPECT_EQ(run.counts.disconnected_submaps, 1u);
  EXPECT_EQ(run.reports.back().state, FrameState::kTracked);
}

// The second submap has its own map and world frame. They do not disturb the first submap.
TEST(SlamLoops, ReturnsFromSubmapToFirstSubmap) {
  constexpr int kKnown = 40, kUnknown = 25, kAgain = 20;
  SlamOptions options = WithLoops();
  options.loops.new_map_after = 5;
  const SimulatedSequence sequence = KidnappedAndBack(kKnown, kUnknown, kAgain);
  const auto runs = AtThreads({1, 2}, [&] { return RunLoops(sequence, options); });
  const LoopRun& run = runs[0];
  EXPECT_EQ(run.reports[kKnown + 4].state, FrameState::kNewMap);
  const auto found = std::find_if(
      run.reports.begin() + kKnown + kUnknown, run.reports.end(),
      [](const FrameReport& report) { return report.state == FrameState::kRelocalized; });
  ASSERT_NE(found, run.reports.end());
  EXPECT_LE(found - run.reports.begin(), kKnown + kUnknown + 10);
  for (auto report = found; report != run.reports.end(); ++report) {
    const Rigid3d& truth = sequence.world_from_camera[report->index];
    EXPECT_LT((report->world_from_camera.translation - truth.translation).norm(), 0.03);
  }
  EXPECT_EQ(run.counts.submaps, 2u);
  EXPECT_EQ(run.counts.disconnected_submaps, 1u);
  ExpectSameMap(runs[1].map, run.map);
  ExpectSamePoses(runs[1].frames, run.frames);
}

TEST(SlamLoopsThreads, AreBitwiseIdentical) {
  const SimulatedSequence sequence = KidnappedAndBack(40, 6, 10);
  const auto runs = AtThreads({1, 2}, [&] { return RunLoops(sequence, WithLoops()); });
  ExpectSameMap(runs[1].map, runs[0].map);
  ExpectSamePoses(runs[1].frames, runs[0].frames);
}

}  // namespace
}  // namespace surfit::testing
