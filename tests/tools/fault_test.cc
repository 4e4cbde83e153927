// Makes each system call of a short run of surfit_slam fail once.
#include <gmock/gmock.h>

#include <chrono>
#include <thread>

#include "surfit/io/point_cloud.h"
#include "surfit/io/trajectory_files.h"
#include "tools/fault_tool.h"

namespace surfit::testing {
namespace {

namespace fs = std::filesystem;

class SlamFaultTest : public FaultTest {
 protected:
  static constexpr int kFramesRun = 4;

  std::string SlamCommand() const {
    return "surfit_slam --nopictures --threads=1 --last=" + std::to_string(kFramesRun - 1) +
           " --sequence=" + WholePath(Room()) + " --output=" + WholePath(Output());
  }

  // Expects that existing files are complete. Returns the number of existing results.
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
      EXPECT_EQ(entry.path().string().find(".partial"), std::string::npos) << entry.path();
      EXPECT_EQ(entry.path().string().find(".lock"), std::string::npos) << entry.path();
    }
  }

  // After the first frame at most one of three results may be missing, and an error must be
  // reported.
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

  // Returns the number of such calls in a run.
  int ExpectSavedWhicheverFails(const std::string& kind) const {
    for (int n = 1;; ++n) {
      const auto result = RunWithFault(kind, n, Output(), SlamCommand());
      if (!result) return n - 1;
      ExpectSaved(*result, kind + " " + std::to_string(n));
    }
  }
};

TEST_F(SlamFaultTest, SavesOtherResultsIfAWriteFails) {
  EXPECT_GT(ExpectSavedWhicheverFails("write"), 3 * kFramesRun);
}

TEST_F(SlamFaultTest, SavesOtherResultsIfAFileCannotBeCreated) {
  EXPECT_GE(ExpectSavedWhicheverFails("open"), 7);
  EXPECT_GE(ExpectSavedWhicheverFails("rename"), 4);
  EXPECT_GE(ExpectSavedWhicheverFails("fsync"), 4);
}

TEST_F(SlamFaultTest, SavesOtherResultsIfAnAllocationFails) {
  EXPECT_GT(ExpectSavedWhicheverFails("malloc"), 20);
}

TEST_F(SlamFaultTest, CompletesShortWrites) {
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

TEST_F(SlamFaultTest, SkipsUnreadableFramesAndRejectsUnreadableLists) {
  int skipped = 0, refused = 0;
  for (int n = 1;; ++n) {
    const auto result = RunWithFault("read", n, Room(), SlamCommand());
    if (!result) break;
    if (result->exit_code == 0) {
      EXPECT_LE(Summary(Output())["frames_skipped"], 1);
      skipped += Summary(Output())["frames_skipped"].get<int>();
    } else {
      EXPECT_EQ(result->exit_code, 1) << n;
      EXPECT_THAT(result->err, HasError());
      ++refused;
    }
  }
  EXPECT_GE(skipped, 2 * kFramesRun - 2);
  EXPECT_GE(refused, 2);
}

TEST_F(SlamFaultTest, LeavesCompleteFilesAfterSigkill) {
  for (int wait_ms = 0; wait_ms < 600; wait_ms += 30) {
    {
      RunningProgram program("surfit_slam", {"--sequence=" + Room(), "--output=" + Output(),
                                             "--nopictures", "--threads=2"});
      std::this_thread::sleep_for(std::chrono::milliseconds(wait_ms));
    }  // SIGKILL
    if (fs::exists(Output())) CountWholeResults();
  }
  Succeeded(Slam(Room(), Output()));
  EXPECT_EQ(CountWholeResults(), 3);
  ExpectNothingUnfinished();
}

}  // namespace
}  // namespace surfit::testing
