// Every call of the system that a short run makes is let fail once: see fault_library.cc.
#include <gmock/gmock.h>

#include <chrono>
#include <thread>

#include "surfit/io/g2o.h"
#include "surfit/io/point_cloud.h"
#include "surfit/io/trajectory_files.h"
#include "testing/matchers.h"
#include "testing/pose_graphs.h"
#include "tools/slam_tool.h"

namespace surfit::testing {
namespace {

namespace fs = std::filesystem;

const std::string kLibrary = std::string(SURFIT_TOOLS_DIR) + "/libsurfit_fault.so";

class FaultTest : public SlamTool {
 protected:
  static constexpr int kFramesRun = 4;

  void SetUp() override {
    if (!fs::exists(kLibrary)) GTEST_SKIP() << "no library of faults in this build";
  }

  // Runs a program with the n-th call of a kind failing; nothing if it makes fewer.
  std::optional<ProgramResult> RunWithFault(const std::string& kind, int n,
                                            const std::string& folder,
                                            const std::string& command) const {
    const std::string mark = own_.path() + "/mark";
    fs::remove(mark);
    fs::remove_all(Output());
    const ProgramResult result =
        RunShell("export SURFIT_FAULT=" + kind + ":" + std::to_string(n) + " SURFIT_FAULT_FOLDER=" +
                 fs::weakly_canonical(folder).string() + " SURFIT_FAULT_MARK=" + mark +
                 "\nLD_PRELOAD=" + kLibrary + " exec $tools/" + command);
    if (!fs::exists(mark)) return std::nullopt;
    EXPECT_LT(result.exit_code, 128) << kind << " " << n << ": " << result.err;
    if (result.exit_code == 1) {
      EXPECT_THAT(result.err, HasSubstr("error: ")) << kind << " " << n;
    }
    return result;
  }

  std::string SlamCommand() const {
    return "surfit_slam --nopictures --threads=1 --last=" + std::to_string(kFramesRun - 1) +
           " --sequence=" + fs::weakly_canonical(Room()).string() +
           " --output=" + fs::weakly_canonical(Output()).string();
  }

  // Each file is whole, if it is there. Returns how many of the results are.
  int CountWholeResults() const {
    int count = 0;
    for (const char* name : {"/trajectory.txt", "/frames.csv"}) {
      const std::string text = ReadBytes(Output() + name);
      EXPECT_TRUE(text.empty() || text.back() == '\n') << name;
    }
    const auto is_there = [&](const char* name) { return fs::exists(Output() + name); };
    if (is_there("/map.ply")) {
      EXPECT_NO_THROW(ReadPly(Output() + "/map.ply"));
      ++count;
    }
    for (const char* name : {"/summary.json", "/poses.json"}) {
      if (!is_there(name)) continue;
      EXPECT_NO_THROW(nlohmann::json::parse(ReadBytes(Output() + name))) << name;
      ++count;
    }
    return count;
  }

  void ExpectNothingUnfinished() const {
    for (const auto& entry : fs::directory_iterator(Output())) {
      EXPECT_THAT(entry.path().string(), Not(HasSubstr(".partial")));
      EXPECT_THAT(entry.path().string(), Not(HasSubstr(".lock")));
    }
  }

  // After the first frame no more than one of three results may be missing, and never in silence.
  void ExpectSaved(const ProgramResult& result, const std::string& what) const {
    if (!fs::exists(Output())) return;
    const int results = CountWholeResults();
    ExpectNothingUnfinished();
    if (CountPoses(Output() + "/trajectory.txt") == 0) return;
    EXPECT_GE(results, 2) << what << ": " << result.err;
    if (results < 3 || CountPoses(Output() + "/trajectory.txt") < kFramesRun) {
      EXPECT_EQ(result.exit_code, 1) << what;
    }
    if (result.exit_code == 1 && fs::exists(Output() + "/summary.json")) {
      EXPECT_FALSE(Summary(Output())["failure"].is_null()) << what;
    }
  }

  // Returns how often such a call is made.
  int ExpectSavedWhicheverFails(const std::string& kind) const {
    for (int n = 1;; ++n) {
      const auto result = RunWithFault(kind, n, Output(), SlamCommand());
      if (!result) return n - 1;
      ExpectSaved(*result, kind + " " + std::to_string(n));
    }
  }
};

TEST_F(FaultTest, SlamSavesWhatItCanWhicheverWriteFails) {
  EXPECT_GT(ExpectSavedWhicheverFails("write"), 3 * kFramesRun);
}

TEST_F(FaultTest, SlamSavesWhatItCanWhicheverFileCannotBeMade) {
  EXPECT_GE(ExpectSavedWhicheverFails("open"), 7);
  EXPECT_GE(ExpectSavedWhicheverFails("rename"), 4);
  EXPECT_GE(ExpectSavedWhicheverFails("fsync"), 4);
}

TEST_F(FaultTest, SlamSavesWhatItCanWhicheverMemoryIsMissing) {
  EXPECT_GT(ExpectSavedWhicheverFails("malloc"), 20);
}

TEST_F(FaultTest, SlamTakesWritesThatAreDoneByHalves) {
  Succeeded(RunShell("$tools/" + SlamCommand()));
  const std::string digest = Summary(Output())["digest"], map = ReadBytes(Output() + "/map.ply");
  for (int n = 1;; ++n) {
    const auto result = RunWithFault("short", n, Output(), SlamCommand());
    if (!result) break;
    Succeeded(*result);
    EXPECT_EQ(Summary(Output())["digest"], digest);
    EXPECT_EQ(ReadBytes(Output() + "/map.ply"), map);
    EXPECT_EQ(CountPoses(Output() + "/trajectory.txt"), kFramesRun);
  }
}

TEST_F(FaultTest, SlamSkipsFramesAndRefusesListsThatCannotBeRead) {
  int skipped = 0, refused = 0;
  for (int n = 1;; ++n) {
    const auto result = RunWithFault("read", n, Room(), SlamCommand());
    if (!result) break;
    if (result->exit_code == 0) {
      EXPECT_LE(Summary(Output())["frames_skipped"], 1);
      skipped += Summary(Output())["frames_skipped"].get<int>();
    } else {
      EXPECT_EQ(result->exit_code, 1) << n;
      EXPECT_THAT(result->err, HasSubstr("cannot read '"));
      ++refused;
    }
  }
  EXPECT_GE(skipped, 2 * kFramesRun - 2);
  EXPECT_GE(refused, 2);
}

TEST_F(FaultTest, SlamLeavesWholeFilesWheneverItIsKilled) {
  for (int wait_ms = 0; wait_ms < 600; wait_ms += 30) {
    {
      RunningProgram program("surfit_slam", {"--sequence=" + Room(), "--output=" + Output(),
                                             "--nopictures", "--threads=2"});
      std::this_thread::sleep_for(std::chrono::milliseconds(wait_ms));
    }  // kills it
    if (fs::exists(Output())) CountWholeResults();
  }
  Succeeded(Slam(Room(), Output()));
  EXPECT_EQ(CountWholeResults(), 3);
  ExpectNothingUnfinished();
}

// The older file stays unless the new one is there as a whole.
TEST_F(FaultTest, OptimizeKeepsTheOlderFileWhicheverCallFails) {
  const std::string folder = own_.path() + "/graph", output = folder + "/out.g2o";
  fs::create_directory(folder);
  WriteG2o(MakeGrid(3).graph, own_.path() + "/a.g2o");
  const std::string command = "surfit_optimize --graph=" + own_.path() +
                              "/a.g2o --output=" + fs::weakly_canonical(output).string();
  Succeeded(RunShell("$tools/" + command));
  const std::string whole = ReadBytes(output);
  for (const char* kind : {"open", "write", "rename", "fsync"}) {
    for (int n = 1;; ++n) {
      WriteBytes(output, "older");
      const auto result = RunWithFault(kind, n, folder, command);
      if (!result) break;
      EXPECT_EQ(ReadBytes(output), result->exit_code == 0 ? whole : "older") << kind << n;
      EXPECT_EQ(std::distance(fs::directory_iterator(folder), fs::directory_iterator()), 1);
    }
  }
}

}  // namespace
}  // namespace surfit::testing
