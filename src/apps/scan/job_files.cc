#include "apps/scan/job_files.h"

#include <algorithm>
#include <filesystem>

#include "core/files.h"
#include "output/output_files.h"
#include "surfit/core/atomic_file.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"

namespace surfit {
namespace {

namespace fs = std::filesystem;

}  // namespace

void WriteIfChanged(const std::string& text, const std::string& path) {
  if (fs::is_regular_file(path) && ReadFile(path) == text) return;
  WriteFileAtomically(path, [&](std::ostream& file) { file << text; });
}

std::vector<std::string> FilesIn(const std::string& folder, const std::string& extension) {
  std::vector<std::string> paths;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    if (entry.path().extension() == extension) paths.push_back(entry.path().string());
  }
  std::sort(paths.begin(), paths.end());
  return paths;
}

std::string AbsolutePath(const std::string& path) {
  return fs::absolute(path).lexically_normal().string();
}

SequenceOptions WithAbsolutePaths(SequenceOptions sequence) {
  sequence.path = AbsolutePath(sequence.path);
  // `camera` is the name of a preset if there is no such file.
  if (fs::exists(sequence.camera)) sequence.camera = AbsolutePath(sequence.camera);
  return sequence;
}

std::string FlagFileOf(const SlamRunOptions& run, const SlamRunOptions& other) {
  const std::map<std::string, std::string> others = FlagValues(other);
  std::string text;
  for (const auto& [name, value] : FlagValues(run)) {
    if (name != "output" && others.at(name) != value) text += Concat("--", name, "=", value, "\n");
  }
  return text;
}

std::string FlagFileOf(const SlamRunOptions& run) { return FlagFileOf(run, SlamRunOptions()); }

std::string ReceiptPath(const std::string& folder, const std::string& job) {
  return Concat(folder, "/jobs/", job, ".json");
}

JobReceipt ReadReceipt(const std::string& path) {
  const Json json = ReadJson(path);
  try {
    return {json.at("job"),     json.at("exit"),  json.at("seconds"),
            json.at("peak_mb"), json.at("error"), json.at("product")};
  } catch (const Json::exception& error) {
    throw InputError(Concat(path, ": invalid job receipt: ", error.what()));
  }
}

void DeleteReceipts(const std::string& folder, bool retry_failed) {
  for (const std::string& path : FilesIn(folder + "/jobs", ".json")) {
    const JobReceipt receipt = ReadReceipt(path);
    const bool has_failed = receipt.exit != 0;
    const bool is_gone = !has_failed && !receipt.product.empty() &&
                         !fs::exists(Concat(folder, "/", receipt.product));
    if (is_gone || (has_failed && retry_failed)) fs::remove(path);
  }
}

}  // namespace surfit
