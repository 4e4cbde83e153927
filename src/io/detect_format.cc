#include "io/detect_format.h"

#include <algorithm>

#include "io/folder.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

bool HasNameEnding(const std::string& folder, const std::string& ending) {
  const auto names = NamesIn(folder);
  return std::any_of(names.begin(), names.end(),
                     [&](const std::string& name) { return EndsWith(name, ending); });
}

// ICL-NUIM numbers its frames from 0 or 1 without leading zeros.
bool HasIclNuimNumbers(const std::string& folder) {
  return (IsFile(folder + "/depth/0.png") || IsFile(folder + "/depth/1.png")) &&
         IsFolder(folder + "/rgb");
}

std::string DetectFolderFormat(const std::string& folder) {
  if (HasNameEnding(folder, ".depth.png")) return "seven_scenes";
  if (HasNameEnding(folder, ".gt.freiburg") || HasIclNuimNumbers(folder)) return "icl_nuim";
  for (const char* list : {"/associations.txt", "/depth.txt", "/rgb.txt"}) {
    if (IsFile(folder + list)) return "tum";
  }
  if (IsFile(folder + "/traj.txt") && IsFolder(folder + "/results")) return "replica";
  if (IsFolder(folder + "/depth")) return "redwood";
  throw InputError(Concat(
      folder, " holds no sequence of a known format: looked for depth.txt or associations.txt (",
      "tum), *.gt.freiburg or rgb/ with depth/0.png or depth/1.png (icl_nuim), frame-*.depth.png ",
      "(seven_scenes), depth/ (redwood), results/ with traj.txt (replica)"));
}

}  // namespace

const std::vector<std::string>& SequenceFormats() {
  static const auto* const formats = new std::vector<std::string>{
      "tum", "icl_nuim", "seven_scenes", "redwood", "replica", "klg", "sens", "watch"};
  return *formats;
}

bool IsFileFormat(const std::string& format) { return format == "klg" || format == "sens"; }

std::string DetectFormat(const std::string& path) {
  if (!IsFile(path)) return DetectFolderFormat(path);
  for (const char* format : {"klg", "sens", "watch"}) {
    if (EndsWith(path, std::string(".") + format)) return format;
  }
  throw InputError(path + " is no folder, and neither .klg nor .sens");
}

}  // namespace surfit
