#include "common/flag_file.h"

#include <fstream>
#include <optional>

#include "surfit/core/error.h"

namespace surfit::tools {
namespace {

bool IsFlagFileFlag(const std::string& argument) {
  return argument == "--flagfile" || argument == "-flagfile";
}

// The file of --flagfile=F.
std::optional<std::string> FlagFileOf(const std::string& argument) {
  const std::size_t equals = argument.find('=');
  if (equals == argument.npos || !IsFlagFileFlag(argument.substr(0, equals))) return std::nullopt;
  return argument.substr(equals + 1);
}

std::string Trimmed(const std::string& line) {
  constexpr const char* kSpace = " \t\r";
  const std::size_t first = line.find_first_not_of(kSpace);
  if (first == line.npos) return "";
  return line.substr(first, line.find_last_not_of(kSpace) + 1 - first);
}

void AppendLines(const std::string& path, std::vector<std::string>* arguments) {
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    const std::string flag = Trimmed(line);
    if (flag.empty() || flag[0] == '#') continue;
    if (IsFlagFileFlag(flag) || FlagFileOf(flag)) {
      throw InputError(Concat("flagfile '", path, "' says ", flag, ", must not name another one"));
    }
    arguments->push_back(flag);
  }
  if (!file.eof()) throw InputError(Concat("flagfile '", path, "' cannot be read"));
}

}  // namespace

std::vector<std::string> ExpandFlagFiles(const std::vector<std::string>& arguments) {
  std::vector<std::string> expanded;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const bool next_is_file = IsFlagFileFlag(arguments[i]) && i + 1 < arguments.size();
    const auto path = next_is_file ? arguments[++i] : FlagFileOf(arguments[i]);
    if (path) {
      AppendLines(*path, &expanded);
    } else {
      expanded.push_back(arguments[i]);
    }
  }
  return expanded;
}

}  // namespace surfit::tools
