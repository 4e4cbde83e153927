#include "apps/scan/batch.h"

#include <gmock/gmock.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "surfit/core/error.h"
#include "testing/matchers.h"
#include "testing/temp_folder.h"

namespace surfit::testing {
namespace {

namespace fs = std::filesystem;

class BatchTest : public ::testing::Test {
 protected:
  BatchTest() {
    options_.sequences = sequences_.path();
    options_.output = batch_.path();
  }

  void Sequence(const std::string& name) const { fs::create_directories(sequences_ / name); }
  void Receipt(const std::string& name, int exit, const std::string& error) const {
    const nlohmann::json json = {
        {"job", "run_" + name}, {"exit", exit},   {"seconds", 1.5},
        {"peak_mb", 20},        {"error", error}, {"product", "runs/" + name + "/summary.json"}};
    batch_.Write("jobs/run_" + name + ".json", json.dump());
  }
  bool HasReceipt(const std::string& name) const {
    return fs::exists(batch_ / ("jobs/run_" + name + ".json"));
  }

  const TempFolder sequences_, batch_;
  BatchOptions options_;
};

TEST_F(BatchTest, AcceptsFoldersAndRecordingsWithSafeNames) {
  Sequence("b $x");
  Sequence(".hidden");
  sequences_.Write("a-1.klg", "");
  sequences_.Write("notes.txt", "");
  options_.run.sequence.stride = 3;
  options_.run.slam.loops.enabled = false;
  const std::vector<BatchRun> runs = PlanBatch(options_);
  ASSERT_EQ(runs.size(), 2u);
  EXPECT_EQ(runs[0].name, "a-1.klg");
  EXPECT_EQ(runs[1].name, "b%20%24x");
  const std::string path = fs::path(sequences_ / "b $x").lexically_normal();
  EXPECT_EQ(runs[1].path, path);
  EXPECT_EQ(ReadBytes(batch_ / "flags/b%20%24x.flags"),
            "--loop_closure=false\n--sequence=" + path + "\n--stride=3\n");
}

TEST_F(BatchTest, RewritesOnlyChangedFlags) {
  Sequence("one");
  PlanBatch(options_);
  const std::string flags = batch_ / "flags/one.flags";
  const auto time = fs::last_write_time(flags);
  Sequence("two");
  PlanBatch(options_);
  EXPECT_EQ(fs::last_write_time(flags), time);
  options_.run.sequence.stride = 2;
  PlanBatch(options_);
  EXPECT_NE(fs::last_write_time(flags), time);
}

TEST_F(BatchTest, RejectsFoldersWithoutSequences) {
  EXPECT_THROW(PlanBatch(options_), InputError);  // empty folder
  Sequence("one");
  options_.output = sequences_ / "one";
  EXPECT_THROW(PlanBatch(options_), InputError);
  options_.output = batch_.path();
  options_.run.sequence.format = "watch";
  EXPECT_THROW(PlanBatch(options_), InputError);
  options_.run.sequence.format = "auto";
  options_.sequences = batch_ / "none";
  EXPECT_THROW(PlanBatch(options_), InputError);
}

TEST_F(BatchTest, WritesARowForEachSequence) {
  for (const char* const name : {"done", "failed", "open"}) Sequence(name);
  PlanBatch(options_);
  Receipt("done", 0, "");
  batch_.Write("runs/done/summary.json",
               R"({"frames_total": 10, "frames_tracked": 9, "frames_lost": 1, "frames_skipped": 0,
                   "ate_rmse_m": 0.0125, "rpe_translation_rmse_m": null, "map_points": 5,
                   "frame_ms": {"mean": 7.5}, "digest": "12ab"})");
  Receipt("failed", 1, "error: a \"b\", <c>");
  const std::vector<BatchRow> rows = ReportBatch(batch_.path());
  ASSERT_EQ(rows.size(), 3u);
  EXPECT_EQ(rows[0].state, "done");
  EXPECT_EQ(rows[0].frames_tracked, 9);
  EXPECT_EQ(rows[0].ate_rmse_m, 0.0125);
  EXPECT_FALSE(rows[0].rpe_translation_rmse_m.has_value());
  EXPECT_EQ(rows[0].frame_ms, 7.5);
  EXPECT_EQ(rows[1].state, "failed");
  EXPECT_EQ(rows[1].seconds, 1.5);
  EXPECT_EQ(rows[2].state, "open");
  EXPECT_THAT(
      ReadBytes(batch_ / "table.csv"),
      StartsWith("sequence,state,frames,frames_tracked,frames_lost,frames_skipped,ate_rmse_m,"
                 "rpe_translation_rmse_m,rpe_rotation_rmse_deg,seconds,frame_ms,peak_mb,map_points,"
                 "digest,error\n"
                 "done,done,10,9,1,0,0.0125,,,1.5,7.5,20.0,5.0,12ab,\n"
                 "failed,failed,,,,,,,,1.5,,20.0,,,\"error: a \"\"b\"\", <c>\"\n"
                 "open,open,,,,,,,,,,,,,"));
  const auto summary = nlohmann::json::parse(ReadBytes(batch_ / "summary.json"));
  EXPECT_EQ(summary["done"], 1);
  EXPECT_EQ(summary["failed"], 1);
  EXPECT_EQ(summary["open"], 1);
  EXPECT_EQ(summary["runs"][0]["digest"], "12ab");
  EXPECT_THAT(ReadBytes(batch_ / "report.html"),
              AllOf(HasSubstr("failed: error: a &quot;b&quot;, &lt;c&gt;"),
                    HasSubstr("href=\"runs/done/summary.json\"")));
}

TEST_F(BatchTest, RepeatsMissingAndOnRequestFailedRuns) {
  for (const char* const name : {"done", "failed", "gone"}) Sequence(name);
  PlanBatch(options_);
  batch_.Write("runs/done/summary.json", "{}");
  Receipt("done", 0, "");
  Receipt("failed", 1, "error: x");
  Receipt("gone", 0, "");
  DeleteStaleRunReceipts(batch_.path(), false);
  EXPECT_TRUE(HasReceipt("done") && HasReceipt("failed"));
  EXPECT_FALSE(HasReceipt("gone"));
  DeleteStaleRunReceipts(batch_.path(), true);
  EXPECT_TRUE(HasReceipt("done"));
  EXPECT_FALSE(HasReceipt("failed"));
}

}  // namespace
}  // namespace surfit::testing
