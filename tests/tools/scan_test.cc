// Complete scans with Snakemake.
#include <gmock/gmock.h>
#include <signal.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "surfit/evaluation/map_error.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/io/point_cloud.h"
#include "testing/matchers.h"
#include "testing/mutations.h"
#include "testing/run_program.h"
#include "testing/temp_folder.h"

namespace surfit::testing {
namespace {

namespace fs = std::filesystem;

bool HasSnakemake() { return RunShell("command -v snakemake").exit_code == 0; }

// Simulated Kinect frames of a room, in three fragments.
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
    EXPECT_THAT(result.out, Names(36));
  }
  static void TearDownTestSuite() { delete folder_; }
  void SetUp() override {
    if (!HasSnakemake()) GTEST_SKIP() << "Snakemake is not installed";
  }

  static std::string Sequence() { return folder_->path() + "/room"; }
  static std::vector<std::string> Flags(const std::string& scan,
                                        const std::vector<std::string>& more = {}) {
    std::vector<std::string> flags = {"--sequence=" + Sequence(),
                                      "--output=" + scan,
                                      "--fragment_frames=16,6",
                                      "--tile_m=10",
                                      "--nocalibrate",
                                      "--nopictures"};
    flags.insert(flags.end(), more.begin(), more.end());
    return flags;
  }
  static nlohmann::json Summary(const std::string& scan) {
    return nlohmann::json::parse(ReadBytes(scan + "/summary.json"));
  }
  static std::string Digest(const std::string& scan) { return Summary(scan)["digest"]; }

  static TempFolder* folder_;
  static std::string whole_;  // a scan with one core
};
TempFolder* ScanTool::folder_ = nullptr;
std::string ScanTool::whole_;

TEST_F(ScanTool, WritesTrajectoryAndTilesAndRepeatsNoCompletedJob) {
  const nlohmann::json summary = Summary(whole_);
  EXPECT_EQ(summary["fragments"], 3);
  EXPECT_EQ(summary["frames"], kFrames);
  EXPECT_TRUE(summary["failed"].empty());
  EXPECT_LT(summary["ate_rmse_m"].get<double>(), 0.02);
  EXPECT_GT(summary["tiles"], 1);
  EXPECT_TRUE(fs::exists(whole_ + "/report.html"));
  EXPECT_FALSE(fs::exists(whole_ + "/map_color.png"));
  // After an output of one job is removed, the same command repeats only this job and its
  // dependents, and runs newly requested jobs.
  const auto time = fs::last_write_time(whole_ + "/jobs/fragment_0000.json");
  fs::remove(whole_ + "/fragments/0001/places.bin");
  Succeeded(RunProgram("surfit_scan", Flags(whole_, {"--cores=2", "--pictures"})));
  EXPECT_TRUE(fs::exists(whole_ + "/map_color.png"));
  EXPECT_TRUE(fs::exists(whole_ + "/fragments/0001/places.bin"));
  EXPECT_EQ(Digest(whole_), summary["digest"]);
  EXPECT_EQ(fs::last_write_time(whole_ + "/jobs/fragment_0000.json"), time);
}

// A folder for the front of PATH with a python3 that runs the jobs. It starts jobs in random order,
// and kills every second job once: either its program or the process that runs it.
class UnreliablePython {
 public:
  explicit UnreliablePython(int order) : order_(order) {
    const std::string script = folder_ / "python3";
    WriteBytes(script, R"(#!/bin/bash
here=$(dirname "$0")
PATH=${PATH#"$here:"}
job=$(basename "$2")
number=$(cksum <<<"$job $ORDER" | cut -d ' ' -f 1)
sleep 0.$((number % 10))
if ((number / 10 % 2 == 0)) || ! mkdir "$here/$job"; then
  python3 "$@" || exit
else
  python3 "$@" &
  sleep 0.0$((number / 100 % 10))
  ((number % 2)) && pkill -KILL --parent $! || kill -KILL $!
  wait $! || { echo "$job" >>"$here/killed"; exit 1; }
fi
echo "$job" >>"$here/done"
)");
    fs::permissions(script, fs::perms::owner_all);
    WriteBytes(folder_ / "config.yaml", "keep-going: true\ncores: 3\n");
  }

  ProgramResult Scan(const std::vector<std::string>& flags) const {
    std::string command = "export ORDER=" + std::to_string(order_) + " PATH='" + folder_.path() +
                          "':$PATH\nexec $tools/surfit_scan --profile='" + folder_.path() + "'";
    for (const std::string& flag : flags) command += " '" + flag + "'";
    return RunShell(command);
  }
  // Names of jobs in the order of their end.
  std::vector<std::string> Done() const { return Lines("done"); }
  std::vector<std::string> Killed() const { return Lines("killed"); }

 private:
  std::vector<std::string> Lines(const std::string& name) const {
    std::istringstream file(ReadBytes(folder_ / name));
    std::vector<std::string> lines;
    for (std::string line; std::getline(file, line);) lines.push_back(line);
    return lines;
  }

  TempFolder folder_;
  int order_;
};

TEST_F(ScanTool, DigestDoesNotDependOnOrderOrKilledJobs) {
  std::vector<std::vector<std::string>> orders;
  for (const int order : {1, 2}) {
    const TempFolder folder;
    const std::string scan = folder.path() + "/scan";
    const UnreliablePython python(order);
    ProgramResult result = python.Scan(Flags(scan));
    EXPECT_EQ(result.exit_code, 1) << "nothing was killed";
    EXPECT_THAT(result.err, HasError(scan + "/jobs"));
    for (int i = 0; i < 5 && result.exit_code != 0; ++i) result = python.Scan(Flags(scan));
    Succeeded(result);
    EXPECT_EQ(Digest(scan), Digest(whole_));
    // Each job is completed once.
    std::vector<std::string> done = python.Done();
    orders.push_back(done);
    std::sort(done.begin(), done.end());
    EXPECT_EQ(std::unique(done.begin(), done.end()), done.end());
    EXPECT_GE(3 * python.Killed().size(), done.size());
  }
  EXPECT_NE(orders[0], orders[1]);
}

// Kills one process of the scan: a program, its job.py, or Snakemake with its children.
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

TEST_F(ScanTool, DigestDoesNotDependOnKilledProcesses) {
  const TempFolder folder;
  const std::string scan = folder.path() + "/scan";
  fs::create_directories(scan);
  constexpr int kKills = 8;
  int killed = 0;
  Random random(5);
  for (int attempt = 0; attempt < 20; ++attempt) {
    RunningProgram running("surfit_scan", Flags(scan));
    while (killed < kKills && running.IsRunning()) {
      std::this_thread::sleep_for(std::chrono::milliseconds(100 + Below(300, &random)));
      killed += KillOneIn(fs::canonical(scan), &random) ? 1 : 0;
    }
    if (running.Wait().exit_code == 0) break;
  }
  EXPECT_EQ(killed, kKills);
  EXPECT_EQ(Digest(scan), Digest(whole_));
}

TEST_F(ScanTool, ContinuesWithoutAFailedFragment) {
  const TempFolder folder;
  const std::string broken = folder.path() + "/broken", scan = folder.path() + "/scan";
  fs::copy(Sequence(), broken, fs::copy_options::recursive);
  // Images that only the last fragment has are damaged or missing.
  constexpr int kLeft = 26;
  std::vector<fs::path> images(fs::directory_iterator(broken + "/depth"), {});
  std::sort(images.begin(), images.end());
  for (std::size_t i = kLeft; i < images.size(); ++i) {
    WriteBytes(images[i], "no image");
    if (i % 2 == 0) fs::remove(images[i]);
  }
  std::vector<std::string> flags = Flags(scan);
  flags[0] = "--sequence=" + broken;
  // A second scan into the same folder is rejected.
  RunningProgram first("surfit_scan", flags);
  for (int i = 0; i < 100 && !fs::exists(scan + "/jobs"); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  const ProgramResult second = RunProgram("surfit_scan", flags);
  EXPECT_EQ(second.exit_code, 1);
  EXPECT_THAT(second.err, HasError(scan));
  const ProgramResult result = Succeeded(first.Wait());
  const nlohmann::json summary = Summary(scan);
  ASSERT_EQ(summary["failed"].size(), 1u) << summary;
  EXPECT_THAT(summary["failed"][0].get<std::string>(), Names("fragment_0002"));
  EXPECT_THAT(result.err, HasWarning("fragment_0002"));
  EXPECT_EQ(summary["frames"], kLeft);
  EXPECT_THAT(ReadBytes(scan + "/report.html"), Names("fragment_0002"));
  // The images are added.
  fs::copy(Sequence(), broken, fs::copy_options::recursive | fs::copy_options::overwrite_existing);
  flags.push_back("--retry_failed");
  Succeeded(RunProgram("surfit_scan", flags));
  EXPECT_EQ(Summary(scan)["frames"], kFrames);
}

// Keeps only some frames of the recording.
void KeepFrames(const std::string& sequence, int first, int last) {
  std::istringstream rows(ReadBytes(sequence + "/associations.txt"));
  std::string row, kept;
  for (int i = 0; std::getline(rows, row); ++i) {
    if (i >= first && i <= last) kept += row + "\n";
  }
  WriteBytes(sequence + "/associations.txt", kept);
}

TEST_F(ScanTool, JoinsRecordingsOfOneRoom) {
  const TempFolder folder;
  const std::string scan = folder.path() + "/scan";
  const std::string a = folder.path() + "/a", b = folder.path() + "/b";
  for (const std::string& part : {a, b}) fs::copy(Sequence(), part, fs::copy_options::recursive);
  KeepFrames(a, 0, 23);
  KeepFrames(b, 12, kFrames - 1);
  const std::vector<std::string> flags = Flags(scan, {"--sequence=" + a, "--sequence=" + b});
  const ProgramResult result =
      Succeeded(RunProgram("surfit_scan", {flags.begin() + 1, flags.end()}));
  EXPECT_THAT(result.out, Names(48));
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
}

TEST_F(ScanTool, ContinuesWithoutJobsThatFailOnAFullDisk) {
  const std::string library = std::string(SURFIT_TOOLS_DIR) + "/libsurfit_fault.so";
  if (!fs::exists(library)) GTEST_SKIP() << "this build has no fault library";
  const TempFolder folder;
  const std::string scan = fs::canonical(folder.path()) / "scan";
  std::string command = "$tools/surfit_scan --cores=2";
  for (const std::string& flag : Flags(scan)) command += " '" + flag + "'";
  // Writes to the folder of the last fragment fail.
  const std::string full = "LD_PRELOAD=" + library +
                           " SURFIT_FAULT=write:1 SURFIT_FAULT_FOLDER=" + scan +
                           "/fragments/0002/ SURFIT_FAULT_MARK=" + scan + "/mark ";
  const ProgramResult result = Succeeded(RunShell(full + command));
  EXPECT_THAT(result.err, HasWarning("fragment_0002"));
  const nlohmann::json summary = Summary(scan);
  ASSERT_EQ(summary["failed"].size(), 1u) << summary;
  const std::string error = summary["failed"][0];
  EXPECT_THAT(error, AllOf(Names("fragment_0002"), HasSubstr("No space left on device")));
  EXPECT_THAT(ReadBytes(scan + "/report.html"), HasSubstr(error));
  EXPECT_EQ(summary["frames"], 26);
  // With free space, completed jobs are not repeated.
  const auto time = fs::last_write_time(scan + "/jobs/fragment_0001.json");
  Succeeded(RunShell(command + " --retry_failed"));
  EXPECT_EQ(fs::last_write_time(scan + "/jobs/fragment_0001.json"), time);
  EXPECT_EQ(Digest(scan), Digest(whole_));
}

TEST_F(ScanTool, RejectsBadInput) {
  const TempFolder folder;
  const std::string scan = folder.path() + "/scan";
  ExpectRefused(RunProgram("surfit_scan", Flags(scan, {"--fragment_frames=16,20"})),
                "overlap_frames");
  ExpectRefused(RunProgram("surfit_scan", Flags(scan, {"--sequence=" + folder.path() + "/none"})),
                "none");
  ExpectRefused(RunProgram("surfit_scan", Flags(scan, {"--profile=nowhere"})), "profile",
                "nowhere");
  ExpectRefused(
      RunProgram("surfit_scan", {"--step=graph", "--scan=" + scan, "--output=" + scan + "/graph"}),
      "plan.json");
}

// Two similar rooms on two floors, and the path between them. No link may connect the rooms.
TEST(ScanSweep, DistinguishesSimilarRoomsOnTwoFloors) {
  if (!HasSnakemake()) GTEST_SKIP() << "Snakemake is not installed";
  const TempFolder folder;
  const std::string sequence = folder / "building", scan = folder / "scan";
  Succeeded(RunProgram("surfit_simulate",
                       {"--scene=building", "--rooms=2", "--frames=2700", "--step_m=0.05,0.07",
                        "--downsample=2", "--surface_grid_m=0.02", "--output=" + sequence}));
  Succeeded(RunProgram("surfit_scan", {"--sequence=" + sequence, "--output=" + scan}));
  const auto summary = nlohmann::json::parse(ReadBytes(scan + "/summary.json"));
  EXPECT_TRUE(summary["failed"].empty());
  EXPECT_EQ(summary["frames"], 2700);
  EXPECT_LT(summary["ate_rmse_m"].get<double>(), 0.05);
  for (const char* const worst : {"worst_link", "worst_loop"}) {
    if (summary[worst].is_null()) continue;
    EXPECT_LT(summary[worst]["translation_m"].get<double>(), 0.1) << worst;
  }
  const ProgramResult map =
      Succeeded(RunProgram("surfit_evaluate", {"--what=map", "--map=" + scan + "/tiles",
                                               "--reference=" + sequence + "/surface.ply",
                                               "--estimate=" + scan + "/trajectory.txt",
                                               "--groundtruth=" + sequence + "/groundtruth.txt"}));
  const auto pose = nlohmann::json::parse(map.out)["reference_from_map"];
  const std::vector<double> t = pose["translation_m"], q = pose["quaternion_xyzw"];
  const Rigid3d reference_from_map(Eigen::Quaterniond(q.data()), Eigen::Vector3d(t.data()));
  std::vector<Eigen::Vector3f> points;
  for (const auto& tile : fs::directory_iterator(scan + "/tiles")) {
    if (tile.path().extension() != ".ply") continue;
    for (const Eigen::Vector3f& point : ReadPly(tile.path()).points) {
      points.push_back((reference_from_map * point.cast<double>()).cast<float>());
    }
  }
  const PointCloud surface = ReadPly(sequence + "/surface.ply");
  EXPECT_GT(ComputeMapError(points, surface.points, surface.normals, {0.02}).completeness, 0.95);
}

}  // namespace
}  // namespace surfit::testing
