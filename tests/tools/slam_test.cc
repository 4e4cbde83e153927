#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <random>
#include <sstream>
#include <thread>

#include "surfit/io/point_cloud.h"
#include "testing/run_program.h"
#include "testing/temp_folder.h"
#include "testing/trace_slices.h"

namespace surfit::testing {
namespace {

namespace fs = std::filesystem;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr int kFrames = 24;

std::vector<std::string> Lines(const std::string& path) {
  std::ifstream file(path);
  std::vector<std::string> lines;
  for (std::string line; std::getline(file, line);) lines.push_back(line);
  return lines;
}

int CountPoses(const std::string& path) {
  const auto lines = Lines(path);
  return static_cast<int>(std::count_if(lines.begin(), lines.end(), [](const std::string& line) {
    return !line.empty() && line[0] != '#';
  }));
}

// A simulated Kinect's walk through a room, at 160 x 120 pixels; made once for all tests.
class SlamTool : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TempFolder;
    Simulate("room", {});
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }

  static std::string Simulate(const std::string& name, std::vector<std::string> flags) {
    const std::string path = folder_->path() + "/" + name;
    flags.insert(flags.begin(), {"--output=" + path, "--frames=" + std::to_string(kFrames),
                                 "--sensor=kinect", "--downsample=4"});
    const ProgramResult result = RunProgram("surfit_simulate", flags);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return path;
  }
  static std::string Room() { return folder_->path() + "/room"; }
  // A copy of the room that a test may spoil.
  std::string CopyOfRoom() const {
    const std::string copy = own_.path() + "/copy";
    fs::copy(Room(), copy, fs::copy_options::recursive);
    return copy;
  }
  // The room's frames over and over, so many that no run is done before it is interrupted.
  std::string EndlessRoom() const {
    const std::string copy = CopyOfRoom();
    const std::vector<std::string> rows = Lines(copy + "/associations.txt");
    std::ofstream file(copy + "/associations.txt");
    for (int i = 0; i < 10000; ++i) {
      std::istringstream row(rows[i % rows.size()]);
      std::string stamp, color, depth;
      row >> stamp >> color >> stamp >> depth;
      file << i << " " << color << " " << i << " " << depth << "\n";
    }
    return copy;
  }
  std::string Output(const std::string& name = "out") const { return own_.path() + "/" + name; }

  ProgramResult Slam(const std::string& sequence, const std::string& output,
                     std::vector<std::string> flags = {}) const {
    flags.insert(flags.begin(), {"--sequence=" + sequence, "--output=" + output});
    if (!pictures_) flags.push_back("--nopictures");
    return RunProgram("surfit_slam", flags);
  }
  static nlohmann::json Summary(const std::string& output) {
    return nlohmann::json::parse(ReadBytes(output + "/summary.json"));
  }

  static TempFolder* folder_;
  TempFolder own_;
  bool pictures_ = false;
};

TempFolder* SlamTool::folder_ = nullptr;

TEST_F(SlamTool, WritesTrajectoryMapTablesAndPictures) {
  pictures_ = true;
  const ProgramResult result = Slam(Room(), Output());
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("ATE RMSE"));
  const nlohmann::json summary = Summary(Output());
  EXPECT_EQ(summary["frames_total"], kFrames);
  EXPECT_EQ(summary["frames_tracked"], kFrames);
  EXPECT_EQ(summary["frames_skipped"], 0);
  EXPECT_EQ(summary["frames_without_intensities"], 0);
  EXPECT_EQ(summary["interrupted"], false);
  EXPECT_EQ(summary["input_points"], kFrames * 160 * 120);
  EXPECT_LE(summary["input_points_valid"], summary["input_points"]);
  EXPECT_EQ(summary["ate_coverage"], 1.0);
  EXPECT_DOUBLE_EQ(summary["compression_ratio"],
                   summary["input_points"].get<double>() / summary["map_points"].get<double>());
  EXPECT_EQ(summary["map_points"], summary["surfels_added"].get<std::int64_t>() -
                                       summary["surfels_removed"].get<std::int64_t>());
  // The pixels are 4 mm apart at 0.5 m and 30 mm at 4 m: the camera is followed to a small share.
  EXPECT_LT(summary["ate_rmse_m"], 0.015);
  for (const char* key :
       {"match_share", "rpe_translation_rmse_m", "rpe_rotation_rmse_deg", "total_s", "frame_ms",
        "stage_ms", "peak_rss_bytes", "residual", "association", "solver", "options", "digest"}) {
    EXPECT_TRUE(summary.contains(key) && !summary[key].is_null()) << key;
  }
  EXPECT_EQ(summary["options"]["sequence"], Room());
  EXPECT_EQ(CountPoses(Output() + "/trajectory.txt"), kFrames);
  EXPECT_EQ(Lines(Output() + "/frames.csv").size(), kFrames + 1u);
  EXPECT_EQ(ReadPly(Output() + "/map.ply").points.size(), summary["map_points"]);
  for (const char* name : {"trajectory.png", "map_color.png", "map_normals.png",
                           "map_confidence.png", "map_last_seen.png"}) {
    EXPECT_THAT(ReadBytes(Output() + "/" + name), StartsWith("\x89PNG")) << name;
  }
}

TEST_F(SlamTool, SaysWhatItDidAboutLoops) {
  ASSERT_EQ(Slam(Room(), Output(), {"--loop_closure"}).exit_code, 0);
  const nlohmann::json summary = Summary(Output());
  EXPECT_GE(summary["keyframes"], 1);
  for (const char* key : {"loops_proposed", "loops_accepted", "loops_refused", "relocalisations",
                          "map_corrections", "submaps_apart", "surfels_merged_by_loops"}) {
    EXPECT_EQ(summary[key], 0) << key;  // so short a walk has none
  }
  EXPECT_EQ(summary["submaps"], 1);
  EXPECT_EQ(Lines(Output() + "/loops.csv").size(), 1u);
  EXPECT_EQ(ReadBytes(Output() + "/trajectory.txt"),
            ReadBytes(Output() + "/trajectory_online.txt"));
  EXPECT_EQ(CountPoses(Output() + "/trajectory.txt"), kFrames);
}

TEST_F(SlamTool, ClosesNoLoopsOfGivenPoses) {
  const ProgramResult result = Slam(Room(), Output(), {"--loop_closure", "--poses=groundtruth"});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("poses is 'groundtruth'"));
}

TEST_F(SlamTool, GivesTheSameDigestAgainAndAtAnyNumberOfThreads) {
  std::vector<std::string> digests;
  for (const char* threads : {"--threads=1", "--threads=2", "--threads=2", "--threads=4"}) {
    ASSERT_EQ(Slam(Room(), Output(), {threads}).exit_code, 0);
    digests.push_back(Summary(Output())["digest"]);
  }
  EXPECT_THAT(digests, ::testing::Each(digests[0]));
}

TEST_F(SlamTool, GivesTheSameDigestWithBaseInstructionsAlone) {
  ASSERT_EQ(Slam(Room(), Output()).exit_code, 0);
  const nlohmann::json best = Summary(Output());
  setenv("SURFIT_INSTRUCTIONS", "base", 1);
  const int exit_code = Slam(Room(), Output()).exit_code;
  unsetenv("SURFIT_INSTRUCTIONS");
  ASSERT_EQ(exit_code, 0);
  EXPECT_EQ(Summary(Output())["digest"], best["digest"]);
}

TEST_F(SlamTool, TracesEveryStageOfEveryFrame) {
  const std::string trace = Output() + "/trace.json";
  const ProgramResult result =
      Slam(Room(), Output(), {"--trace=" + trace, "--threads=2", "--map_period=3"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const std::vector<Slice> slices = ReadSlices(trace);
  ExpectNesting(slices);
  std::map<std::pair<std::string, int>, int> counts;
  for (const Slice& slice : slices) ++counts[{slice.name, slice.frame}];
  for (int frame = 0; frame < kFrames; ++frame) {
    for (const char* stage : {"frame", "decode", "preprocess", "write"}) {
      EXPECT_EQ((counts[{stage, frame}]), 1) << stage << " " << frame;
    }
    EXPECT_EQ((counts[{"fuse", frame}]), frame % 3 == 0 ? 1 : 0) << frame;
    for (const char* stage : {"predict", "track"}) {
      EXPECT_EQ((counts[{stage, frame}]), frame > 0 ? 1 : 0) << stage << " " << frame;
    }
  }
  for (const char* stage : {"decode", "preprocess", "predict", "track", "fuse", "write"}) {
    EXPECT_THAT(result.out, HasSubstr("\n" + std::string(stage) + " ")) << result.out;
    const nlohmann::json times = Summary(Output())["stage_ms"][stage];
    EXPECT_GT(times["share"], 0) << stage;
    EXPECT_LE(times["median"], times["p95"]) << stage;
  }
}

TEST_F(SlamTool, UsesGroundTruthForNothingButTheEvaluation) {
  const std::string copy = CopyOfRoom();
  std::vector<std::string> lines = Lines(copy + "/groundtruth.txt");
  // The poses are dealt out anew among the stamps.
  std::vector<std::string> stamps, poses;
  for (const std::string& line : lines) {
    if (line.empty() || line[0] == '#') continue;
    stamps.push_back(line.substr(0, line.find(' ')));
    poses.push_back(line.substr(line.find(' ')));
  }
  std::mt19937_64 rng(1);
  std::shuffle(poses.begin(), poses.end(), rng);
  std::ofstream file(copy + "/groundtruth.txt");
  for (std::size_t i = 0; i < poses.size(); ++i) file << stamps[i] << poses[i] << '\n';
  file.close();

  ASSERT_EQ(Slam(Room(), Output("true")).exit_code, 0);
  ASSERT_EQ(Slam(copy, Output("shuffled")).exit_code, 0);
  EXPECT_EQ(ReadBytes(Output("true") + "/trajectory.txt"),
            ReadBytes(Output("shuffled") + "/trajectory.txt"));
  const nlohmann::json right = Summary(Output("true")), wrong = Summary(Output("shuffled"));
  EXPECT_EQ(right["digest"], wrong["digest"]);
  EXPECT_GT(wrong["ate_rmse_m"], right["ate_rmse_m"]);
}

TEST_F(SlamTool, WritesTheTrajectoryOfAnImageWithYUpInItsOwnConvention) {
  const std::string mirrored = Simulate("mirrored", {"--image_y_up"});
  ASSERT_EQ(Slam(Room(), Output("down")).exit_code, 0);
  ASSERT_EQ(Slam(mirrored, Output("up")).exit_code, 0);
  // The same images of the same room: inside, all but the stamps is the same.
  EXPECT_EQ(ReadBytes(Output("down") + "/map.ply"), ReadBytes(Output("up") + "/map.ply"));
  // Its own ground truth is met without a reflection ...
  std::string truth;
  for (const auto& entry : fs::directory_iterator(mirrored)) {
    if (entry.path().extension() == ".freiburg") truth = entry.path();
  }
  const ProgramResult evaluation =
      RunProgram("surfit_evaluate",
                 {"--groundtruth=" + truth, "--estimate=" + Output("up") + "/trajectory.txt"});
  ASSERT_EQ(evaluation.exit_code, 0) << evaluation.err;
  // ... as well as the other one's (9 decimals are written).
  EXPECT_NEAR(Summary(Output("up"))["ate_rmse_m"], Summary(Output("down"))["ate_rmse_m"], 1e-6);
  EXPECT_NE(ReadBytes(Output("down") + "/trajectory.txt"),
            ReadBytes(Output("up") + "/trajectory.txt"));
}

TEST_F(SlamTool, SkipsAndCountsWhatCannotBeRead) {
  const std::string copy = CopyOfRoom();
  std::vector<fs::path> depths;
  for (const auto& entry : fs::directory_iterator(copy + "/depth")) depths.push_back(entry.path());
  std::sort(depths.begin(), depths.end());
  fs::resize_file(depths[10], fs::file_size(depths[10]) / 2);
  fs::remove(depths[20]);
  const ProgramResult result = Slam(copy, Output());
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr(depths[10].filename().string()));
  EXPECT_THAT(result.err, HasSubstr(depths[20].filename().string()));
  const nlohmann::json summary = Summary(Output());
  EXPECT_EQ(summary["frames_total"], kFrames);
  EXPECT_EQ(summary["frames_skipped"], 2);
  EXPECT_EQ(summary["frames_tracked"], kFrames - 2);
  EXPECT_DOUBLE_EQ(summary["ate_coverage"], (kFrames - 2.0) / kFrames);
  EXPECT_EQ(CountPoses(Output() + "/trajectory.txt"), kFrames - 2);
}

TEST_F(SlamTool, EndsEarlyButWholeOnSigintAndSigterm) {
  const std::string sequence = EndlessRoom();
  for (const int signal : {SIGINT, SIGTERM}) {
    const std::string output = Output(std::to_string(signal));
    RunningProgram program("surfit_slam", {"--sequence=" + sequence, "--output=" + output,
                                           "--nopictures", "--threads=1"});
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (!fs::exists(output + "/trajectory.txt") || CountPoses(output + "/trajectory.txt") < 2) {
      ASSERT_LT(std::chrono::steady_clock::now(), deadline);
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    program.Signal(signal);
    const ProgramResult result = program.Wait();
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const nlohmann::json summary = Summary(output);
    EXPECT_EQ(summary["interrupted"], true);
    EXPECT_LT(summary["frames_total"], 10000);
    EXPECT_EQ(CountPoses(output + "/trajectory.txt"), summary["frames_tracked"]);
    EXPECT_EQ(ReadPly(output + "/map.ply").points.size(), summary["map_points"]);
  }
}

// The room's frames as another format, whose last come only once the first is tracked.
TEST_F(SlamTool, FollowsAFolderThatIsBeingFilled) {
  const TempFolder live;
  const auto copy = [&](int begin, int end) {
    for (const char* folder : {"depth", "rgb"}) {
      fs::create_directory(live.path() + "/" + folder);
      std::vector<fs::path> files;
      for (const auto& entry : fs::directory_iterator(Room() + "/" + folder))
        files.push_back(entry.path());
      std::sort(files.begin(), files.end());
      for (int i = begin; i < end; ++i)
        fs::copy(files[i], live.path() + "/" + folder + "/" + std::to_string(i) + ".png");
    }
  };
  fs::copy(Room() + "/camera.yaml", live / "camera.yaml");
  copy(0, 3);
  RunningProgram program("surfit_slam", {"--sequence=" + live.path(), "--format=watch",
                                         "--output=" + Output(), "--nopictures"});
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (!fs::exists(Output() + "/trajectory.txt") ||
         CountPoses(Output() + "/trajectory.txt") < 3) {
    ASSERT_LT(std::chrono::steady_clock::now(), deadline);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  copy(3, 6);
  live.Write("done", "");
  const ProgramResult result = program.Wait();
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const nlohmann::json summary = Summary(Output());
  EXPECT_EQ(summary["frames_total"], 6);
  EXPECT_EQ(summary["frames_tracked"], 6);
  EXPECT_EQ(summary["interrupted"], false);
}

TEST_F(SlamTool, FusesAlongGivenPoses) {
  ASSERT_EQ(Slam(Room(), Output(), {"--poses=groundtruth"}).exit_code, 0);
  // The files of truth and estimate have 9 decimals at least.
  EXPECT_LT(Summary(Output())["ate_rmse_m"], 1e-8);
}

TEST_F(SlamTool, BeginsAtTheInitialPose) {
  ASSERT_EQ(Slam(Room(), Output(), {"--initial_pose=1,2,3,0.6,0,0,0.8", "--last=2"}).exit_code, 0);
  for (const std::string& line : Lines(Output() + "/trajectory.txt")) {
    if (line[0] == '#') continue;
    EXPECT_THAT(line, EndsWith(" 1.000000000 2.000000000 3.000000000 0.600000000 0.000000000 "
                               "0.000000000 0.800000000"));
    break;
  }
}

TEST_F(SlamTool, TracksAlikeWithEverySolver) {
  std::vector<double> errors_m;
  for (const char* solver : {"--solver=closed_form_ldlt", "--solver=closed_form_lu",
                             "--solver=closed_form_qr", "--solver=ceres", "--solver=tiny"}) {
    ASSERT_EQ(Slam(Room(), Output(), {solver, "--last=9"}).exit_code, 0);
    errors_m.push_back(Summary(Output())["ate_rmse_m"]);
  }
  // They solve the same problem; their sums differ in the seventh digit (single against double
  // precision), and a pair on the border of a gate may fall on either side.
  EXPECT_NEAR(errors_m[1], errors_m[0], 1e-4);
  EXPECT_NEAR(errors_m[2], errors_m[0], 1e-4);
  // Levenberg-Marquardt goes to each problem's minimum, where a Gauss-Newton step stops short: of
  // errors of millimetres a tenth.
  EXPECT_NEAR(errors_m[3], errors_m[0], 5e-4);
  EXPECT_NEAR(errors_m[4], errors_m[3], 1e-4);
}

TEST_F(SlamTool, ReportsALostSequenceWithExitCode2) {
  const std::string copy = CopyOfRoom();
  std::vector<fs::path> depths;
  for (const auto& entry : fs::directory_iterator(copy + "/depth")) depths.push_back(entry.path());
  std::sort(depths.begin(), depths.end());
  const std::string blank = own_.path() + "/blank.png";
  cv::imwrite(blank, cv::Mat(120, 160, CV_16UC1, cv::Scalar(0)));
  for (std::size_t i = 1; i < depths.size(); ++i) {
    fs::copy_file(blank, depths[i], fs::copy_options::overwrite_existing);
  }
  EXPECT_EQ(Slam(copy, Output()).exit_code, 2);
  const nlohmann::json summary = Summary(Output());
  EXPECT_EQ(summary["frames_tracked"], 1);
  EXPECT_TRUE(summary["ate_rmse_m"].is_null());
  EXPECT_EQ(CountPoses(Output() + "/trajectory.txt"), 1);
}

TEST_F(SlamTool, RefusesBadInputInOneSentence) {
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases = {
      {{"--nonsense"}, "nonsense"},
      {{"--threads=0"}, "threads is 0"},
      {{"--threads=abc"}, "abc"},
      {{"--solver=magic"},
       "closed_form_ldlt, closed_form_lu, closed_form_qr, svd, "
       "ceres, ceres_per_point, tiny"},
      {{"--residual=magic"}, "point_to_plane"},
      {{"--association=magic"}, "projective"},
      {{"--weighting=magic"}, "confidence, uniform"},
      {{"--tracking=magic"}, "frame_to_model, frame_to_frame"},
      {{"--motion_model=magic"}, "constant_velocity, constant_pose"},
      {{"--poses=magic"}, "track, groundtruth"},
      {{"--initial_pose=1,2"}, "initial_pose is '1,2'"},
      {{"--downsample=17"}, "downsample"},
      {{"--max_depth_m=-1"}, "max_depth_m"},
      {{"--format=magic"}, "magic"},
      {{"--camera=magic"}, "magic"},
      {{"--first=9999"}, "9999"},
      {{"--max_iterations=0"}, "max_iterations is 0"},
      {{"--output=/dev/null/x"}, "/dev/null/x"},
      {{"--trace=/dev/null/t"}, "/dev/null/t"},
      {{"--sequence=/nonexistent"}, "/nonexistent"},
      {{"--sequence="}, "sequence"},
      {{"surplus"}, "surplus"},
  };
  for (const auto& [flags, what] : cases) {
    const ProgramResult result = Slam(Room(), Output(), flags);
    EXPECT_EQ(result.exit_code, 1) << flags[0];
    EXPECT_THAT(result.err, StartsWith("error: ")) << flags[0];
    EXPECT_THAT(result.err, HasSubstr(what)) << flags[0];
  }
}

TEST_F(SlamTool, HelpNamesEveryFlagWithItsDefault) {
  const ProgramResult result = RunProgram("surfit_slam", {"--help"});
  EXPECT_EQ(result.exit_code, 0);
  for (const char* text : {"--sequence", "--output", "--downsample  (int32, default 1)",
                           "--solver  (string, default \"closed_form_ldlt\")", "--flagfile"}) {
    EXPECT_THAT(result.out, HasSubstr(text));
  }
}

TEST_F(SlamTool, AlignRegistersTwoFramesAndShowsIt) {
  const ProgramResult result = RunProgram(
      "surfit_align", {"--sequence=" + Room(), "--source=0", "--target=3", "--output=" + Output()});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("iter 0: avg loss = "));
  EXPECT_THAT(result.out, HasSubstr("inlier count = "));
  EXPECT_THAT(result.out, HasSubstr("pose error: "));
  for (const char* name : {"before", "after"}) {
    EXPECT_THAT(ReadBytes(Output() + "/" + name + ".png"), StartsWith("\x89PNG"));
    EXPECT_GT(ReadPly(Output() + "/" + name + ".ply").points.size(), 160u * 120u);
  }
}

TEST_F(SlamTool, AlignRefusesBadInputAndReportsFailure) {
  const auto align = [&](std::vector<std::string> flags) {
    flags.insert(flags.begin(), {"--sequence=" + Room(), "--output=" + Output()});
    return RunProgram("surfit_align", flags);
  };
  for (const auto& flags : std::vector<std::vector<std::string>>{
           {"--source=0", "--target=999"}, {"--source=-1"}, {"--solver=magic"}}) {
    const ProgramResult result = align(flags);
    EXPECT_EQ(result.exit_code, 1) << flags[0];
    EXPECT_THAT(result.err, StartsWith("error: ")) << flags[0];
  }
  // More inliers than there are pixels cannot be had.
  const ProgramResult result = align({"--min_inliers=1000000"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.out, HasSubstr("too_few_inliers"));
}

}  // namespace
}  // namespace surfit::testing
