// Runs with SlamRunOptions::prior_poses.
#include <gmock/gmock.h>

#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "run/depth_frames.h"
#include "slam/simulated_sequence.h"
#include "surfit/io/trajectory_files.h"
#include "surfit/run/slam_run.h"
#include "testing/matchers.h"
#include "testing/sequence_writer.h"
#include "testing/temp_folder.h"

namespace surfit::testing {
namespace {

constexpr int kPriorRunFrames = 90;

// A recording of a simulated room, without ground truth.
class PriorRunTest : public ::testing::Test {
 protected:
  void WriteRoom(int frames) {
    const SimulatedSequence room = SimulateRoom(2, frames, Sensor::kKinect);
    WriteDepthFrames(room.frames, 1000, sequence_);
    for (int i = 0; i < frames; ++i) {
      prior_.push_back({room.frames[i].stamp_s, room.world_from_camera[i]});
    }
    sequence_.Write("camera.yaml",
                    "%YAML:1.0\n---\ndepth_camera: { width: 160, height: 120, fx: 131.25, fy: "
                    "131.25, cx: 79.5, cy: 59.5 }\ndepth_units_per_metre: 1000.\n"
                    "frames_per_second: 30.\n");
    options_.sequence = Options(sequence_);
    options_.sequence.format = "tum";
    options_.output = output_.path() + "/out";
    options_.prior_poses = output_.path() + "/prior.txt";
    options_.pictures = false;
  }
  nlohmann::json Run() const {
    RunSlam(options_, false, [](const SlamRunProgress&) {});
    return nlohmann::json::parse(ReadBytes(options_.output + "/summary.json"));
  }

  TempFolder sequence_, output_;
  SlamRunOptions options_;
  Trajectory prior_;
};

TEST_F(PriorRunTest, CountsARejectedJumpInTheSummary) {
  WriteRoom(kPriorRunFrames);
  for (int i = 60; i < kPriorRunFrames; ++i) prior_[i].world_from_camera.translation.y() -= 0.2;
  WriteTumTrajectory(prior_, options_.prior_poses);
  const nlohmann::json prior = Run()["prior_poses"];
  EXPECT_EQ(prior["frames_compared"], kPriorRunFrames - 1);
  EXPECT_EQ(prior["frames_without"], 0);
  EXPECT_GT(prior["frames_used"], 20);
  EXPECT_GE(prior["frames_rejected"], 1);
  EXPECT_LE(prior["frames_rejected"], 2);
  bool has_jump = false;
  for (const auto& stretch : prior["rejected_s"]) {
    has_jump |= std::abs(stretch[0].get<double>() - prior_[60].stamp_s) < 1e-5;
  }
  EXPECT_TRUE(has_jump);
}

TEST_F(PriorRunTest, CountsFramesWithoutPriorPose) {
  WriteRoom(kPriorRunFrames);
  prior_.resize(50);
  WriteTumTrajectory(prior_, options_.prior_poses);
  const nlohmann::json prior = Run()["prior_poses"];
  EXPECT_EQ(prior["frames_compared"], 49);
  EXPECT_EQ(prior["frames_without"], kPriorRunFrames - 50);
}

TEST_F(PriorRunTest, RejectsBadFiles) {
  WriteRoom(2);
  const std::string good = "0 0 0 0 0 0 0 1\n";
  const auto expect = [&](const std::string& text, const auto&... names) {
    output_.Write("prior.txt", text);
    ExpectInputError([&] { Run(); }, Names("prior.txt", names...));
  };
  expect("", 0, 2);
  expect(good, 1, 2);
  expect(good + "# comment\n0.1 0 0 0 0 0 1\n", ":3", 7, 8);
  expect(good + "0.1 0 x 0 0 0 0 1\n", ":2", "x");
  expect(good + "0.1 0 nan 0 0 0 0 1\n", ":2", "nan");
  expect(good + "0.1 0 0 0 0 0 0 3\n", ":2", "quaternion", 3, 1);
  expect(good + "0.1 0 0 2e12 0 0 0 1\n", ":2", "2e+12");
  expect(good + good, "timestamp", "0.000000");
  options_.prior_poses = "missing.txt";
  ExpectInputError([&] { Run(); }, Names("missing.txt"));
}

}  // namespace
}  // namespace surfit::testing
