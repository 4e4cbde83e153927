#include <filesystem>

#include "apps/scan/job_files.h"
#include "apps/scan/scan_jobs.h"
#include "apps/scan/scan_plan.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

namespace fs = std::filesystem;

}  // namespace

void DeleteStaleReceipts(const std::string& scan, bool retry_failed) {
  const ScanPlan plan = ReadScanPlan(scan);
  const auto has = [&](const std::string& job) { return fs::exists(ReceiptPath(scan, job)); };
  const auto forget = [&](const std::string& job) { fs::remove(ReceiptPath(scan, job)); };
  DeleteReceipts(scan, retry_failed);
  for (const ScanFragment& fragment : plan.fragments) {
    const std::string job = "fragment_" + fragment.name;
    if (plan.camera_frames > 0 && !has(Concat("camera_", fragment.recording))) forget(job);
    if (!has(job)) forget("candidates");
  }
  if (!has("candidates")) forget("graph");
  for (const std::string& pair : FilesIn(scan + "/candidates", ".json")) {
    if (!has("link_" + fs::path(pair).stem().string())) forget("graph");
  }
  // The report job always runs again.
  fs::remove(scan + "/summary.json");
}

}  // namespace surfit
