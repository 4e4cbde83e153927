// surfit_slam on a slow machine. A watchdog ends runs that hang.
#include <gmock/gmock.h>

#include <algorithm>
#include <sstream>

#include "testing/busy_machine.h"
#include "testing/matchers.h"
#include "testing/trace_slices.h"
#include "tools/slam_tool.h"

namespace surfit::testing {
namespace {

class SlamLoad : public SlamTool {
 protected:
  static constexpr int kFramesRun = 150;

  static void SetUpTestSuite() {
    SlamTool::SetUpTestSuite();
    Simulate("walk", {"--frames=" + std::to_string(kFramesRun), "--downsample=8"});
  }

  // Runs surfit_slam with loop closure and calibration. `setting` precedes the command. The trace
  // is OUTPUT.json.
  void Run(const std::string& output, int threads, const std::string& setting = "") const {
    constexpr int kHung = 124;
    const ProgramResult result = RunShell(
        "timeout --kill-after=1 240 " + setting + " $tools/surfit_slam --nopictures " +
        "--loop_closure --threads=" + std::to_string(threads) + " --sequence=" + folder_->path() +
        "/walk --output=" + Output(output) + " --trace=" + Output(output) + ".json");
    ASSERT_NE(result.exit_code, kHung) << "it hung";
    Succeeded(result);
    EXPECT_EQ(Summary(Output(output))["frames_tracked"], kFramesRun);
    EXPECT_GE(Summary(Output(output))["calibrations"].size(), 1u);
  }

  // A column of frames.csv, one number per frame.
  std::vector<double> Times(const std::string& output, const std::string& name) const {
    const std::vector<std::string> lines = Lines(Output(output) + "/frames.csv");
    const auto cells = [](const std::string& line) {
      std::vector<std::string> words;
      std::istringstream stream(line);
      for (std::string word; std::getline(stream, word, ',');) words.push_back(word);
      return words;
    };
    const std::vector<std::string> header = cells(lines.at(0));
    const auto column = std::find(header.begin(), header.end(), name) - header.begin();
    std::vector<double> times;
    for (std::size_t i = 1; i < lines.size(); ++i)
      times.push_back(std::stod(cells(lines[i]).at(static_cast<std::size_t>(column))));
    return times;
  }
  double LongestWait_ms(const std::string& output) const {
    const std::vector<double> times = Times(output, "correct_ms");
    return *std::max_element(times.begin(), times.end());
  }
};

// Slices of a trace that last longer than 5 ms.
std::vector<Slice> LongSlices(const std::string& path, const std::string& name) {
  constexpr std::int64_t kLong_ns = 5000000;
  std::vector<Slice> found;
  for (const Slice& slice : ReadSlices(path))
    if (slice.name == name && slice.end_ns - slice.begin_ns > kLong_ns) found.push_back(slice);
  return found;
}

// Expects that frames wait for the rest of calibrations that are under way, and that no wait spans
// two calibrations. Other waits belong to loop closure, or to a core that another program has.
void ExpectWaitsForOneTask(const std::string& trace) {
  const std::vector<Slice> waits = LongSlices(trace, "correct"),
                           tasks = LongSlices(trace, "calibrate");
  int waits_for_one = 0;
  for (const Slice& wait : waits) {
    int under_way = 0, later = 0;
    for (const Slice& task : tasks) {
      if (task.thread == wait.thread || task.end_ns <= wait.begin_ns) continue;
      under_way += task.begin_ns <= wait.begin_ns && task.end_ns <= wait.end_ns;
      later += task.begin_ns > wait.begin_ns && task.begin_ns < wait.end_ns;
    }
    EXPECT_LE(under_way, 1) << "frame " << wait.frame;
    EXPECT_EQ(later, 0) << "frame " << wait.frame;
    waits_for_one += under_way == 1;
  }
  EXPECT_GE(waits_for_one, 3);
}

// With one thread, the frame that needs a result computes the entire task. A task that keeps its
// low priority on a busy machine lasts minutes.
TEST_F(SlamLoad, FrameWaitsAtMostForItsTaskOnABusyMachine) {
  const BusyMachine busy;
  Run("one", 1);
  Run("two", 2);
  EXPECT_GT(LongestWait_ms("one"), 5);
  EXPECT_LT(LongestWait_ms("two"), 3 * LongestWait_ms("one") + 500);
  ExpectWaitsForOneTask(Output("two") + ".json");
  EXPECT_EQ(Summary(Output("one"))["digest"], Summary(Output("two"))["digest"]);
}

TEST_F(SlamLoad, FinishesOnOneCore) {
  Run("all", 2);
  Run("one", 2, "taskset --cpu-list $(taskset -cp $$ | sed 's/.*[ ,-]//')");
  EXPECT_EQ(Summary(Output("all"))["digest"], Summary(Output("one"))["digest"]);
}

TEST_F(SlamLoad, FinishesWithASlowDisk) {
  const std::string library = std::string(SURFIT_TOOLS_DIR) + "/libsurfit_fault.so";
  if (!std::filesystem::exists(library)) GTEST_SKIP() << "this build has no fault library";
  constexpr double kWrite_ms = 20;
  Run("quick", 2);
  Run("slow", 2,
      "env LD_PRELOAD=" + library + " SURFIT_FAULT=slow:20 SURFIT_FAULT_MARK=" + Output("mark") +
          " SURFIT_FAULT_FOLDER=" + std::filesystem::weakly_canonical(own_.path()).string());
  EXPECT_EQ(Summary(Output("quick"))["digest"], Summary(Output("slow"))["digest"]);
  // Each frame causes writes to three files.
  int frames = 0;
  for (const Slice& slice : ReadSlices(Output("slow") + ".json")) {
    if (slice.name != "write") continue;
    ++frames;
    EXPECT_GE(1e-6 * static_cast<double>(slice.end_ns - slice.begin_ns), 3 * kWrite_ms);
  }
  EXPECT_EQ(frames, kFramesRun);
}

}  // namespace
}  // namespace surfit::testing
