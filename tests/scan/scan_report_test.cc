#include <gmock/gmock.h>

#include <filesystem>

#include "apps/scan/scan_jobs.h"
#include "apps/scan/scan_plan.h"
#include "surfit/core/error.h"
#include "testing/matchers.h"
#include "testing/sequence_writer.h"
#include "testing/temp_folder.h"

namespace surfit::testing {
namespace {

class ScanReportTest : public ::testing::Test {
 protected:
  ScanReportTest() {
    WriteTumSequence(sequence_, 3);
    ScanPlanOptions options;
    options.sequences = {sequence_.path()};
    options.run.output = scan_.path();
    PlanScan(options);
  }
  void Receipt(const std::string& job, int exit, const std::string& product) const {
    scan_.Write("jobs/" + job + ".json",
                Concat(R"({"job": ")", job, R"(", "exit": )", exit,
                       R"(, "seconds": 1.5, "peak_mb": 20, "error": ")",
                       exit == 0 ? "" : "error: a < b", R"(", "product": ")", product, "\"}"));
  }

  const TempFolder sequence_, scan_;
};

TEST_F(ScanReportTest, ListsFailedJobsWithoutOtherResults) {
  Receipt("fragment_0000", 1, "fragments/0000/places.bin");
  Receipt("fragment_0009", 1, "fragments/0009/places.bin");  // receipt of a former plan
  ScanReportOptions options;
  options.scan = scan_.path();
  const ScanSummary summary = ReportScan(options);
  EXPECT_THAT(summary.failed, ElementsAre("fragment_0000: error: a < b"));
  EXPECT_THAT(ReadScanSummary(scan_.path()).failed, summary.failed);
  EXPECT_EQ(summary.frames, 0);
  EXPECT_THAT(ReadBytes(scan_ / "report.html"), HasSubstr("fragment_0000: error: a &lt; b"));
}

TEST_F(ScanReportTest, ForgetsRepeatedJobsAndTheirDependents) {
  const auto has = [&](const std::string& job) {
    return std::filesystem::exists(scan_ / ("jobs/" + job + ".json"));
  };
  const auto all_done = [&] {
    Receipt("camera_0", 0, "camera/0/summary.json");
    Receipt("fragment_0000", 0, "fragments/0000/places.bin");
    Receipt("candidates", 0, "");
    Receipt("link_0000_0001", 1, "links/0000_0001.json");
    Receipt("graph", 0, "graph/graph.json");
    for (const char* const file : {"camera/0/summary.json", "fragments/0000/places.bin",
                                   "candidates/0000_0001.json", "graph/graph.json"}) {
      scan_.Write(file, "");
    }
  };
  all_done();
  DeleteStaleReceipts(scan_.path(), false);
  EXPECT_TRUE(has("camera_0") && has("fragment_0000") && has("candidates") &&
              has("link_0000_0001") && has("graph"));
  DeleteStaleReceipts(scan_.path(), true);
  EXPECT_TRUE(has("camera_0") && has("fragment_0000") && has("candidates"));
  EXPECT_FALSE(has("link_0000_0001") || has("graph"));
  all_done();
  std::filesystem::remove(scan_ / "fragments/0000/places.bin");
  DeleteStaleReceipts(scan_.path(), false);
  EXPECT_TRUE(has("camera_0") && has("link_0000_0001"));
  EXPECT_FALSE(has("fragment_0000") || has("candidates") || has("graph"));
  all_done();
  std::filesystem::remove(scan_ / "camera/0/summary.json");
  DeleteStaleReceipts(scan_.path(), false);
  EXPECT_FALSE(has("camera_0") || has("fragment_0000") || has("candidates") || has("graph"));
}

TEST_F(ScanReportTest, RejectsAMalformedReceipt) {
  scan_.Write("jobs/graph.json", "{}");
  EXPECT_THAT([&] { DeleteStaleReceipts(scan_.path(), false); },
              ThrowsNaming<InputError>("graph.json"));
}

}  // namespace
}  // namespace surfit::testing
