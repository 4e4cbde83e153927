#include "scan/receipts.h"

#include <filesystem>

#include "run/output_files.h"
#include "scan/link_file.h"
#include "surfit/core/error.h"
#include "surfit/scan/scan_jobs.h"
#include "surfit/scan/scan_plan.h"

namespace surfit {
namespace {

namespace fs = std::filesystem;

std::string ReceiptOf(const std::string& scan, const std::string& job) {
  return Concat(scan, "/jobs/", job, ".json");
}

}  // namespace

Receipt ReadReceipt(const std::string& path) {
  const Json json = ReadJson(path);
  try {
    return {json.at("job"),     json.at("exit"),  json.at("seconds"),
            json.at("peak_mb"), json.at("error"), json.at("product")};
  } catch (const Json::exception& error) {
    throw InputError(Concat(path, ": no receipt of a job: ", error.what()));
  }
}

void ForgetJobs(const std::string& scan, bool retry_failed) {
  const ScanPlan plan = ReadScanPlan(scan);
  const auto has = [&](const std::string& job) { return fs::exists(ReceiptOf(scan, job)); };
  const auto forget = [&](const std::string& job) { fs::remove(ReceiptOf(scan, job)); };
  for (const std::string& path : FilesIn(scan + "/jobs", ".json")) {
    const Receipt receipt = ReadReceipt(path);
    const bool has_failed = receipt.exit != 0;
    const bool is_gone =
        !has_failed && !receipt.product.empty() && !fs::exists(Concat(scan, "/", receipt.product));
    if (is_gone || (has_failed && retry_failed)) fs::remove(path);
  }
  const bool lacks_camera = plan.camera_frames > 0 && !has("camera");
  for (const ScanFragment& fragment : plan.fragments) {
    const std::string job = "fragment_" + fragment.name;
    if (lacks_camera) forget(job);
    if (!has(job)) forget("candidates");
  }
  if (!has("candidates")) forget("graph");
  for (const std::string& pair : FilesIn(scan + "/candidates", ".json")) {
    if (!has("link_" + fs::path(pair).stem().string())) forget("graph");
  }
  // That is quickly made, and so always anew.
  fs::remove(scan + "/summary.json");
}

}  // namespace surfit
