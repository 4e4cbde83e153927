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

TEST_F(SlamTool, ClosesNoLoopsWithGivenPoses) {
  Succeeded(Slam(Room(), Output(), {"--poses=groundtruth"}));
  EXPECT_FALSE(fs::exists(Output() + "/loops.csv"));
  const ProgramResult result = Slam(Room(), Output(), {"--keep_places", "--poses=groundtruth"});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, Names("keep_places", "poses"));
}

// The focal length of the sensor is 131.25 px.
TEST_F(SlamTool, WarnsAboutImplausibleIntrinsics) {
  const std::string walk = Simulate("walk", {"--frames=150", "--downsample=4"});
  const ProgramResult right = Succeeded(Slam(walk, Output("right")));
  EXPECT_THAT(right.err, Not(HasWarning()));
  EXPECT_TRUE(Summary(Output("right"))["calibration_warning"].is_null());
  for (const std::string focal : {"82", "245"}) {
    const ProgramResult wrong =
        Slam(walk, Output(focal), {"--intrinsics=" + focal + "," + focal + ",79.9,59.9"});
    EXPECT_THAT(wrong.err, AllOf(HasWarning(), Names(walk + "/camera.yaml", 131.25)));
    EXPECT_TRUE(Summary(Output(focal))["calibration_warning"].is_string());
  }
}

// Adds a textured board 0.6 m in front of the camera. It occludes a quarter of the view after frame
// 7, and moves sideways.
void HoldABoardBeforeTheCamera(const std::string& sequence) {
  constexpr int kFrom = 8, kDepth = 3000;  // with 5000 counts per metre (TUM)
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

TEST_F(SlamTool, WarnsAboutMovingObjects) {
  const std::string copy = CopyOfRoom();
  HoldABoardBeforeTheCamera(copy);
  const ProgramResult still = Succeeded(Slam(Room(), Output("still")));
  EXPECT_THAT(still.err, Not(HasWarning()));
  EXPECT_EQ(Summary(Output("still"))["frames_with_motion"], 0);
  const ProgramResult moving = Slam(copy, Output());
  const int frames_with_motion = Summary(Output())["frames_with_motion"];
  EXPECT_GE(frames_with_motion, kFrames / 2);
  EXPECT_THAT(moving.err, HasWarning(frames_with_motion));
}

TEST_F(SlamTool, UsesGroundTruthOnlyForEvaluation) {
  const std::string copy = CopyOfRoom();
  std::vector<std::string> lines = Lines(copy + "/groundtruth.txt");
  // Permutes the poses of the ground truth.
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

// The latency changes only the timestamps, and so the matching ground-truth poses. The ATE without
// latency is reported as well.
TEST_F(SlamTool, PoseStampsSubtractTheLatency) {
  Succeeded(Slam(Room(), Output("plain")));
  RgbdCamera camera = ReadCameraYaml(Room() + "/camera.yaml");
  camera.latency_s = 0.02;
  WriteCameraYaml(camera, Output("late.yaml"));
  const ProgramResult result =
      Succeeded(Slam(Room(), Output("late"), {"--camera=" + Output("late.yaml")}));
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
  EXPECT_THAT(result.out, Names(0.02));
}

TEST_F(SlamTool, WritesMirroredTrajectoryInItsOwnConvention) {
  const std::string mirrored = Simulate("mirrored", {"--format=icl_nuim"});
  Succeeded(Slam(Room(), Output("down")));
  Succeeded(Slam(mirrored, Output("up")));
  // The images are equal, so the maps are equal up to the mirror. Colours may differ: numbered
  // frames have different timestamps, and colour weights depend on the camera velocity. Stereo uses
  // colour poses, which depend on the velocity as well.
  const auto measured = [&](const char* run) {
    std::vector<Surfel> surfels = ReadSurfelPly(Output(run) + "/map.ply");
    surfels.erase(std::remove_if(surfels.begin(), surfels.end(),
                                 [](const Surfel& surfel) { return surfel.from_stereo; }),
                  surfels.end());
    return surfels;
  };
  const std::vector<Surfel> down = measured("down"), up = measured("up");
  ASSERT_EQ(down.size(), up.size());
  for (std::size_t i = 0; i < down.size(); ++i) {
    ASSERT_EQ(down[i].position_in_world, up[i].position_in_world);
    ASSERT_EQ(down[i].normal_in_world, up[i].normal_in_world);
    ASSERT_EQ(down[i].confidence, up[i].confidence);
    ASSERT_EQ(down[i].last_seen, up[i].last_seen);
  }
  // The trajectory matches its own ground truth without a reflection ...
  std::string truth;
  for (const auto& entry : fs::directory_iterator(mirrored)) {
    if (entry.path().extension() == ".freiburg") truth = entry.path();
  }
  Succeeded(RunProgram("surfit_evaluate", {"--groundtruth=" + truth,
                                           "--estimate=" + Output("up") + "/trajectory.txt"}));
  // ... with the ATE of the original sequence. Files have 9 decimals.
  EXPECT_NEAR(Summary(Output("up"))["ate_rmse_m"], Summary(Output("down"))["ate_rmse_m"], 1e-6);
  EXPECT_NE(ReadBytes(Output("down") + "/trajectory.txt"),
            ReadBytes(Output("up") + "/trajectory.txt"));
}

TEST_F(SlamTool, SkipsAndCountsUnreadableFrames) {
  const std::string copy = CopyOfRoom();
  std::vector<fs::path> depths;
  for (const auto& entry : fs::directory_iterator(copy + "/depth")) depths.push_back(entry.path());
  std::sort(depths.begin(), depths.end());
  fs::resize_file(depths[10], fs::file_size(depths[10]) / 2);
  fs::remove(depths[20]);
  const ProgramResult result = Succeeded(Slam(copy, Output()));
  EXPECT_THAT(result.err, Names(depths[10].filename().string()));
  EXPECT_THAT(result.err, Names(depths[20].filename().string()));
  const nlohmann::json summary = Summary(Output());
  EXPECT_EQ(summary["frames_total"], kFrames);
  EXPECT_EQ(summary["frames_skipped"], 2);
  EXPECT_EQ(summary["frames_tracked"], kFrames - 2);
  EXPECT_DOUBLE_EQ(summary["ate_coverage"], (kFrames - 2.0) / kFrames);
  EXPECT_EQ(CountPoses(Output() + "/trajectory.txt"), kFrames - 2);
}

TEST_F(SlamTool, WritesCompleteResultsAfterSigintAndSigterm) {
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

// Frames in a watched folder. The last frames are written after the first frame is tracked.
TEST_F(SlamTool, ReadsAWatchedFolder) {
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
  // Ground truth and estimate have at least 9 decimals.
  EXPECT_LT(Summary(Output())["ate_rmse_m"], 1e-8);
}

TEST_F(SlamTool, StartsAtTheInitialPose) {
  Succeeded(Slam(Room(), Output(), {"--initial_pose=1,2,3,0.6,0,0,0.8", "--last=2", "--norefine"}));
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

// A folder with three depth images, and a camera whose field of view does not depend on the size.
std::string WriteDepth(const std::string& folder, const cv::Mat& depth) {
  fs::create_directories(folder + "/depth");
  for (int i = 0; i < 3; ++i) {
    cv::imwrite(folder + "/depth/" + std::to_string(i) + ".png", depth + cv::Scalar(i));
  }
  std::ofstream(folder + "/camera.yaml")
      << "depth_camera: { width: " << depth.cols << ", height: " << depth.rows
      << ", fx: " << 0.9 * depth.cols << ", fy: " << 0.9 * depth.cols
      << ", cx: " << 0.5 * depth.cols - 0.5 << ", cy: " << 0.5 * depth.rows - 0.5
      << " }\ndepth_units_per_metre: 1000\n";
  return folder;
}

TEST_F(SlamTool, NamesTheReasonIfNoFrameCanBeginTheMap) {
  for (const cv::Size size : {cv::Size(10, 7), cv::Size(8, 8)}) {
    const cv::Mat depth(size, CV_16UC1, cv::Scalar(1000));
    const std::string name = std::to_string(size.width);
    const ProgramResult result = Slam(WriteDepth(Output(name), depth), Output(name + "_run"));
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_THAT(result.err, HasWarning(size.width, size.height, 200, "100 %", "normal"));
  }
}

TEST_F(SlamTool, NamesMissingRowsIfNoFrameCanBeginTheMap) {
  const std::string copy = CopyOfRoom();
  for (const auto& entry : fs::directory_iterator(copy + "/depth")) {
    cv::Mat depth = cv::imread(entry.path(), cv::IMREAD_UNCHANGED);
    for (int v = 1; v < depth.rows; v += 2) depth.row(v) = 0;
    cv::imwrite(entry.path(), depth);
  }
  const ProgramResult result = Slam(copy, Output());
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasWarning(160, 120));
  EXPECT_THAT(result.err, HasSubstr("needs depth in the rows and columns beside its pixel"));
}

// Covers the left half of each depth image with a box at a distance of 0.3 m, which moves with the
// camera.
TEST_F(SlamTool, NamesABoxThatCoversHalfOfTheView) {
  const std::string room = Simulate("half", {"--sensor=ideal", "--downsample=2", "--frames=12"});
  for (const auto& entry : fs::directory_iterator(room + "/depth")) {
    cv::Mat depth = cv::imread(entry.path(), cv::IMREAD_UNCHANGED);
    depth.colRange(0, depth.cols / 2) = 1500;
    cv::imwrite(entry.path(), depth);
  }
  const ProgramResult result = Succeeded(Slam(room, Output(), {"--nofinal_map"}));
  EXPECT_THAT(result.err, HasSubstr("moving objects cover more than 10 % of the view"));
  EXPECT_EQ(Summary(Output())["frames_tracked"], 12);
}

// Depth in whole millimetres, as most recordings have it.
TEST_F(SlamTool, WarnsOfNothingInAStaticExactRoom) {
  const std::string room =
      Simulate("exact", {"--seed=4", "--frames=40", "--sensor=ideal", "--downsample=2"});
  EXPECT_THAT(Succeeded(Slam(room, Output("fine"), {"--nofinal_map"})).err, Not(HasWarning()));
  for (const auto& entry : fs::directory_iterator(room + "/depth")) {
    cv::Mat depth = cv::imread(entry.path(), cv::IMREAD_UNCHANGED);
    depth.convertTo(depth, CV_16U, 0.2);  // 5000 units per metre before
    cv::imwrite(entry.path(), depth);
  }
  const ProgramResult result =
      Succeeded(Slam(room, Output(), {"--depth_scale=1000", "--nofinal_map"}));
  EXPECT_THAT(result.err, Not(HasWarning("motion")));
  EXPECT_LT(Summary(Output())["ate_rmse_m"], 0.0015);
}

TEST_F(SlamTool, RejectsBadInputInOneLine) {
  const RefusedFlags cases = {
      {{"--nonsense"}, {"nonsense"}},
      {{"--threads=0"}, {"threads", "0"}},
      {{"--threads=abc"}, {"threads", "abc"}},
      {{"--offered_fps=-30"}, {"offered_fps", "-30"}},
      {{"--offered_fps=30", "--format=watch"}, {"offered_fps", "30"}},
      {{"--solver=magic"},
       {"closed_form_ldlt", "closed_form_lu", "closed_form_qr", "svd", "ceres", "ceres_per_point",
        "tiny"}},
      {{"--residual=magic"}, {"point_to_plane"}},
      {{"--association=magic"}, {"projective"}},
      {{"--tracking=magic"}, {"frame_to_model", "frame_to_frame"}},
      {{"--poses=magic"}, {"track", "groundtruth"}},
      {{"--initial_pose=1,2"}, {"initial_pose", "1,2"}},
      {{"--downsample=17"}, {"downsample", "17"}},
      {{"--max_depth_m=-1"}, {"max_depth_m", "-1"}},
      {{"--format=magic"}, {"format", "magic"}},
      {{"--camera=magic"}, {"camera", "magic"}},
      {{"--first=9999"}, {"first", "9999"}},
      {{"--max_map_points=-1"}, {"max_map_points", "-1"}},
      {{"--max_normal_angle_deg=-1"}, {"--max_normal_angle_deg", "-1"}},
      {{"--output=/dev/null/x"}, {"/dev/null/x"}},
      {{"--trace=/dev/null/t"}, {"/dev/null/t"}},
      {{"--sequence=/nonexistent"}, {"/nonexistent"}},
      {{"--sequence="}, {"sequence"}},
      {{"surplus"}, {"surplus"}},
  };
  for (const auto& [flags, names] : cases)
    ExpectRefused(Slam(Room(), Output(), flags), NamesMatcher(names));
}

}  // namespace
}  // namespace surfit::testing
