// Tests recordings in which the camera is blind for a time, or jumps to other places and back.
#include <gtest/gtest.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "slam/simulated_sequence.h"
#include "testing/threads.h"

namespace surfit::testing {
namespace {

constexpr int kMaxLostFrames = 10;

// Parts [begin, end) of the path of a room, at 30 Hz. `jumps`: indices of the first frames of all
// parts except the first part.
struct RecordingWithJumps {
  SimulatedSequence sequence;
  std::vector<int> jumps;
};

RecordingWithJumps Join(const SimulatedSequence& room,
                        const std::vector<std::pair<int, int>>& parts) {
  RecordingWithJumps joined;
  SimulatedSequence& sequence = joined.sequence;
  for (const auto& [begin, end] : parts) {
    if (!sequence.frames.empty()) joined.jumps.push_back(static_cast<int>(sequence.frames.size()));
    for (int i = begin; i < end; ++i) {
      RgbdFrame frame = room.frames[i];
      frame.index = static_cast<int>(sequence.frames.size());
      frame.stamp_s = frame.color_stamp_s = frame.index / 30.;
      sequence.frames.push_back(std::move(frame));
      sequence.world_from_camera.push_back(room.world_from_camera[i]);
    }
  }
  return joined;
}

void RemoveColor(SimulatedSequence* sequence) {
  for (RgbdFrame& frame : sequence->frames) frame.color = {};
}

struct LossRun {
  std::vector<FrameReport> reports;
  std::vector<PosedFrame> frames;
  BackendCounts counts;
};

LossRun RunToTheEnd(const SimulatedSequence& sequence) {
  Slam slam({sequence.camera, {}}, SlamOptions(), sequence.world_from_camera[0]);
  LossRun run;
  for (const RgbdFrame& frame : sequence.frames) run.reports.push_back(slam.Process(frame));
  slam.Finish();
  run.frames = slam.backend()->poses().frames();
  run.counts = slam.backend()->counts();
  return run;
}

// Number of consecutive frames without a pose. Counts frame `begin` and later frames.
int LostFramesFrom(int begin, const LossRun& run) {
  const auto first = run.reports.begin() + begin;
  return static_cast<int>(std::find_if(first, run.reports.end(),
                                       [](const FrameReport& report) { return report.HasPose(); }) -
                          first);
}

double LargestError(const LossRun& run, const SimulatedSequence& sequence) {
  double largest_m = 0;
  for (const PosedFrame& frame : run.frames) {
    const Rigid3d& truth = sequence.world_from_camera[frame.index];
    largest_m =
        std::max(largest_m, (frame.world_from_camera.translation - truth.translation).norm());
  }
  return largest_m;
}

class NeverLost : public ::testing::TestWithParam<bool> {
 protected:
  void Prepare(SimulatedSequence* sequence) const {
    if (!GetParam()) RemoveColor(sequence);
  }
};

TEST_P(NeverLost, FindsCameraAfterTwentyBlindFrames) {
  constexpr int kBlind = 60, kBlindFrames = 20;
  SimulatedSequence room = SimulateRoom(2, 140, Sensor::kKinect);
  Prepare(&room);
  for (int i = kBlind; i < kBlind + kBlindFrames; ++i) {
    RgbdFrame& frame = room.frames[i];
    std::fill(frame.depth_m.begin(), frame.depth_m.end(), 0.f);
    std::fill(frame.color.begin(), frame.color.end(), Rgb8());
  }
  const LossRun run = RunToTheEnd(room);
  EXPECT_EQ(LostFramesFrom(kBlind, run) >= kBlindFrames, true);
  EXPECT_LE(LostFramesFrom(kBlind + kBlindFrames, run), kMaxLostFrames);
  EXPECT_EQ(run.counts.disconnected_submaps, 0u);
  EXPECT_LT(LargestError(run, room), 0.05);
}

// The camera jumps five times to another place and back. In the end it visits all places, so that
// loop closures join all submaps.
TEST_P(NeverLost, JoinsSubmapsOfFiveJumps) {
  SimulatedSequence room = SimulateRoom(2, 400, Sensor::kKinect);
  Prepare(&room);
  std::vector<std::pair<int, int>> parts = {{0, 40}};
  for (int jump = 0; jump < 5; ++jump) {
    parts.emplace_back(150 + 50 * jump, 165 + 50 * jump);
    parts.emplace_back(10 + 10 * jump, 25 + 10 * jump);
  }
  parts.back().second = 400;
  const RecordingWithJumps recording = Join(room, parts);
  const LossRun run = RunToTheEnd(recording.sequence);
  for (const int jump : recording.jumps) {
    EXPECT_LE(LostFramesFrom(jump, run), kMaxLostFrames) << jump;
  }
  EXPECT_GE(run.counts.submaps, 2u);
  // Depth alone recognises fewer places, and one submap stays separate.
  EXPECT_LE(run.counts.disconnected_submaps, GetParam() ? 0u : 1u);
  if (run.counts.disconnected_submaps == 0) {
    EXPECT_LT(LargestError(run, recording.sequence), 0.1);
  }
}

INSTANTIATE_TEST_SUITE_P(Color, NeverLost, ::testing::Bool());

// Keyframe views do not change the poses of a camera that is never lost.
TEST(NeverLostTracking, EqualsTrackingWithoutRelocalisation) {
  const SimulatedSequence room = SimulateRoom(2, 80, Sensor::kKinect);
  std::vector<LossRun> runs;
  for (const bool relocalization : {false, true}) {
    SlamOptions options;
    options.loops.relocalization = relocalization;
    Slam slam({room.camera, {}}, options, room.world_from_camera[0]);
    LossRun run;
    for (const RgbdFrame& frame : room.frames) run.reports.push_back(slam.Process(frame));
    slam.Finish();
    runs.push_back(std::move(run));
  }
  ExpectSamePoses(runs[0].reports, runs[1].reports);
}

TEST(NeverLostThreads, AreBitwiseIdentical) {
  const SimulatedSequence room = SimulateRoom(2, 200, Sensor::kKinect);
  const RecordingWithJumps recording = Join(room, {{0, 40}, {150, 170}, {30, 45}, {140, 190}});
  const auto runs = AtThreads({1, 2}, [&] { return RunToTheEnd(recording.sequence); });
  ExpectSamePoses(runs[0].frames, runs[1].frames);
  ExpectSamePoses(runs[0].reports, runs[1].reports);
}

}  // namespace
}  // namespace surfit::testing
