#include "common/command_line.h"

#include <gflags/gflags.h>
#include <glog/logging.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <optional>
#include <sstream>
#include <utility>

#include "core/shared_options.h"
#include "surfit/core/error.h"

namespace google {
// Exit function of gflags. The library exports it for its own tests, without a header.
extern void (*gflags_exitfunc)(int);
}  // namespace google

namespace surfit::tools {
namespace {

bool IsFlagFileFlag(const std::string& argument) {
  return argument == "--flagfile" || argument == "-flagfile";
}

// Returns F of --flagfile=F; std::nullopt for other arguments.
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
  constexpr std::streamsize kMost = 1 << 20;  // bytes
  std::ifstream file(path);
  std::string text(kMost, '\0');
  file.read(text.data(), kMost);
  if (!file.eof())
    throw InputError(Concat("flagfile '", path, "' cannot be read, or is too large"));
  text.resize(static_cast<std::size_t>(file.gcount()));
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const std::string flag = Trimmed(line);
    if (flag.empty() || flag[0] == '#') continue;
    if (IsFlagFileFlag(flag) || FlagFileOf(flag)) {
      throw InputError(
          Concat("flagfile '", path, "' contains ", flag, ", must not include another flag file"));
    }
    arguments->push_back(flag);
  }
}

std::string InFlagsWords(const std::string& argument) {
  static const std::string kHelp = "--help=";
  if (argument == "-h") return "--help";
  if (argument == "--serve" || argument == "-serve") return "--serve=0";  // any free port
  const std::string value = argument.rfind(kHelp, 0) == 0 ? argument.substr(kHelp.size()) : "";
  const bool is_group =
      std::any_of(value.begin(), value.end(), [](char c) { return c >= 'a' && c <= 'z'; }) &&
      value != "true" && value != "false" && value != "yes" && value != "no";
  if (!is_group) return argument;
  return value == "all" ? "--helpfull" : "--helpon=" + value;
}

// Edit distance with insertions, deletions, changes, and swaps of neighbouring letters (optimal
// string alignment).
std::size_t Distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> before, above, row(b.size() + 1);
  std::iota(row.begin(), row.end(), 0);
  for (std::size_t i = 1; i <= a.size(); ++i) {
    before = std::exchange(above, row);
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t changed = above[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      row[j] = std::min({changed, above[j] + 1, row[j - 1] + 1});
      const bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (swapped) row[j] = std::min(row[j], before[j - 2] + 1);
    }
  }
  return row.back();
}

// Most similar flag of an unknown name, or the only flag that starts with the name. Empty if there
// is none.
std::string Meant(const std::string& name, const std::vector<FlagHelp>& flags) {
  std::string nearest;
  std::size_t least = (name.size() + 1) / 3 + 1;
  std::vector<std::string> begun;
  for (const FlagHelp& flag : flags) {
    if (flag.name.rfind(name, 0) == 0) begun.push_back(flag.name);
    for (const std::string& known : {flag.name, "no" + flag.name}) {
      if (known != flag.name && !flag.is_switch) continue;
      const std::size_t distance = Distance(name, known);
      if (distance >= least) continue;
      least = distance;
      nearest = known;
    }
  }
  return nearest.empty() && begun.size() == 1 ? begun[0] : nearest;
}

// Joins the error lines of gflags to a sentence, and suggests flags for unknown names.
std::string Sentence(const std::string& message, const std::vector<FlagHelp>& flags,
                     const UnknownFlag& unknown) {
  static const std::string kError = "ERROR: ", kUnknown = "unknown command line flag '";
  std::string sentence;
  std::istringstream lines(message);
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind(kError, 0) == 0) line = line.substr(kError.size());
    if (line.empty()) continue;
    if (line.rfind(kUnknown, 0) == 0) {
      const std::string name =
          line.substr(kUnknown.size(), line.find('\'', kUnknown.size()) - kUnknown.size());
      const std::string known = unknown(name), meant = Meant(name, flags);
      if (!known.empty()) {
        line = known;
      } else if (!meant.empty()) {
        line += ", did you mean --" + meant + "?";
      }
    }
    sentence += (sentence.empty() ? "" : "; ") + line;
  }
  return sentence;
}

// gflags exits after an error message. This exception replaces the exit.
struct GflagsExit {};

// Returns the error messages of gflags; empty if all flags are valid. Other arguments stay in argv.
std::string LetGflagsParse(int* argc, char*** argv) {
  char* text = nullptr;
  std::size_t size = 0;
  std::FILE* const terminal = stderr;
  stderr = open_memstream(&text, &size);
  google::gflags_exitfunc = [](int) { throw GflagsExit(); };
  bool failed = false;
  try {
    gflags::ParseCommandLineNonHelpFlags(argc, argv, /*remove_flags=*/true);
  } catch (const GflagsExit&) {
    failed = true;
  }
  std::fclose(stderr);
  stderr = terminal;
  const std::string message(text, size);
  std::free(text);
  return failed ? message : "";
}

void RejectArgument(const std::string& argument, const std::vector<FlagHelp>& flags) {
  std::string sentence = Concat("unexpected argument '", argument, "', flags begin with --");
  const bool takes_sequence = std::any_of(
      flags.begin(), flags.end(), [](const FlagHelp& flag) { return flag.name == "sequence"; });
  std::error_code none;
  if (takes_sequence && std::filesystem::exists(argument, none)) {
    sentence += "; did you mean --sequence=" + argument + "?";
  }
  throw InputError(sentence);
}

std::string Value(const char* flag) {
  std::string value;
  gflags::GetCommandLineOption(flag, &value);
  return value;
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

std::vector<std::string> WithPresentNames(std::vector<std::string> arguments) {
  for (std::string& argument : arguments) {
    const std::size_t begin = argument.find_first_not_of('-'), equals = argument.find('=');
    if (begin != 1 && begin != 2) continue;
    const std::string flag = argument.substr(begin, equals - begin);
    const bool is_negated = flag.rfind("no", 0) == 0 && PresentName(flag) == flag;
    const std::string no = is_negated ? "no" : "", name = flag.substr(no.size());
    const std::string present = PresentName(name);
    if (present == name) continue;
    LOG(WARNING) << "--" << no << name << " is an old name that version 0.3 drops: use --" << no
                 << present;
    argument = "--" + no + present + (equals == argument.npos ? "" : argument.substr(equals));
  }
  return arguments;
}

void ParseCommandLine(std::vector<std::string> arguments, const std::vector<FlagHelp>& flags,
                      const UnknownFlag& unknown) {
  std::vector<char*> pointers;
  pointers.reserve(arguments.size() + 1);
  for (std::string& argument : arguments) {
    argument = InFlagsWords(argument);
    pointers.push_back(argument.data());
  }
  pointers.push_back(nullptr);
  int argc = static_cast<int>(arguments.size());
  char** argv = pointers.data();
  const std::string message = LetGflagsParse(&argc, &argv);
  if (!message.empty()) throw InputError(Sentence(message, flags, unknown));
  if (argc > 1) RejectArgument(argv[1], flags);
}

std::string RequestedText(const std::string& program, const std::string& summary,
                          const std::vector<FlagHelp>& flags, const std::vector<FlagHelp>& all) {
  if (Value("version") == "true") return program + " " + SURFIT_VERSION + "\n";
  const std::string group = Value("helpon"), title = program + ": " + summary + "\n\n";
  if (group == "words") return CompletionWords(all);
  if (!group.empty()) return title + GroupHelp(all, group);
  if (Value("helpfull") == "true") return title + FullHelp(all);
  if (Value("help") == "true" || Value("helpshort") == "true")
    return title + EverydayHelp(flags, all);
  return "";
}

}  // namespace surfit::tools
