#include "io/sequences/folder.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <filesystem>
#include <limits>
#include <utility>

#include "core/files.h"
#include "io/files/text.h"
#include "io/stamps/image_names.h"
#include "surfit/core/error.h"

namespace surfit {

namespace fs = std::filesystem;

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

// Folder of Polycam, or its folder keyframes/.
bool IsPolycam(const std::string& folder) {
  for (const std::string& root : {folder + "/keyframes", folder}) {
    if (IsFolder(root + "/depth") && (HasNameEnding(root + "/cameras", ".json") ||
                                      HasNameEnding(root + "/corrected_cameras", ".json")))
      return true;
  }
  return false;
}

// Export "EXR + JPG sequence" of Record3D: the folder, or its folder EXR_RGBD/.
bool IsRecord3d(const std::string& folder) {
  for (const std::string& root : {folder + "/EXR_RGBD", folder}) {
    if (IsFile(root + "/metadata.json") && IsFolder(root + "/rgb") &&
        HasNameEnding(root + "/depth", ".exr"))
      return true;
  }
  return false;
}

// Record3D's own files have depth that is compressed by LZFSE, which no library of Debian reads.
[[noreturn]] void RejectLzfse(const std::string& path) {
  throw InputError(path,
                   " has depth compressed by LZFSE, which is not supported: export the video ",
                   "as EXR + JPG sequence in Record3D");
}

bool IsStrayScanner(const std::string& folder) {
  return IsFile(folder + "/odometry.csv") && IsFolder(folder + "/depth") &&
         (IsFile(folder + "/rgb.mp4") || IsFile(folder + "/camera_matrix.csv"));
}

std::string DetectFolderFormat(const std::string& folder) {
  if (HasNameEnding(folder, ".depth.png")) return "seven_scenes";
  if (HasNameEnding(folder, ".gt.freiburg") || HasIclNuimNumbers(folder)) return "icl_nuim";
  for (const char* list : {"/associations.txt", "/depth.txt", "/rgb.txt"}) {
    if (IsFile(folder + list)) return "tum";
  }
  if (IsFile(folder + "/traj.txt") && IsFolder(folder + "/results")) return "replica";
  if (IsFile(folder + "/transforms.json")) return "nerfstudio";
  if (IsStrayScanner(folder)) return "stray_scanner";
  if (IsFolder(folder + "/lowres_depth")) return "arkit_scenes";
  if (IsPolycam(folder)) return "polycam";
  if (IsRecord3d(folder)) return "record3d";
  if (HasNameEnding(folder + "/rgbd", ".depth")) RejectLzfse(folder + "/rgbd");
  if (IsFolder(folder + "/depth")) return "redwood";
  if (IsFile(folder + "/metadata.yaml")) {
    for (const char* format : {"db3", "mcap"}) {
      if (HasNameEnding(folder, std::string(".") + format)) return format;
    }
  }
  throw InputError(
      folder, " has no sequence of a known format: looked for depth.txt or associations.txt (",
      "tum), *.gt.freiburg or rgb/ with depth/0.png or depth/1.png (icl_nuim), frame-*.depth.png ",
      "(seven_scenes), depth/ (redwood), results/ with traj.txt (replica), transforms.json ",
      "(nerfstudio), odometry.csv with rgb.mp4 (stray_scanner), ", "lowres_depth/ (arkit_scenes), ",
      "keyframes/cameras/*.json (polycam), ", "metadata.json with depth/*.exr (record3d), ",
      "metadata.yaml with *.db3 or *.mcap");
}

// Number of ".." in the normalised path. Maximum of int for an absolute path.
int Beyond(const fs::path& path) {
  if (path.is_absolute()) return std::numeric_limits<int>::max();
  int above = 0;
  for (const fs::path& part : path.lexically_normal()) above += part == "..";
  return above;
}

}  // namespace

std::vector<std::string> NamesIn(const std::string& folder) {
  std::vector<std::string> names;
  std::error_code none;
  for (fs::directory_iterator it(folder, none), end; it != end; it.increment(none)) {
    std::string name = it->path().filename().string();
    if (name.compare(0, 2, "._") != 0) names.push_back(std::move(name));
  }
  std::sort(names.begin(), names.end());
  return names;
}

bool IsFolder(const std::string& path) {
  std::error_code none;
  return fs::is_directory(path, none);
}

bool IsFile(const std::string& path) {
  std::error_code none;
  return fs::is_regular_file(path, none);
}

bool HasFile(const std::string& path) {
  std::error_code none;
  if (fs::is_regular_file(path, none)) return true;
  if (!fs::exists(fs::symlink_status(path, none))) return false;
  throw InputError(path, " is not a regular file");
}

bool EndsWith(const std::string& name, const std::string& ending) {
  return name.size() >= ending.size() &&
         name.compare(name.size() - ending.size(), ending.size(), ending) == 0;
}

bool IsImageName(const std::string& name) {
  constexpr std::array kEndings = {".png",  ".jpg",  ".jpeg", ".pgm",  ".ppm",  ".tif",
                                   ".tiff", ".exr",  ".npy",  ".webp", ".heic", ".heif",
                                   ".bmp",  ".avif", ".jxl",  ".jp2"};
  std::string lower = name;
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return std::any_of(kEndings.begin(), kEndings.end(),
                     [&](const char* ending) { return EndsWith(lower, ending); });
}

std::optional<long> NumberInName(const std::string& name) {
  const std::size_t first = name.find_first_of("0123456789");
  if (first == name.npos) return std::nullopt;
  long number = 0;
  const auto result = std::from_chars(&name[first], name.data() + name.size(), number);
  if (result.ec != std::errc()) return std::nullopt;
  return number;
}

std::optional<double> StampInName(const std::string& name) {
  const auto time = TimeInName(name);
  return time ? std::optional<double>(FiniteNumber(*time)) : std::nullopt;
}

std::string FollowTextLink(const std::string& folder, const std::string& name) {
  constexpr std::uintmax_t kLongestLink = 4096;
  const fs::path path = fs::path(folder) / name, link = path.parent_path();
  if (!IsFile(link.string()) || fs::file_size(link) > kLongestLink) return path.string();
  std::string target = ReadFile(link.string());
  while (!target.empty() && (target.back() == '\n' || target.back() == '\r')) target.pop_back();
  const fs::path at_sequence = fs::path(name).parent_path().parent_path() / target;
  if (Beyond(at_sequence) > 1) {
    throw InputError(link.string(), ": the link to '", target,
                     "' leaves the parent folder of the sequence");
  }
  const fs::path linked = fs::path(folder) / at_sequence;
  return IsFolder(linked.string()) ? (linked / path.filename()).string() : path.string();
}

const std::vector<std::string>& SequenceFormats() {
  static const auto* const formats = new std::vector<std::string>{
      "tum",        "icl_nuim",      "seven_scenes", "redwood", "replica",
      "nerfstudio", "stray_scanner", "arkit_scenes", "polycam", "record3d",
      "klg",        "sens",          "bag",          "db3",     "mcap",
      "oni",        "mkv",           "watch",        "openni2"};
  return *formats;
}

bool IsBag(const std::string& format) {
  return format == "bag" || format == "db3" || format == "mcap";
}

bool MayBeFile(const std::string& format) {
  return format == "klg" || format == "sens" || format == "oni" || format == "mkv" || IsBag(format);
}

bool MayBeFolder(const std::string& format) {
  return !MayBeFile(format) || format == "db3" || format == "mcap";
}

std::string DetectFormat(const std::string& path) {
  if (!IsFile(path)) return DetectFolderFormat(path);
  for (const char* format : {"klg", "sens", "bag", "db3", "mcap", "oni", "mkv"}) {
    if (EndsWith(path, std::string(".") + format)) return format;
  }
  if (EndsWith(path, ".r3d")) RejectLzfse(path);
  throw InputError(path,
                   " is neither a folder nor a .klg, .sens, .bag, .db3, .mcap, .oni or .mkv file");
}

}  // namespace surfit
