// Every call of the system that short runs of surfit_optimize and surfit_convert make is let fail
// once.
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

// A program that reads a file and writes one or more others.
class FileFaultTest : public FaultTest {
 protected:
  FileFaultTest() {
    for (const char* name : {"from", "to"}) fs::create_directory(own_.path() + "/" + name);
  }
  std::string In() const { return WholePath(own_.path() + "/from"); }
  std::string Out(const std::string& name = "") const {
    return WholePath(own_.path() + "/to") + (name.empty() ? "" : "/" + name);
  }

  // The older files stay unless the new ones are there as a whole: all of them after an exit code
  // of 0. Each kind of call is one that writing makes.
  void ExpectOlderOrWholeWhicheverWriteFails(const std::string& command,
                                             const std::vector<std::string>& names) const {
    const std::vector<std::string> whole = Results(command, names);
    for (const char* kind : {"open", "write", "rename", "fsync", "malloc"}) {
      ExpectOlderOrWholeWhicheverFails(kind, Out(), command, names, whole);
    }
  }
  // The same for the calls that reading makes.
  void ExpectOlderOrWholeWhicheverReadFails(const std::string& command,
                                            const std::vector<std::string>& names) const {
    const std::vector<std::string> whole = Results(command, names);
    for (const char* kind : {"open", "read", "malloc"}) {
      ExpectOlderOrWholeWhicheverFails(kind, In(), command, names, whole);
    }
  }

 private:
  // What the files hold after a run without faults.
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

TEST_F(FileFaultTest, OptimizeKeepsTheOlderFileWhicheverCallFails) {
  WriteG2o(MakeGrid(6).graph, In() + "/a.g2o");
  const std::string command = "surfit_optimize --graph=" + In() + "/a.g2o --output=" + Out("b.g2o");
  ExpectOlderOrWholeWhicheverWriteFails(command, {"b.g2o"});
  ExpectOlderOrWholeWhicheverReadFails(command, {"b.g2o"});
}

TEST_F(FileFaultTest, ConvertKeepsTheOlderFileWhicheverCallFails) {
  PointCloud cloud;
  cloud.points.resize(20000, {1, 2, 3});
  WritePly(cloud, In() + "/a.ply");
  const std::string convert = "surfit_convert --cloud=" + In() + "/a.ply --output=";
  ExpectOlderOrWholeWhicheverReadFails(convert + Out("b.pcd"), {"b.pcd"});
  ExpectOlderOrWholeWhicheverWriteFails(convert + Out("b.pcd"), {"b.pcd"});
  fs::remove(Out("b.pcd"));
  ExpectOlderOrWholeWhicheverWriteFails(convert + Out("b.ply"), {"b.ply"});
}

TEST_F(FileFaultTest, ConvertKeepsTheOlderPosesWhicheverCallFails) {
  WriteTumTrajectory(Trajectory(2000), In() + "/a.txt");
  const std::string command =
      "surfit_convert --trajectory=" + In() + "/a.txt --output=" + Out("b.txt");
  ExpectOlderOrWholeWhicheverWriteFails(command, {"b.txt"});
  ExpectOlderOrWholeWhicheverReadFails(command, {"b.txt"});
}

TEST_F(FileFaultTest, ConvertKeepsTheOlderRecordingWhicheverCallFails) {
  ExpectOlderOrWholeWhicheverWriteFails(
      "surfit_convert --last=2 --sequence=" + WholePath(Room()) + " --output=" + Out("b.klg"),
      {"b.klg", "b.klg.yaml"});
}

// A frame that cannot be read is left out, and told.
TEST_F(FileFaultTest, ConvertSkipsFramesAndRefusesListsThatCannotBeRead) {
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
