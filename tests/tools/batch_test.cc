// Complete batches with Snakemake.
#include <gmock/gmock.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "testing/matchers.h"
#include "testing/run_program.h"
#include "testing/temp_folder.h"

namespace surfit::testing {
namespace {

namespace fs = std::filesystem;

class BatchTool : public ::testing::Test {
 protected:
  void SetUp() override {
    if (RunShell("command -v snakemake").exit_code != 0)
      GTEST_SKIP() << "Snakemake is not installed";
  }
  std::string Sequences() const { return folder_.path() + "/sequences"; }
  std::string Batch() const { return folder_.path() + "/batch"; }
  void Simulate(const std::string& name, int frames) const {
    Succeeded(
        RunProgram("surfit_simulate", {"--output=" + Sequences() + "/" + name, "--downsample=8",
                                       "--frames=" + std::to_string(frames)}));
  }
  ProgramResult Run(std::vector<std::string> more) const {
    more.insert(more.begin(), {"--sequences=" + Sequences(), "--output=" + Batch(), "--nopictures",
                               "--nofinal_map", "--nocalibrate"});
    return RunProgram("surfit_batch", more);
  }
  nlohmann::json Rows() const {
    return nlohmann::json::parse(ReadBytes(Batch() + "/summary.json"))["runs"];
  }

  TempFolder folder_;
};

TEST_F(BatchTool, ContinuesAfterAFailedRun) {
  Simulate("long", 12);
  Simulate("short & strange", 6);
  fs::create_directories(Sequences() + "/none");
  const ProgramResult result = Run({"--cores=2"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasWarning("none"));
  nlohmann::json rows = Rows();
  ASSERT_EQ(rows.size(), 3u);
  EXPECT_EQ(rows[0]["sequence"], "long");
  EXPECT_EQ(rows[0]["frames_tracked"], 12);
  EXPECT_LT(rows[0]["ate_rmse_m"].get<double>(), 0.02);
  EXPECT_EQ(rows[1]["state"], "failed");
  EXPECT_EQ(rows[2]["sequence"], "short%20%26%20strange");
  EXPECT_EQ(rows[2]["frames"], 6);
  // A run in a batch has the same result as a separate run.
  const std::string alone = folder_.path() + "/alone";
  Succeeded(RunProgram("surfit_slam", {"--sequence=" + Sequences() + "/long", "--output=" + alone,
                                       "--nopictures", "--nofinal_map", "--nocalibrate"}));
  EXPECT_EQ(rows[0]["digest"], nlohmann::json::parse(ReadBytes(alone + "/summary.json"))["digest"]);
  // After the missing sequence is added, only its run is executed.
  const auto time = fs::last_write_time(Batch() + "/jobs/run_long.json");
  Simulate("none", 6);
  EXPECT_EQ(Run({}).exit_code, 2);
  Succeeded(Run({"--retry_failed"}));
  EXPECT_EQ(Rows()[1]["frames_tracked"], 6);
  EXPECT_EQ(fs::last_write_time(Batch() + "/jobs/run_long.json"), time);
}

TEST_F(BatchTool, RejectsBadInput) {
  fs::create_directories(Sequences());
  ExpectRefused(Run({}), Sequences());
  ExpectRefused(Run({"--profile=nowhere"}), "profile", "nowhere");
  ExpectRefused(Run({"--format=watch"}), "format", "watch");
  ExpectRefused(RunProgram("surfit_batch", {"--sequences=" + Sequences()}), "output");
  ExpectRefused(Run({"--output=" + Sequences()}), "--sequences", Sequences());
}

}  // namespace
}  // namespace surfit::testing
