// surfit_slam on a recording that is played forward and backward for hours.
#include <gmock/gmock.h>

#include <algorithm>
#include <chrono>
#include <iomanip>
#include <thread>

#include "testing/matchers.h"
#include "tools/slam_tool.h"

namespace surfit::testing {
namespace {

namespace fs = std::filesystem;

// Memory of a run after a number of frames.
struct Sample {
  int frames = 0;
  std::size_t bytes = 0;
};

class SlamSoak : public SlamTool {
 protected:
  static constexpr int kFramesThere = 120;

  // A recording at 30 Hz: the room forward and backward, repeated.
  std::string ThereAndBack(int frames) const {
    const std::string walk =
        Simulate("walk", {"--frames=" + std::to_string(kFramesThere), "--downsample=8"});
    std::vector<std::string> rows;
    for (const std::string& line : Lines(walk + "/associations.txt")) {
      if (line[0] != '#') rows.push_back(line);
    }
    fs::remove(walk + "/groundtruth.txt");
    std::ofstream file(walk + "/associations.txt");
    for (int i = 0; i < frames; ++i) {
      const int phase = i % (2 * kFramesThere - 2);
      std::istringstream row(rows[std::min(phase, 2 * kFramesThere - 2 - phase)]);
      std::string stamp, color, depth;
      row >> stamp >> color >> stamp >> depth;
      file << std::fixed << std::setprecision(6) << i / 30. << " " << color << " " << i / 30. << " "
           << depth << "\n";
    }
    return walk;
  }

  // Samples at 10 Hz.
  std::vector<Sample> Run(int frames) const {
    const std::string sequence = ThereAndBack(frames);
    RunningProgram program("surfit_slam", {"--sequence=" + sequence, "--output=" + Output(),
                                           "--nopictures", "--threads=2"});
    const std::string path = Output() + "/trajectory_online.txt";
    std::vector<Sample> samples;
    while (program.IsRunning()) {
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
      std::error_code none;
      const auto size = fs::exists(path, none) ? fs::file_size(path, none) : 0;
      samples.push_back({static_cast<int>(size / 90), program.ResidentBytes()});
    }
    Succeeded(program.Wait());
    return samples;
  }

  // Expects constant memory except for 40 numbers per frame, in vectors that double their capacity.
  // The finer final map exists in addition to the tracking map.
  void ExpectFlatMemoryAndNoLostFrame(int frames) const {
    constexpr double kBytesOfFrame = 600, kNoise = 8e6, kFinalMap = 24e6;
    std::size_t early = 0, late = 0, end = 0;
    for (const Sample& sample : Run(frames)) {
      if (sample.frames < frames / 4) continue;
      std::size_t& most = 2 * sample.frames < frames ? early : sample.frames < frames ? late : end;
      most = std::max(most, sample.bytes);
    }
    EXPECT_EQ(Summary(Output())["frames_tracked"], frames);
    EXPECT_EQ(CountPoses(Output() + "/trajectory.txt"), frames);
    ASSERT_GT(early, 0u);
    const double flat = static_cast<double>(early) + kBytesOfFrame * frames * 3 / 4 + kNoise;
    EXPECT_LT(static_cast<double>(late), flat);
    EXPECT_LT(static_cast<double>(end), flat + kFinalMap);
    std::cout << frames << " frames: " << early / 1000000 << " MB in the second quarter, "
              << late / 1000000 << " MB in the second half, " << end / 1000000
              << " MB at the end\n";
  }
};

TEST_F(SlamSoak, TracksAll2000FramesInConstantMemory) { ExpectFlatMemoryAndNoLostFrame(2000); }

TEST_F(SlamSoak, TracksAll100000FramesInConstantMemory) { ExpectFlatMemoryAndNoLostFrame(100000); }

}  // namespace
}  // namespace surfit::testing
