// Sessions of surfit_slam, and the tool surfit_session.
#include "surfit/session/session.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <map>
#include <random>
#include <thread>

#include "surfit/core/error.h"
#include "surfit/evaluation/trajectory_evaluation.h"
#include "surfit/io/sequence.h"
#include "surfit/io/trajectory_files.h"
#include "testing/shared_data.h"
#include "tools/slam_tool.h"

namespace surfit::testing {
namespace {

class SessionTool : public SlamTool {
 protected:
  std::string Session() const { return own_.path() + "/session"; }
  ProgramResult Keep(const std::string& output, std::vector<std::string> flags) const {
    flags.push_back("--session=" + Session());
    flags.push_back("--nofinal_map");
    return Slam(Room(), Output(output), std::move(flags));
  }
  ProgramResult Tool(const std::string& command, std::vector<std::string> flags = {}) const {
    flags.insert(flags.begin(), command);
    flags.push_back("--session=" + Session());
    return RunProgram("surfit_session", flags);
  }
  // Kills a run `rounds` times and continues it each time.
  void OutlivesKills(int rounds) const {
    std::mt19937_64 rng(2);
    std::uniform_int_distribution<int> delay_ms(0, 300);
    const std::string endless = EndlessRoom();
    for (int round = 0; round < rounds; ++round) {
      const bool goes_on = HasSession(Session());
      const std::string csv = Output() + "/frames.csv";
      std::filesystem::remove(csv);  // written by the previous round
      RunningProgram running("surfit_slam",
                             {"--sequence=" + endless, "--output=" + Output(), "--nopictures",
                              "--session=" + Session(), goes_on ? "--continue" : "--nocontinue"});
      while (Lines(csv).size() < 20 && running.IsRunning()) {
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(delay_ms(rng)));
      running.Signal(SIGKILL);
      running.Wait();
      EXPECT_THAT(CheckSession(Session()), IsEmpty());
      const int last = std::stoi(Lines(csv).back());
      const auto frames = ReadSession(Session()).state.frames;
      ASSERT_FALSE(frames.empty());
      EXPECT_LE(last - frames.back().index, 31);
    }
  }
};

TEST_F(SessionTool, StoresARunAndContinuesIt) {
  Succeeded(Keep("first", {"--last=11"}));
  EXPECT_THAT(Succeeded(Tool("list")).out, Names(12, "/room", "tum", 0));
  Succeeded(Tool("check"));
  EXPECT_THAT(Keep("again", {}).err, HasError(Session()));

  // With the same flags, the run skips the frames of the session.
  Succeeded(Keep("second", {"--continue"}));
  EXPECT_EQ(CountPoses(Output("second") + "/trajectory.txt"), kFrames - 12);
  const ProgramResult complete = Keep("complete", {"--continue"});
  EXPECT_EQ(complete.exit_code, 1);
  EXPECT_THAT(complete.err, HasError(Room(), kFrames));
  EXPECT_THAT(complete.err, HasSubstr("is complete: it has"));
  Succeeded(Tool("export", {"--output=" + Output("exported")}));
  EXPECT_EQ(CountPoses(Output("exported") + "/trajectory.txt"), kFrames);
  EXPECT_EQ(CountPoses(Output("exported") + "/run-2.txt"), kFrames - 12);
  EXPECT_TRUE(std::filesystem::exists(Output("exported") + "/map.ply"));
  EXPECT_TRUE(std::filesystem::exists(Output("exported") + "/places.bin"));

  // The poses agree with one run over all frames to 1 cm.
  Succeeded(Slam(Room(), Output("whole"), {"--loop_closure", "--nofinal_map"}));
  const Trajectory whole = ReadTumTrajectory(Output("whole") + "/trajectory.txt");
  const Trajectory halves = ReadTumTrajectory(Output("exported") + "/trajectory.txt");
  ASSERT_EQ(whole.size(), halves.size());
  for (std::size_t i = 0; i < whole.size(); ++i) {
    EXPECT_LT(
        (whole[i].world_from_camera.translation - halves[i].world_from_camera.translation).norm(),
        0.01)
        << i;
  }
}

// All files except temporary files of SQLite, by path.
std::map<std::string, std::string> FilesOf(const std::string& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    const bool is_kept = entry.path().extension() == ".db" || entry.path().extension() == ".tile";
    if (is_kept) files[entry.path()] = ReadBytes(entry.path());
  }
  return files;
}

TEST_F(SessionTool, LocalisesWithoutChangingTheSession) {
  Succeeded(Keep("first", {"--last=15"}));
  const auto before = FilesOf(Session());
  Succeeded(Keep("found", {"--first=8", "--localize"}));
  EXPECT_EQ(FilesOf(Session()), before);
  const auto summary = Summary(Output("found"));
  EXPECT_GE(summary["localization"]["frames"], 12);
  EXPECT_GT(summary["localization"]["median_sigma_m"], 0);
  // The first frame has a second row after its confirmation by the next frame.
  EXPECT_EQ(Lines(Output("found") + "/localization.csv").size(), 2u + kFrames - 8);
}

TEST_F(SessionTool, MergesAndCompacts) {
  Succeeded(Keep("first", {"--last=15"}));
  std::filesystem::rename(Session(), own_.path() + "/a");
  Succeeded(Keep("second", {"--first=6"}));
  std::filesystem::rename(Session(), own_.path() + "/b");
  const auto merged =
      Tool("merge", {"--from=" + own_.path() + "/a", "--from=" + own_.path() + "/b"});
  EXPECT_THAT(Succeeded(merged).out, Names(2));
  // Many surfels that both sessions have observed are merged.
  const auto surfels = [&](const std::string& session) { return CountSession(session).surfels; };
  EXPECT_LT(surfels(Session()), 0.9 * (surfels(own_.path() + "/a") + surfels(own_.path() + "/b")));
  Succeeded(Tool("check"));
  Succeeded(Tool("compact"));
  Succeeded(Tool("export", {"--output=" + Output("exported")}));
  // Equal frames of both sessions have equal poses within two pixels at 2 m.
  const Trajectory a = ReadTumTrajectory(Output("exported") + "/run-1.txt");
  const Trajectory b = ReadTumTrajectory(Output("exported") + "/run-2.txt");
  ASSERT_GE(b.size(), 10u);
  for (std::size_t i = 6; i < a.size(); ++i) {
    EXPECT_LT((a[i].world_from_camera.translation - b[i - 6].world_from_camera.translation).norm(),
              0.03);
  }
}

// Compares runs with the ground truth in the world frame of the first run.
class SessionSweep : public SessionTool {
 protected:
  static double WorstError_m(const Trajectory& poses, const Trajectory& truth,
                             const Rigid3d& truth_from_world) {
    double worst_m = 0;
    for (const MatchedPose& pose : MatchPoses(truth, poses, {})) {
      const Eigen::Vector3d at = truth_from_world * pose.estimate.translation;
      worst_m = std::max(worst_m, (at - pose.ground_truth.translation).norm());
    }
    return worst_m;
  }
  static double Median(std::vector<double> values) {
    if (values.empty()) return 0;
    std::sort(values.begin(), values.end());
    return values[values.size() / 2];
  }
  static Trajectory PosesOf(const std::string& session) {
    Trajectory poses;
    for (const PosedFrame& frame : ReadSession(session).state.frames) {
      poses.push_back({frame.stamp_s, frame.world_from_camera});
    }
    return poses;
  }
  static Rigid3d TruthFrom(const Trajectory& poses, const Trajectory& truth) {
    std::vector<Eigen::Vector3d> here, there;
    for (const MatchedPose& pose : MatchPoses(truth, poses, {})) {
      here.push_back(pose.estimate.translation);
      there.push_back(pose.ground_truth.translation);
    }
    return AlignPoints(here, there).target_from_source;
  }
};

// Each session shares a doorway with the previous session.
TEST_F(SessionSweep, MergesThreeSessionsOfThreeRooms) {
  const std::string rooms = Simulate("rooms", {"--scene=three_rooms", "--frames=1500"});
  std::vector<std::string> flags;
  for (const auto& [first, last] : {std::pair(0, 599), {500, 1099}, {1000, 1499}}) {
    const std::string part = own_.path() + "/part" + std::to_string(first);
    Succeeded(Slam(rooms, Output("part"),
                   {Concat("--first=", first), Concat("--last=", last), "--session=" + part,
                    "--nofinal_map"}));
    flags.push_back("--from=" + part);
  }
  EXPECT_THAT(Succeeded(Tool("merge", flags)).out, Names(3));
  Succeeded(Tool("export", {"--output=" + Output("exported")}));
  const Trajectory truth = ReadTumTrajectory(rooms + "/groundtruth.txt");
  const auto run = [&](int number) {
    return ReadTumTrajectory(Concat(Output("exported"), "/run-", number, ".txt"));
  };
  const Rigid3d truth_from_world = TruthFrom(run(1), truth);
  for (const int number : {1, 2, 3}) {
    EXPECT_GT(run(number).size(), 490u);
    EXPECT_LT(WorstError_m(run(number), truth, truth_from_world), 0.1) << number;
  }
}

// The reference is one run over both halves with loop closure, aligned by the poses of the first
// half. All frames of the second half see surfaces of the first half.
TEST_F(SessionSweep, LocalisesTheSecondHalfOfARecordingInTheFirst) {
  SURFIT_REQUIRE_SHARED_DATA("seven_scenes_kitchen");
  const auto run = [&](const std::string& output, std::vector<std::string> flags) {
    flags.insert(flags.end(), {"--downsample=2", "--loop_closure"});
    Succeeded(Slam(SharedData("seven_scenes_kitchen"), Output(output), flags));
    return ReadTumTrajectory(Output(output) + "/trajectory.txt");
  };
  const Trajectory whole = run("whole", {});
  const Trajectory half = run("half", {"--last=499", "--session=" + Session()});
  const Trajectory found = run("found", {"--first=500", "--session=" + Session(), "--localize"});
  EXPECT_GE(found.size(), 475u);
  const Rigid3d whole_from_session = TruthFrom(half, whole);
  const auto errors_m = [&](const Trajectory& poses) {
    std::vector<double> of;
    for (const MatchedPose& pose : MatchPoses(whole, poses, {})) {
      const Eigen::Vector3d at = whole_from_session * pose.estimate.translation;
      of.push_back((at - pose.ground_truth.translation).norm());
    }
    return of;
  };
  const double found_m = Median(errors_m(found)), half_m = Median(errors_m(half));
  std::printf("%zu frames found, %.1f mm (median) from the one run; the first half %.1f mm\n",
              found.size(), 1e3 * found_m, 1e3 * half_m);
  EXPECT_LT(found_m, 0.01);
}

// The kitchen at half resolution. A session of frames 0 to 499 continues with frame 500, and with
// frame 700, whose pose is unknown.
TEST_F(SessionSweep, ContinuesAtTheEndOfAHalfAndElsewhere) {
  SURFIT_REQUIRE_SHARED_DATA("seven_scenes_kitchen");
  const std::string kitchen = SharedData("seven_scenes_kitchen");
  const auto run = [&](const std::string& output, std::vector<std::string> flags) {
    flags.insert(flags.end(), {"--downsample=2", "--loop_closure", "--norefine", "--nofinal_map"});
    Succeeded(Slam(kitchen, Output(output), flags));
    return ReadTumTrajectory(Output(output) + "/trajectory.txt");
  };
  SequenceOptions sequence;
  sequence.path = kitchen;
  const Trajectory truth = OpenSequence(sequence)->info().ground_truth;
  const auto ate_m = [&](const Trajectory& poses) {
    return ComputeAbsoluteTrajectoryError(MatchPoses(truth, poses, {})).value().translation_m.rmse;
  };
  const Trajectory whole = run("whole", {});
  run("half", {"--last=499", "--session=" + Session()});
  const std::string elsewhere = own_.path() + "/elsewhere";
  std::filesystem::copy(Session(), elsewhere, std::filesystem::copy_options::recursive);
  run("end", {"--session=" + Session(), "--continue"});
  const Trajectory found = run("found", {"--first=700", "--session=" + elsewhere, "--continue"});
  const Trajectory halves = PosesOf(Session()), parts = PosesOf(elsewhere);
  std::printf(
      "ATE %.1f mm in one run, %.1f mm in halves, %.1f mm where it goes on at frame 700, "
      "of which %zu of 300 are found\n",
      1e3 * ate_m(whole), 1e3 * ate_m(halves), 1e3 * ate_m(parts), found.size());
  EXPECT_EQ(halves.size(), whole.size());
  EXPECT_LT(ate_m(halves), 1.1 * ate_m(whole));
  EXPECT_GE(found.size(), 295u);
  EXPECT_LT(ate_m(parts), 1.1 * ate_m(whole));
}

TEST_F(SessionTool, SurvivesSigkill) { OutlivesKills(3); }

TEST_F(SessionSweep, SurvivesSigkillTwentyTimes) { OutlivesKills(20); }

TEST_F(SessionTool, RejectsBadInput) {
  ExpectRefused(Slam(Room(), Output(), {"--continue"}), "continue");
  ExpectRefused(Slam(Room(), Output(), {"--session=" + Session(), "--localize"}), Session(),
                "session.db");
  ExpectRefused(Tool("list"), Session());
  ExpectRefused(Tool("turn"), "command");
  ExpectRefused(Tool("merge", {"--from=" + Session()}), "from");
}

}  // namespace
}  // namespace surfit::testing
