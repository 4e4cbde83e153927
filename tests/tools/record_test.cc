#include <gmock/gmock.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <thread>

#include "surfit/io/sequence.h"
#include "testing/matchers.h"
#include "testing/sequence_writer.h"
#include "tools/slam_tool.h"

namespace surfit::testing {
namespace {

namespace fs = std::filesystem;

class RecordTool : public SlamTool {
 protected:
  std::string Copy() const { return own_.path() + "/recorded"; }
  ProgramResult Record(const std::string& sequence, std::vector<std::string> flags = {}) const {
    flags.insert(flags.begin(), {"--sequence=" + sequence, "--output=" + Copy()});
    return RunProgram("surfit_record", flags);
  }
  // Sends the signal after some frames have been recorded.
  ProgramResult EndedBy(int signal) const {
    RunningProgram program("surfit_record", {"--sequence=" + EndlessRoom(), "--output=" + Copy()});
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (!fs::exists(Copy() + "/associations.txt") ||
           CountPoses(Copy() + "/associations.txt") < 5) {
      if (std::chrono::steady_clock::now() > deadline) break;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    program.Signal(signal);
    return program.Wait();
  }
  // Expects that all listed frames are readable, and returns their number.
  std::size_t CountWholeFrames() const {
    std::size_t count = 0;
    for (const ReadResult& result : ReadAll(OpenSequence(OptionsOf(Copy())).get())) {
      EXPECT_TRUE(result.frame) << result.error;
      ++count;
    }
    return count;
  }
};

TEST_F(RecordTool, RecordedFolderHasTheSameTrajectoryAndMap) {
  const ProgramResult result = Succeeded(Record(Room()));
  EXPECT_THAT(result.out, Names(24, 0.77, 0));
  Succeeded(Slam(Room(), Output("a")));
  Succeeded(Slam(Copy(), Output("b")));
  EXPECT_EQ(Summary(Output("a"))["digest"], Summary(Output("b"))["digest"]);
  EXPECT_EQ(ReadBytes(Output("a") + "/trajectory.txt"), ReadBytes(Output("b") + "/trajectory.txt"));
  EXPECT_NEAR(Summary(Output("a"))["ate_rmse_m"].get<double>(),
              Summary(Output("b"))["ate_rmse_m"].get<double>(),
              1e-8);  // ground truth has 9 decimals
}

TEST_F(RecordTool, RecordsMirroredAndNumberedSequences) {
  const std::string sequence = Simulate("icl", {"--format=icl_nuim"});
  Succeeded(Record(sequence));
  Succeeded(Slam(sequence, Output("a")));
  Succeeded(Slam(Copy(), Output("b")));
  EXPECT_EQ(ReadBytes(Output("a") + "/trajectory.txt"), ReadBytes(Output("b") + "/trajectory.txt"));
}

TEST_F(RecordTool, RecordsOneFileAsAFolder) {
  const std::string klg = own_ / "room.klg";
  Succeeded(RunProgram("surfit_convert", {"--sequence=" + Room(), "--output=" + klg}));
  Succeeded(Record(klg));
  const auto file = OpenSequence(OptionsOf(klg)), copy = OpenSequence(OptionsOf(Copy()));
  while (const auto expected = file->Next()) {
    const auto actual = copy->Next();
    ASSERT_TRUE(actual && actual->frame);
    EXPECT_EQ(actual->stamp_s, expected->stamp_s);
    EXPECT_EQ(actual->frame->color, expected->frame->color);
    EXPECT_EQ(actual->frame->depth_m, expected->frame->depth_m);
  }
  EXPECT_FALSE(copy->Next());
}

TEST_F(RecordTool, ReportsDepthOfLowConfidence) {
  const TempFolder folder;
  WriteTumSequence(folder, 2);
  WriteConfidence(folder / "confidence/000.png", Image<std::uint8_t>(32, 24, 0));
  WriteConfidence(folder / "confidence/001.png", Image<std::uint8_t>(32, 24, 1));
  EXPECT_THAT(Succeeded(Record(folder.path())).out, Names("50.0", "confidence"));
}

TEST_F(RecordTool, StopsAtItsLimits) {
  Succeeded(Record(Room(), {"--last=6"}));
  EXPECT_EQ(CountWholeFrames(), 7U);
  fs::remove_all(Copy());
  Succeeded(Record(Room(), {"--seconds=0.34"}));  // the first frame and 10 intervals
  EXPECT_EQ(CountWholeFrames(), 11U);
}

TEST_F(RecordTool, CountsUnreadableFrames) {
  const std::string room = CopyOfRoom();
  fs::remove(fs::directory_iterator(room + "/depth")->path());
  const ProgramResult result = Succeeded(Record(room));
  EXPECT_THAT(result.out, Names(23, 1));
  EXPECT_EQ(CountWholeFrames(), 23U);
}

TEST_F(RecordTool, LeavesACompleteRecordingAfterSigint) {
  const ProgramResult result = Succeeded(EndedBy(SIGINT));
  EXPECT_THAT(result.out, Names(CountWholeFrames()));
  EXPECT_THAT(result.out, Names("interrupted"));
}

TEST_F(RecordTool, LeavesACompleteRecordingAfterSigkill) {
  EXPECT_EQ(EndedBy(SIGKILL).exit_code, 128 + SIGKILL);
  EXPECT_GE(CountWholeFrames(), 5U);
}

TEST_F(RecordTool, RejectsExistingOutput) {
  Succeeded(Record(Room(), {"--last=1"}));
  ExpectRefused(Record(Room()), "depth.txt");
  ExpectRefused(RunProgram("surfit_record", {"--sequence=" + Room(), "--output=" + Room()}),
                "--sequence", Room());
  ExpectRefused(Record(Room(), {"--downsample=2"}), "downsample");
}

}  // namespace
}  // namespace surfit::testing
