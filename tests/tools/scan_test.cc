// Whole scans, by Snakemake.
#include <gmock/gmock.h>
#include <signal.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "testing/matchers.h"
#include "testing/mutations.h"
#include "testing/run_program.h"
#include "testing/temp_folder.h"

namespace surfit::testing {
namespace {

namespace fs = std::filesystem;

bool HasSnakemake() { return RunShell("command -v snakemake").exit_code == 0; }

// Kinect's frames of a room, in three fragments.
class ScanTool : public ::testing::Test {
 protected:
  static constexpr int kFrames = 36;

  static void SetUpTestSuite() {
    folder_ = new TempFolder;
    Succeeded(RunProgram("surfit_simulate", {"--output=" + Sequence(), "--downsample=8",
                                             "--frames=" + std::to_string(kFrames)}));
    whole_ = folder_->path() + "/whole";
    if (!HasSnakemake()) return;
    const ProgramResult result = Succeeded(RunProgram("surfit_scan", Flags(whole_, {"--cores=1"})));
    EXPECT_THAT(result.out, HasSubstr("36 of 36 frames have a pose"));
  }
  static void TearDownTestSuite() { delete folder_; }
  void SetUp() override {
    if (!HasSnakemake()) GTEST_SKIP() << "no snakemake here";
  }

  static std::string Sequence() { return folder_->path() + "/room"; }
  static std::vector<std::string> Flags(const std::string& scan,
                                        const std::vector<std::string>& more = {}) {
    std::vector<std::string> flags = {
        "--sequence=" + Sequence(), "--output=" + scan, "--fragment_frames=16",
        "--overlap_frames=6",       "--tile_m=10",      "--camera_frames=0"};
    flags.insert(flags.end(), more.begin(), more.end());
    return flags;
  }
  static nlohmann::json Summary(const std::string& scan) {
    return nlohmann::json::parse(ReadBytes(scan + "/summary.json"));
  }
  static std::string Digest(const std::string& scan) { return Summary(scan)["digest"]; }

  static TempFolder* folder_;
  static std::string whole_;  // a scan by one core
};
TempFolder* ScanTool::folder_ = nullptr;
std::string ScanTool::whole_;

TEST_F(ScanTool, GivesOneTrajectoryAndTilesAndDoesNothingAgain) {
  const nlohmann::json summary = Summary(whole_);
  EXPECT_EQ(summary["fragments"], 3);
  EXPECT_EQ(summary["frames"], kFrames);
  EXPECT_TRUE(summary["failed"].empty());
  EXPECT_LT(summary["ate_rmse_m"].get<double>(), 0.02);
  EXPECT_GT(summary["tiles"], 1);
  EXPECT_TRUE(fs::exists(whole_ + "/report.html"));
  // Given again, with the product of one job gone, that alone and what comes of it is done again.
  const auto time = fs::last_write_time(whole_ + "/jobs/fragment_0000.json");
  fs::remove(whole_ + "/fragments/0001/places.bin");
  Succeeded(RunProgram("surfit_scan", Flags(whole_, {"--cores=2"})));
  EXPECT_TRUE(fs::exists(whole_ + "/fragments/0001/places.bin"));
  EXPECT_EQ(Digest(whole_), summary["digest"]);
  EXPECT_EQ(fs::last_write_time(whole_ + "/jobs/fragment_0000.json"), time);
}

// Kills one of the processes that work in the folder: a program, its job.py or all of Snakemake.
bool KillOneIn(const fs::path& folder, Random* random) {
  std::vector<pid_t> there;
  for (const auto& entry : fs::directory_iterator("/proc")) {
    const std::string name = entry.path().filename();
    std::error_code error;
    if (name.find_first_not_of("0123456789") != std::string::npos) continue;
    if (fs::read_symlink(entry.path() / "cwd", error) == folder) there.push_back(std::stoi(name));
  }
  return !there.empty() && kill(there[Below(there.size(), random)], SIGKILL) == 0;
}

TEST_F(ScanTool, HasTheSameDigestWhateverWasKilledOnTheWay) {
  const TempFolder folder;
  const std::string scan = folder.path() + "/scan";
  fs::create_directories(scan);
  int killed = 0;
  Random random(5);
  for (int attempt = 0; attempt < 20; ++attempt) {
    RunningProgram running("surfit_scan", Flags(scan));
    for (int i = 0; i < 3 && attempt < 5 && running.IsRunning(); ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(500 + Below(1000, &random)));
      killed += KillOneIn(fs::canonical(scan), &random) ? 1 : 0;
    }
    if (running.Wait().exit_code == 0) break;
  }
  EXPECT_GT(killed, 5);
  EXPECT_EQ(Digest(scan), Digest(whole_));
}

TEST_F(ScanTool, AFragmentThatFailsCostsOnlyItself) {
  const TempFolder folder;
  const std::string broken = folder.path() + "/broken", scan = folder.path() + "/scan";
  fs::copy(Sequence(), broken, fs::copy_options::recursive);
  // All frames that only the last fragment has are no images.
  constexpr int kLeft = 26;
  std::vector<fs::path> images(fs::directory_iterator(broken + "/depth"), {});
  std::sort(images.begin(), images.end());
  for (std::size_t i = kLeft; i < images.size(); ++i) WriteBytes(images[i], "no image");
  std::vector<std::string> flags = Flags(scan);
  flags[0] = "--sequence=" + broken;
  // Nobody else may scan into the folder meanwhile.
  RunningProgram first("surfit_scan", flags);
  for (int i = 0; i < 100 && !fs::exists(scan + "/jobs"); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  const ProgramResult second = RunProgram("surfit_scan", flags);
  EXPECT_EQ(second.exit_code, 1);
  EXPECT_THAT(second.err, HasSubstr("is being worked in by another process"));
  const ProgramResult result = Succeeded(first.Wait());
  const nlohmann::json summary = Summary(scan);
  ASSERT_EQ(summary["failed"].size(), 1u) << summary;
  EXPECT_THAT(summary["failed"][0].get<std::string>(), HasSubstr("fragment_0002: "));
  EXPECT_THAT(result.err, HasSubstr("warning: fragment_0002: "));
  EXPECT_EQ(summary["frames"], kLeft);
  EXPECT_THAT(ReadBytes(scan + "/report.html"), HasSubstr("fragment_0002: "));
  // The images come after all.
  fs::copy(Sequence(), broken, fs::copy_options::recursive | fs::copy_options::overwrite_existing);
  flags.push_back("--retry_failed");
  Succeeded(RunProgram("surfit_scan", flags));
  EXPECT_EQ(Summary(scan)["frames"], kFrames);
}

// A part of the room's frames, as a recording of its own.
void KeepFrames(const std::string& sequence, int first, int last) {
  std::istringstream rows(ReadBytes(sequence + "/associations.txt"));
  std::string row, kept;
  for (int i = 0; std::getline(rows, row); ++i) {
    if (i >= first && i <= last) kept += row + "\n";
  }
  WriteBytes(sequence + "/associations.txt", kept);
}

TEST_F(ScanTool, JoinsRecordingsOfOnePlace) {
  const TempFolder folder;
  const std::string scan = folder.path() + "/scan";
  const std::string a = folder.path() + "/a", b = folder.path() + "/b";
  for (const std::string& part : {a, b}) fs::copy(Sequence(), part, fs::copy_options::recursive);
  KeepFrames(a, 0, 23);
  KeepFrames(b, 12, kFrames - 1);
  const std::vector<std::string> flags = Flags(scan, {"--sequence=" + a, "--sequence=" + b});
  const ProgramResult result =
      Succeeded(RunProgram("surfit_scan", {flags.begin() + 1, flags.end()}));
  EXPECT_THAT(result.out, HasSubstr("48 of 48 frames have a pose"));
  const nlohmann::json summary = Summary(scan);
  EXPECT_EQ(summary["fragments"], 4);
  ASSERT_EQ(summary["recordings"].size(), 2u);
  for (const nlohmann::json& recording : summary["recordings"]) {
    EXPECT_EQ(recording["frames"], 24);
    EXPECT_LT(recording["ate_rmse_m"].get<double>(), 0.02);
  }
  EXPECT_GT(summary["links_accepted"], 0);
  EXPECT_LT(summary["ate_rmse_m"].get<double>(), 0.03);
  EXPECT_TRUE(fs::exists(scan + "/trajectory_0.txt") && fs::exists(scan + "/trajectory_1.txt"));
  EXPECT_THAT(ReadBytes(scan + "/report.html"), HasSubstr("and 1 more"));
}

TEST_F(ScanTool, SaysWhatIsWrong) {
  const TempFolder folder;
  const std::string scan = folder.path() + "/scan";
  ExpectRefused(RunProgram("surfit_scan", Flags(scan, {"--overlap_frames=20"})), "overlap_frames");
  ExpectRefused(RunProgram("surfit_scan", Flags(scan, {"--sequence=" + folder.path() + "/none"})),
                "none");
  ExpectRefused(RunProgram("surfit_scan", Flags(scan, {"--profile=nowhere"})),
                "profile is 'nowhere'");
  ExpectRefused(RunProgram("surfit_scan_graph", {"--scan=" + scan, "--output=" + scan + "/graph"}),
                "plan.json");
}

}  // namespace
}  // namespace surfit::testing
