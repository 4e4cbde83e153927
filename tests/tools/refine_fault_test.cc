// Makes each system call of a short run of surfit_refine fail once.
#include <gmock/gmock.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "surfit/io/camera_files.h"
#include "surfit/io/point_cloud.h"
#include "surfit/io/trajectory_files.h"
#include "tools/fault_tool.h"

namespace surfit::testing {
namespace {

namespace fs = std::filesystem;

class RefineFaultTest : public FaultTest {
 protected:
  static constexpr int kFramesRun = 6;

  void SetUp() override {
    FaultTest::SetUp();
    Succeeded(
        Slam(Room(), own_.path() + "/run", {"--stride=4", "--downsample=2", "--nocalibrate"}));
  }

  std::string RefineCommand() const {
    return "surfit_refine --threads=1 --keyframe_translation_m=0.02 --run=" +
           WholePath(own_.path() + "/run") + " --sequence=" + WholePath(Room()) +
           " --output=" + WholePath(Output());
  }

  // Number of complete result files, 0 to 5.
  int CountWholeResults() const {
    const auto is_there = [&](const char* name) { return fs::exists(Output() + name); };
    int count = 0;
    if (is_there("/trajectory.txt")) {
      EXPECT_EQ(ReadTumTrajectory(Output() + "/trajectory.txt").size(), kFramesRun);
      ++count;
    }
    if (is_there("/camera.yaml")) {
      EXPECT_NO_THROW(ReadCameraYaml(Output() + "/camera.yaml"));
      ++count;
    }
    if (is_there("/map.ply")) {
      EXPECT_GT(ReadSurfelPly(Output() + "/map.ply").size(), 1000u);
      ++count;
    }
    if (is_there("/poses.json")) {
      EXPECT_EQ(nlohmann::json::parse(ReadBytes(Output() + "/poses.json"))["poses"].size(),
                kFramesRun);
      ++count;
    }
    if (is_there("/refinement.json")) {
      EXPECT_NO_THROW(nlohmann::json::parse(ReadBytes(Output() + "/refinement.json")));
      ++count;
    }
    return count;
  }

  // After refinement at most one result may be missing, and an error must be reported. Returns the
  // number of such calls in a run.
  int ExpectSavedWhicheverFails(const std::string& kind, const std::string& folder) const {
    for (int n = 1;; ++n) {
      const auto result = RunWithFault(kind, n, folder, RefineCommand());
      if (!result) return n - 1;
      const int count = fs::exists(Output()) ? CountWholeResults() : 0;
      const std::string what = kind + " " + std::to_string(n) + ": " + result->err;
      EXPECT_EQ(count == 5, result->exit_code == 0) << what;
      EXPECT_THAT(count, ::testing::AnyOf(0, 4, 5)) << what;
      if (count != 4 || !fs::exists(Output() + "/refinement.json")) continue;
      const auto json = nlohmann::json::parse(ReadBytes(Output() + "/refinement.json"));
      EXPECT_TRUE(json["failure"].is_string()) << what;
    }
  }
};

TEST_F(RefineFaultTest, SavesOtherResultsIfAWriteFails) {
  EXPECT_GE(ExpectSavedWhicheverFails("write", Output()), 5);
  EXPECT_GE(ExpectSavedWhicheverFails("open", Output()), 5);
  EXPECT_GE(ExpectSavedWhicheverFails("rename", Output()), 5);
  EXPECT_GE(ExpectSavedWhicheverFails("fsync", Output()), 5);
}

// Refines the readable frames.
TEST_F(RefineFaultTest, SavesResultsIfAReadFails) {
  EXPECT_GT(ExpectSavedWhicheverFails("read", Room()), 4 * kFramesRun);
}

TEST_F(RefineFaultTest, SavesResultsIfAnAllocationFails) {
  EXPECT_GT(ExpectSavedWhicheverFails("malloc", Output()), 20);
}

}  // namespace
}  // namespace surfit::testing
