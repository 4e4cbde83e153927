#include <gmock/gmock.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <random>
#include <thread>

#include "surfit/io/point_cloud.h"
#include "surfit/io/trajectory_files.h"
#include "testing/matchers.h"
#include "tools/slam_tool.h"

namespace surfit::testing {
namespace {

namespace fs = std::filesystem;
using ::testing::EndsWith;

TEST_F(SlamTool, ClosesNoLoopsOfGivenPoses) {
  const ProgramResult result = Slam(Room(), Output(), {"--loop_closure", "--poses=groundtruth"});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("poses is 'groundtruth'"));
}

// The sensor's focal lengths are 131.25 px.
TEST_F(SlamTool, TellsThatTheIntrinsicsAreHardlyThoseOfTheSensor) {
  const std::string walk = Simulate("walk", {"--frames=150", "--downsample=4"});
  const ProgramResult right = Succeeded(Slam(walk, Output("right")));
  EXPECT_THAT(right.err, Not(HasSubstr("warning: ")));
  EXPECT_TRUE(Summary(Output("right"))["calibration_doubt"].is_null());
  for (const std::string focal : {"82", "245"}) {
    const ProgramResult wrong =
        Slam(walk, Output(focal), {"--intrinsics=" + focal + "," + focal + ",79.9,59.9"});
    EXPECT_THAT(wrong.err, AllOf(HasSubstr("/camera.yaml says 131.25 131.25"),
                                 HasSubstr("warning: the camera that was found is too far")));
    EXPECT_TRUE(Summary(Output(focal))["calibration_doubt"].is_string());
  }
}

// A textured board, 0.6 m before the camera, hides a quarter of the view from frame 8 on, and
// sways.
void HoldABoardBeforeTheCamera(const std::string& sequence) {
  constexpr int kFrom = 8, kDepth = 3000;  // of TUM's 5000 a metre
  int i = 0;
  for (const std::string& line : Lines(sequence + "/associations.txt")) {
    if (line[0] == '#' || i++ < kFrom) continue;
    std::istringstream row(line);
    std::string stamp, color_file, depth_file;
    row >> stamp >> color_file >> stamp >> depth_file;
    cv::Mat color = cv::imread(sequence + "/" + color_file);
    cv::Mat depth = cv::imread(sequence + "/" + depth_file, cv::IMREAD_UNCHANGED);
    const cv::Rect board(3 * i - 8, depth.rows / 4, depth.cols / 2, depth.rows / 2);
    depth(board) = kDepth;
    cv::Mat texture(board.size(), CV_8UC3);
    cv::randu(texture, 0, 255);
    texture.copyTo(color(board));
    cv::imwrite(sequence + "/" + color_file, color);
    cv::imwrite(sequence + "/" + depth_file, depth);
  }
}

TEST_F(SlamTool, TellsThatMuchOfTheViewMovesByItself) {
  const std::string copy = CopyOfRoom();
  HoldABoardBeforeTheCamera(copy);
  const ProgramResult still = Succeeded(Slam(Room(), Output("still")));
  EXPECT_THAT(still.err, Not(HasSubstr("moves by itself")));
  EXPECT_EQ(Summary(Output("still"))["frames_with_motion"], 0);
  EXPECT_THAT(Slam(copy, Output()).err, HasSubstr("more than a tenth of the view moves by itself"));
  EXPECT_GE(Summary(Output())["frames_with_motion"], kFrames / 2);
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

  Succeeded(Slam(Room(), Output("true")));
  Succeeded(Slam(copy, Output("shuffled")));
  EXPECT_EQ(ReadBytes(Output("true") + "/trajectory.txt"),
            ReadBytes(Output("shuffled") + "/trajectory.txt"));
  const nlohmann::json right = Summary(Output("true")), wrong = Summary(Output("shuffled"));
  EXPECT_EQ(right["digest"], wrong["digest"]);
  EXPECT_GT(wrong["ate_rmse_m"], right["ate_rmse_m"]);
}

// Only stamps change, and with them what the truth says: the sensor's latency is evaluated with the
// poses, and told beside it what they would be without.
TEST_F(SlamTool, StampsPosesWithTheMomentThatTheyHoldFor) {
  Succeeded(Slam(Room(), Output("plain")));
  const ProgramResult result = Succeeded(Slam(Room(), Output("late"), {"--latency_s=0.02"}));
  EXPECT_EQ(ReadBytes(Output("plain") + "/map.ply"), ReadBytes(Output("late") + "/map.ply"));
  for (const char* name : {"/trajectory.txt", "/trajectory_online.txt"}) {
    const Trajectory plain = ReadTumTrajectory(Output("plain") + name);
    const Trajectory late = ReadTumTrajectory(Output("late") + name);
    ASSERT_EQ(late.size(), plain.size());
    for (std::size_t i = 0; i < late.size(); ++i) {
      EXPECT_NEAR(late[i].stamp_s, plain[i].stamp_s - 0.02, 1.1e-6);  // 6 decimals
    }
  }
  const nlohmann::json plain = Summary(Output("plain")), late = Summary(Output("late"));
  EXPECT_EQ(plain["sensor_latency_s"], 0);
  EXPECT_EQ(plain["ate_without_latency_rmse_m"], plain["ate_rmse_m"]);
  EXPECT_EQ(late["sensor_latency_s"], 0.02);
  EXPECT_NEAR(late["ate_without_latency_rmse_m"], plain["ate_rmse_m"], 1e-9);
  EXPECT_GT(late["ate_rmse_m"], late["ate_without_latency_rmse_m"]);
  EXPECT_LE(late["ate_at_estimated_time_offset_rmse_m"], late["ate_rmse_m"]);
  EXPECT_THAT(result.out, HasSubstr("without the sensor's latency of 0.02 s"));
}

TEST_F(SlamTool, WritesTheTrajectoryOfAnImageWithYUpInItsOwnConvention) {
  const std::string mirrored = Simulate("mirrored", {"--image_y_up"});
  Succeeded(Slam(Room(), Output("down")));
  Succeeded(Slam(mirrored, Output("up")));
  // The same images of the same room: inside, all but the stamps is the same. Numbered frames do
  // not tell how fast the camera moved, which colours are weighted by.
  const std::vector<Surfel> down = ReadSurfelPly(Output("down") + "/map.ply");
  const std::vector<Surfel> up = ReadSurfelPly(Output("up") + "/map.ply");
  ASSERT_EQ(down.size(), up.size());
  for (std::size_t i = 0; i < down.size(); ++i) {
    ASSERT_EQ(down[i].position_in_world, up[i].position_in_world);
    ASSERT_EQ(down[i].normal_in_world, up[i].normal_in_world);
    ASSERT_EQ(down[i].confidence, up[i].confidence);
    ASSERT_EQ(down[i].last_seen, up[i].last_seen);
  }
  // Its own ground truth is met without a reflection ...
  std::string truth;
  for (const auto& entry : fs::directory_iterator(mirrored)) {
    if (entry.path().extension() == ".freiburg") truth = entry.path();
  }
  Succeeded(RunProgram("surfit_evaluate", {"--groundtruth=" + truth,
                                           "--estimate=" + Output("up") + "/trajectory.txt"}));
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
  const ProgramResult result = Succeeded(Slam(copy, Output()));
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
    Succeeded(program.Wait());
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
  Succeeded(program.Wait());
  const nlohmann::json summary = Summary(Output());
  EXPECT_EQ(summary["frames_total"], 6);
  EXPECT_EQ(summary["frames_tracked"], 6);
  EXPECT_EQ(summary["interrupted"], false);
}

TEST_F(SlamTool, FusesAlongGivenPoses) {
  Succeeded(Slam(Room(), Output(), {"--poses=groundtruth"}));
  // The files of truth and estimate have 9 decimals at least.
  EXPECT_LT(Summary(Output())["ate_rmse_m"], 1e-8);
}

TEST_F(SlamTool, BeginsAtTheInitialPose) {
  Succeeded(Slam(Room(), Output(), {"--initial_pose=1,2,3,0.6,0,0,0.8", "--last=2"}));
  for (const std::string& line : Lines(Output() + "/trajectory.txt")) {
    if (line[0] == '#') continue;
    EXPECT_THAT(line, EndsWith(" 1.000000000 2.000000000 3.000000000 0.600000000 0.000000000 "
                               "0.000000000 0.800000000"));
    break;
  }
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
      {{"--offered_fps=-30"}, "offered_fps is -30"},
      {{"--offered_fps=30", "--format=watch"}, "offered_fps is 30"},
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
      {{"--max_normal_angle_deg=-1"}, "--max_normal_angle_deg is -1, must be zero (off)"},
      {{"--output=/dev/null/x"}, "/dev/null/x"},
      {{"--trace=/dev/null/t"}, "/dev/null/t"},
      {{"--sequence=/nonexistent"}, "/nonexistent"},
      {{"--sequence="}, "sequence"},
      {{"surplus"}, "surplus"},
  };
  for (const auto& [flags, what] : cases) ExpectRefused(Slam(Room(), Output(), flags), what);
}

}  // namespace
}  // namespace surfit::testing
