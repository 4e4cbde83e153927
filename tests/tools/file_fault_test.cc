// Makes each system call of short runs of surfit_optimize and surfit_convert fail once.
#include <gmock/gmock.h>

#include <filesystem>

#include "surfit/io/g2o.h"
#include "surfit/io/point_cloud.h"
#include "surfit/io/trajectory_files.h"
#include "testing/pose_graphs.h"
#include "testing/sequence_writer.h"
#include "tools/fault_tool.h"

namespace surfit::testing {
namespace {

namespace fs = std::filesystem;

// Tests of programs that read a file and write one or more files.
class FileFaultTest : public FaultTest {
 protected:
  FileFaultTest() {
    for (const char* name : {"from", "to"}) fs::create_directory(own_.path() + "/" + name);
  }
  std::string In() const { return WholePath(own_.path() + "/from"); }
  std::string Out(const std::string& name = "") const {
    return WholePath(own_.path() + "/to") + (name.empty() ? "" : "/" + name);
  }

  // Expects that each output file is either the old file or the complete new file. After exit code
  // 0, all files must be new. Fails each kind of system call for writing.
  void ExpectOlderOrWholeWhicheverWriteFails(const std::string& command,
                                             const std::vector<std::string>& names) const {
    const std::vector<std::string> whole = Results(command, names);
    for (const char* kind : {"open", "write", "rename", "fsync", "malloc"}) {
      ExpectOlderOrWholeWhicheverFails(kind, Out(), command, names, whole);
    }
  }
  // Same expectation for failing system calls for reading.
  void ExpectOlderOrWholeWhicheverReadFails(const std::string& command,
                                            const std::vector<std::string>& names) const {
    const std::vector<std::string> whole = Results(command, names);
    for (const char* kind : {"open", "read", "malloc"}) {
      ExpectOlderOrWholeWhicheverFails(kind, In(), command, names, whole);
    }
  }

 private:
  // Contents of the output files after a run without faults.
  std::vector<std::string> Results(const std::string& command,
                                   const std::vector<std::string>& names) const {
    Succeeded(RunShell("$tools/" + command));
    std::vector<std::string> whole;
    for (const std::string& name : names) whole.push_back(ReadBytes(Out(name)));
    return whole;
  }

  void ExpectOlderOrWholeWhicheverFails(const std::string& kind, const std::string& folder,
                                        const std::string& command,
                                        const std::vector<std::string>& names,
                                        const std::vector<std::string>& whole) const {
    for (int n = 1;; ++n) {
      for (const std::string& name : names) WriteBytes(Out(name), "older");
      const auto result = RunWithFault(kind, n, folder, command);
      const std::string what = command + ": " + kind + " " + std::to_string(n);
      EXPECT_TRUE(result || n > 1) << what << " is never called";
      if (!result) return;
      for (std::size_t i = 0; i < names.size(); ++i) {
        const std::string now = ReadBytes(Out(names[i]));
        EXPECT_TRUE(now == whole[i] || (result->exit_code != 0 && now == "older"))
            << what << ": " << names[i] << " has " << now.size() << " bytes, " << result->err;
      }
      const auto files = std::distance(fs::directory_iterator(Out()), fs::directory_iterator());
      EXPECT_EQ(static_cast<std::size_t>(files), names.size()) << what;
    }
  }
};

TEST_F(FileFaultTest, OptimizeKeepsTheOldFileIfACallFails) {
  WriteG2o(MakeGrid(6).graph, In() + "/a.g2o");
  const std::string command = "surfit_optimize --graph=" + In() + "/a.g2o --output=" + Out("b.g2o");
  ExpectOlderOrWholeWhicheverWriteFails(command, {"b.g2o"});
  ExpectOlderOrWholeWhicheverReadFails(command, {"b.g2o"});
}

TEST_F(FileFaultTest, ConvertKeepsTheOldFileIfACallFails) {
  PointCloud cloud;
  cloud.points.resize(20000, {1, 2, 3});
  WritePly(cloud, In() + "/a.ply");
  const std::string convert = "surfit_convert --map=" + In() + "/a.ply --output=";
  ExpectOlderOrWholeWhicheverReadFails(convert + Out("b.pcd"), {"b.pcd"});
  ExpectOlderOrWholeWhicheverWriteFails(convert + Out("b.pcd"), {"b.pcd"});
  fs::remove(Out("b.pcd"));
  ExpectOlderOrWholeWhicheverWriteFails(convert + Out("b.ply"), {"b.ply"});
}

TEST_F(FileFaultTest, ConvertKeepsTheOldPosesIfACallFails) {
  WriteTumTrajectory(Trajectory(2000), In() + "/a.txt");
  const std::string command =
      "surfit_convert --estimate=" + In() + "/a.txt --output=" + Out("b.txt");
  ExpectOlderOrWholeWhicheverWriteFails(command, {"b.txt"});
  ExpectOlderOrWholeWhicheverReadFails(command, {"b.txt"});
}

TEST_F(FileFaultTest, ConvertKeepsTheOldRecordingIfACallFails) {
  ExpectOlderOrWholeWhicheverWriteFails(
      "surfit_convert --last=2 --sequence=" + WholePath(Room()) + " --output=" + Out("b.klg"),
      {"b.klg", "b.klg.yaml"});
}

// An unreadable frame is skipped and reported.
TEST_F(FileFaultTest, ConvertSkipsUnreadableFramesAndRejectsUnreadableLists) {
  int skipped = 0, refused = 0;
  for (int n = 1;; ++n) {
    WriteBytes(Out("b.klg"), "older");
    const auto result = RunWithFault(
        "read", n, Room(),
        "surfit_convert --last=2 --sequence=" + WholePath(Room()) + " --output=" + Out("b.klg"));
    if (!result) break;
    if (result->exit_code == 0) {
      const bool skips = result->err.find("skipped: ") != std::string::npos;
      EXPECT_EQ(OpenSequence(OptionsOf(Out("b.klg")))->info().frame_count, skips ? 2 : 3) << n;
      skipped += skips ? 1 : 0;
    } else {
      EXPECT_EQ(ReadBytes(Out("b.klg")), "older");
      ++refused;
    }
  }
  EXPECT_GE(skipped, 4);
  EXPECT_GE(refused, 2);
}

}  // namespace
}  // namespace surfit::testing
