#include <algorithm>
#include <array>
#include <cctype>
#include <cstdio>
#include <filesystem>

#include "apps/scan/batch.h"
#include "apps/scan/job_files.h"
#include "io/files/output_folder.h"
#include "output/output_files.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"

namespace surfit {
namespace {

namespace fs = std::filesystem;

bool IsSequence(const fs::directory_entry& entry) {
  constexpr std::array kRecordings = {".klg", ".sens", ".bag", ".db3", ".mcap"};
  const fs::path path = entry.path();
  if (path.filename().string()[0] == '.') return false;
  std::error_code none;
  return entry.is_directory(none) ||
         std::find(kRecordings.begin(), kRecordings.end(), path.extension()) != kRecordings.end();
}

// Escapes characters that are special in shells, Snakemake or URLs.
std::string RunNameOf(const std::string& file_name) {
  std::string name;
  for (const char c : file_name) {
    const auto byte = static_cast<unsigned char>(c);
    const bool is_plain = byte < 128 && (std::isalnum(byte) || c == '.' || c == '-' || c == '_');
    std::array<char, 4> code = {c, '\0'};
    if (!is_plain) std::snprintf(code.data(), code.size(), "%%%02X", byte);
    name += code.data();
  }
  return name;
}

std::vector<BatchRun> FindSequences(const BatchOptions& options) {
  std::vector<BatchRun> runs;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(options.sequences, error)) {
    if (!IsSequence(entry)) continue;
    std::error_code none;
    ThrowIf(fs::equivalent(entry.path(), options.output, none), "output is '", options.output,
            "', which is in the folder of the ", "sequences, must be another folder");
    runs.push_back({RunNameOf(entry.path().filename()), AbsolutePath(entry.path())});
  }
  if (error) throw InputError(options.sequences, ": ", error.message());
  ThrowIf(runs.empty(), options.sequences, ": contains no folders and no recordings");
  std::sort(runs.begin(), runs.end(),
            [](const BatchRun& a, const BatchRun& b) { return a.name < b.name; });
  return runs;
}

}  // namespace

std::vector<BatchRun> PlanBatch(const BatchOptions& options) {
  Validate(options);
  const std::vector<BatchRun> runs = FindSequences(options);
  CreateFolder(options.output + "/flags");
  Json names = Json::array();
  for (const BatchRun& each : runs) {
    SlamRunOptions run = options.run;
    run.sequence.path = each.path;
    run.sequence = WithAbsolutePaths(run.sequence);
    WriteIfChanged(FlagFileOf(run), Concat(options.output, "/flags/", each.name, ".flags"));
    names.push_back(each.name);
  }
  const Json json = {{"sequences", AbsolutePath(options.sequences)},
                     {"runs", names},
                     {"threads", options.run.threads}};
  WriteIfChanged(json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n",
                 options.output + "/batch.json");
  return runs;
}

}  // namespace surfit
