#include "io/folder.h"

#include <algorithm>
#include <charconv>
#include <filesystem>

#include "core/read_file.h"

namespace surfit {
namespace fs = std::filesystem;

std::vector<std::string> NamesIn(const std::string& folder) {
  std::vector<std::string> names;
  std::error_code none;
  for (fs::directory_iterator it(folder, none), end; it != end; it.increment(none))
    names.push_back(it->path().filename().string());
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

bool EndsWith(const std::string& name, const std::string& ending) {
  return name.size() >= ending.size() &&
         name.compare(name.size() - ending.size(), ending.size(), ending) == 0;
}

std::optional<long> NumberInName(const std::string& name) {
  const std::size_t first = name.find_first_of("0123456789");
  if (first == name.npos) return std::nullopt;
  long number = 0;
  const auto result = std::from_chars(&name[first], name.data() + name.size(), number);
  if (result.ec != std::errc()) return std::nullopt;
  return number;
}

std::string FollowTextLink(const std::string& path) {
  constexpr std::uintmax_t kLongestLink = 4096;
  const fs::path folder = fs::path(path).parent_path();
  if (!IsFile(folder.string()) || fs::file_size(folder) > kLongestLink) return path;
  std::string target = ReadFile(folder.string());
  while (!target.empty() && (target.back() == '\n' || target.back() == '\r')) target.pop_back();
  const fs::path linked = folder.parent_path() / target;
  return IsFolder(linked.string()) ? (linked / fs::path(path).filename()).string() : path;
}

}  // namespace surfit
