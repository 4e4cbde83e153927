// Results and messages of surfit_slam after faults of its environment.
#include <gmock/gmock.h>
#include <sys/stat.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <thread>

#include "surfit/io/point_cloud.h"
#include "surfit/io/trajectory_files.h"
#include "testing/matchers.h"
#include "tools/slam_tool.h"

namespace surfit::testing {
namespace {

namespace fs = std::filesystem;

class SlamTrouble : public SlamTool {
 protected:
  // Shell command of a run.
  std::string SlamCommand(const std::string& flags = "") const {
    return "$tools/surfit_slam --sequence=" + Room() + " --output=" + Output() + " --nopictures " +
           flags;
  }

  static std::vector<fs::path> DepthImages(const std::string& sequence) {
    std::vector<fs::path> images;
    for (const auto& entry : fs::directory_iterator(sequence + "/depth")) {
      images.push_back(entry.path());
    }
    std::sort(images.begin(), images.end());
    return images;
  }

  void ExpectWhole(const std::string& output) const {
    const nlohmann::json summary = Summary(output);
    EXPECT_EQ(ReadTumTrajectory(output + "/trajectory.txt").size(), summary["frames_tracked"]);
    EXPECT_EQ(Lines(output + "/frames.csv").size(), 1 + summary["frames_total"].get<int>());
    EXPECT_EQ(ReadPly(output + "/map.ply").points.size(), summary["map_points"]);
  }
};

void WaitForPoses(const std::string& output, int count) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (!fs::exists(output + "/trajectory.txt") ||
         CountPoses(output + "/trajectory.txt") < count) {
    ASSERT_LT(std::chrono::steady_clock::now(), deadline);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

TEST_F(SlamTrouble, WritesNoProgressIntoFilesIfStreamsAreClosed) {
  for (const char* closed : {"<&-", ">&-", "2>&-", "<&- >&- 2>&-"}) {
    EXPECT_EQ(RunShell(SlamCommand(closed)).exit_code, 0) << closed;
    ExpectWhole(Output());
    EXPECT_EQ(Summary(Output())["frames_tracked"], kFrames) << closed;
  }
}

TEST_F(SlamTrouble, ContinuesAfterAPipeIsClosed) {
  const ProgramResult result =
      RunShell("{ " + SlamCommand() + " 2>&1; echo $? > " + (own_ / "code") + "; } | true");
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(ReadBytes(own_ / "code"), "1\n");  // nobody reads its output
  ExpectWhole(Output());
  EXPECT_EQ(Summary(Output())["frames_tracked"], kFrames);
}

TEST_F(SlamTrouble, WritesCompleteResultsAfterSighup) {
  RunningProgram program("surfit_slam", {"--sequence=" + EndlessRoom(), "--output=" + Output(),
                                         "--nopictures", "--threads=1"});
  WaitForPoses(Output(), 2);
  program.Signal(SIGHUP);
  Succeeded(program.Wait());
  ExpectWhole(Output());
  EXPECT_EQ(Summary(Output())["interrupted"], true);
}

TEST_F(SlamTrouble, ContinuesWithoutATerminalWithNohup) {
  const ProgramResult result =
      RunShell("trap '' HUP; " + SlamCommand() + " & kill -HUP $!; wait $!");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(Summary(Output())["interrupted"], false);
}

TEST_F(SlamTrouble, RejectsAFolderOfARunningProcess) {
  RunningProgram program("surfit_slam", {"--sequence=" + EndlessRoom(), "--output=" + Output(),
                                         "--nopictures", "--threads=1"});
  WaitForPoses(Output(), 2);
  ExpectRefused(Slam(Room(), Output()), Output());
  program.Signal(SIGTERM);
  Succeeded(program.Wait());
  ExpectWhole(Output());
  Succeeded(Slam(Room(), Output()));
}

TEST_F(SlamTrouble, ReusesTheFolderOfAKilledRun) {
  {
    RunningProgram program("surfit_slam", {"--sequence=" + EndlessRoom(), "--output=" + Output(),
                                           "--nopictures", "--threads=1"});
    WaitForPoses(Output(), 2);
  }  // SIGKILL
  const ProgramResult result = Succeeded(Slam(Room(), Output()));
  EXPECT_THAT(result.err, HasWarning(Output()));
  ExpectWhole(Output());
}

// The map is the only file above the size limit.
TEST_F(SlamTrouble, WritesOtherResultsIfTheMapIsTooLarge) {
  const ProgramResult result = RunShell("ulimit -f 64; " + SlamCommand());
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, AllOf(HasError(Output() + "/map.ply"), HasSubstr("File too large")));
  EXPECT_FALSE(fs::exists(Output() + "/map.ply"));
  const nlohmann::json summary = Summary(Output());
  EXPECT_THAT(summary["failure"].get<std::string>(), Names("map.ply"));
  EXPECT_EQ(summary["frames_tracked"], kFrames);
  EXPECT_EQ(CountPoses(Output() + "/trajectory.txt"), kFrames);
  EXPECT_TRUE(fs::exists(Output() + "/poses.json"));
  for (const auto& entry : fs::directory_iterator(Output())) {
    EXPECT_EQ(entry.path().string().find("partial"), std::string::npos) << entry.path();
  }
}

TEST_F(SlamTrouble, WritesOnlyCompleteLinesOnAFullDisk) {
  const ProgramResult result = RunShell("ulimit -f 2; " + SlamCommand());
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("File too large"));
  const std::string text = ReadBytes(Output() + "/trajectory.txt");
  EXPECT_EQ(text.back(), '\n');
  EXPECT_GT(ReadTumTrajectory(Output() + "/trajectory.txt").size(), 2u);
}

TEST_F(SlamTrouble, FailsIfMostFramesAreLost) {
  const std::string copy = CopyOfRoom(), blank = own_.path() + "/blank.png";
  cv::imwrite(blank, cv::Mat(120, 160, CV_16UC1, cv::Scalar(0)));
  const std::vector<fs::path> depths = DepthImages(copy);
  for (std::size_t i = 10; i < depths.size(); ++i) {
    fs::copy_file(blank, depths[i], fs::copy_options::overwrite_existing);
  }
  const ProgramResult result = Slam(copy, Output());
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, AllOf(ContainsRegex("(^|\n)failed: "), Names(10, 24)));
  ExpectWhole(Output());
}

TEST_F(SlamTrouble, SummarisesManyMissingFiles) {
  const std::string copy = CopyOfRoom();
  const std::vector<fs::path> depths = DepthImages(copy);
  for (std::size_t i = 8; i < depths.size(); ++i) fs::remove(depths[i]);
  const ProgramResult result = Slam(copy, Output());
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, Names(13));
  EXPECT_THAT(result.err, Names(depths[8].filename().string()));
  EXPECT_THAT(result.err, Not(Names(depths[20].filename().string())));
}

TEST_F(SlamTrouble, SkipsPipesAndDevices) {
  const std::string copy = CopyOfRoom();
  const std::vector<fs::path> depths = DepthImages(copy);
  fs::remove(depths[5]);
  ASSERT_EQ(mkfifo(depths[5].c_str(), 0600), 0);
  fs::remove(depths[6]);
  fs::create_symlink("/dev/zero", depths[6]);
  const ProgramResult result = Succeeded(Slam(copy, Output()));
  EXPECT_THAT(result.err, Names(depths[5].string()));
  EXPECT_EQ(Summary(Output())["frames_skipped"], 2);
}

TEST_F(SlamTrouble, RejectsOverwritingItsInput) {
  const std::string copy = CopyOfRoom(), camera = ReadBytes(copy + "/camera.yaml");
  ExpectRefused(Slam(copy, copy), "--output", copy, "--sequence");
  EXPECT_EQ(ReadBytes(copy + "/camera.yaml"), camera);
  Succeeded(Slam(copy, Output()));
  WriteBytes(Output() + "/camera.yaml", camera);
  ExpectRefused(Slam(copy, Output(), {"--camera=" + Output() + "/camera.yaml"}),
                Output() + "/camera.yaml");
  EXPECT_EQ(ReadBytes(Output() + "/camera.yaml"), camera);
}

// An image with a duplicate number must not stop the run.
TEST_F(SlamTrouble, WatchesAFolderWithADuplicateImage) {
  const TempFolder live;
  for (const char* folder : {"depth", "rgb"}) {
    fs::create_directory(live.path() + "/" + folder);
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(Room() + "/" + folder))
      files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    for (int i = 0; i < 4; ++i)
      fs::copy(files[i], live.path() + "/" + folder + "/" + std::to_string(i) + ".png");
  }
  live.Write("depth/-1.png", "no image at all");
  fs::copy(Room() + "/camera.yaml", live / "camera.yaml");
  live.Write("done", "");
  const ProgramResult result = Succeeded(Slam(live.path(), Output(), {"--format=watch"}));
  EXPECT_THAT(result.err, Names("-1.png", "1.png", 1));
  EXPECT_EQ(Summary(Output())["frames_tracked"], 4);
  ExpectWhole(Output());
}

}  // namespace
}  // namespace surfit::testing
