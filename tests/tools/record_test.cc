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
  // Ended by the signal once it has recorded some frames.
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
  // All frames that the lists name can be read.
  std::size_t CountWholeFrames() const {
    std::size_t count = 0;
    for (const ReadResult& result : ReadAll(OpenSequence(OptionsOf(Copy())).get())) {
      EXPECT_TRUE(result.frame) << result.error;
      ++count;
    }
    return count;
  }
};

TEST_F(RecordTool, MakesAFolderThatGivesTheSameTrajectoryAndMap) {
  const ProgramResult result = Succeeded(Record(Room()));
  EXPECT_THAT(result.out, HasSubstr("recorded: 24 frames over 0.77 s, 0 skipped, 0 dropped"));
  Succeeded(Slam(Room(), Output("a")));
  Succeeded(Slam(Copy(), Output("b")));
  EXPECT_EQ(Summary(Output("a"))["digest"], Summary(Output("b"))["digest"]);
  EXPECT_EQ(ReadBytes(Output("a") + "/trajectory.txt"), ReadBytes(Output("b") + "/trajectory.txt"));
  EXPECT_NEAR(Summary(Output("a"))["ate_rmse_m"].get<double>(),
              Summary(Output("b"))["ate_rmse_m"].get<double>(), 1e-8);  // truth has 9 decimals
}

TEST_F(RecordTool, RecordsWhatIsMirroredAndNumbered) {
  const std::string sequence = Simulate("icl", {"--image_y_up"});
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

TEST_F(RecordTool, EndsAtItsLimits) {
  Succeeded(Record(Room(), {"--max_frames=7"}));
  EXPECT_EQ(CountWholeFrames(), 7U);
  fs::remove_all(Copy());
  Succeeded(Record(Room(), {"--seconds=0.34"}));  // 10 of the gaps, and the first frame
  EXPECT_EQ(CountWholeFrames(), 11U);
}

TEST_F(RecordTool, CountsWhatCannotBeRead) {
  const std::string room = CopyOfRoom();
  fs::remove(fs::directory_iterator(room + "/depth")->path());
  const ProgramResult result = Succeeded(Record(room));
  EXPECT_THAT(result.out, HasSubstr("23 frames"));
  EXPECT_THAT(result.out, HasSubstr("1 skipped"));
  EXPECT_EQ(CountWholeFrames(), 23U);
}

TEST_F(RecordTool, LeavesAGoodRecordingWhereItIsInterrupted) {
  const ProgramResult result = Succeeded(EndedBy(SIGINT));
  EXPECT_THAT(result.out, HasSubstr(std::to_string(CountWholeFrames()) + " frames over"));
  EXPECT_THAT(result.out, HasSubstr("interrupted"));
}

TEST_F(RecordTool, LeavesAGoodRecordingWhereItIsKilled) {
  EXPECT_EQ(EndedBy(SIGKILL).exit_code, 128 + SIGKILL);
  EXPECT_GE(CountWholeFrames(), 5U);
}

TEST_F(RecordTool, WritesOverNothing) {
  Succeeded(Record(Room(), {"--max_frames=2"}));
  ExpectRefused(Record(Room()), "depth.txt exists");
  ExpectRefused(RunProgram("surfit_record", {"--sequence=" + Room(), "--output=" + Room()}),
                "which --sequence reads, must be another");
  ExpectRefused(Record(Room(), {"--downsample=2"}), "images are recorded as they come");
}

}  // namespace
}  // namespace surfit::testing
