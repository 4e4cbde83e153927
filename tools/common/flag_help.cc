#include <algorithm>
#include <cstdlib>
#include <sstream>

#include "common/flags.h"
#include "surfit/core/error.h"

namespace surfit::tools {
namespace {

constexpr std::size_t kWidth = 80;   // columns of a line
constexpr std::size_t kIndent = 26;  // column of the help text
constexpr std::size_t kFew = 20;     // maximum number of flags without groups

const FlagHelp kFlagFile = {
    "flagfile", "", "read flags from this file, one per line", "", true, false, {}, {}};

std::string JoinNames(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

// Words of a text that continues a line at `indent`, in lines of at most kWidth columns. Further
// lines begin at `indent`.
std::string Wrapped(const std::string& text, std::size_t indent) {
  std::string lines;
  std::size_t column = indent;
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    if (column > indent && column + 1 + word.size() > kWidth) {
      lines += '\n' + std::string(indent, ' ');
      column = indent;
    }
    if (column > indent) lines += ' ';
    column += word.size() + (column > indent ? 1 : 0);
    lines += word;
  }
  return lines;
}

// The first line of the help describes the flag. Each further line describes a setting of its
// value.
std::string Text(const FlagHelp& flag) {
  std::string text = "  --" + flag.name + "=";
  text += flag.default_value.empty() ? "\"\"" : flag.default_value;
  std::size_t column = text.size();
  if (column + 2 > kIndent) {
    text += '\n';
    column = 0;
  }
  text.append(kIndent - column, ' ');
  std::istringstream lines(flag.modes.empty() ? flag.help
                                              : flag.help + " [" + JoinNames(flag.modes) + "]");
  std::string line;
  std::getline(lines, line);
  text += Wrapped(line, kIndent);
  while (std::getline(lines, line)) {
    text += '\n' + std::string(kIndent + 2, ' ') + Wrapped(line, kIndent + 4);
  }
  return text + '\n';
}

template <typename Wanted>
std::string Texts(const std::vector<FlagHelp>& flags, const Wanted& wanted) {
  std::string text;
  for (const FlagHelp& flag : flags) {
    if (wanted(flag)) text += Text(flag);
  }
  return text;
}

// Groups in the order of their first flag.
std::vector<std::string> Groups(const std::vector<FlagHelp>& flags) {
  std::vector<std::string> groups;
  for (const FlagHelp& flag : flags) {
    const bool known = std::find(groups.begin(), groups.end(), flag.group) != groups.end();
    if (!known) groups.push_back(flag.group);
  }
  return groups;
}

std::string Section(const std::vector<FlagHelp>& flags, const std::string& group) {
  const std::string title = group.empty() ? "Options" : "Options of " + group;
  return title + ":\n" + Texts(flags, [&](const FlagHelp& f) { return f.group == group; });
}

}  // namespace

std::string EverydayHelp(const std::vector<FlagHelp>& flags, const std::vector<FlagHelp>& all) {
  const bool few = flags.size() <= kFew;
  const auto wanted = [&](const FlagHelp& flag) { return few || flag.everyday; };
  const std::string text =
      (few ? "Options:\n" : "Everyday options:\n") + Texts(flags, wanted) + Text(kFlagFile);
  if (all.size() <= kFew) return text;
  return text + "\nMore: --help=GROUP with GROUP one of " + JoinNames(Groups(all)) +
         ";\n--help=all for all options.\n";
}

std::string FullHelp(const std::vector<FlagHelp>& flags) {
  if (flags.size() <= kFew) return EverydayHelp(flags, flags);
  std::string text;
  for (const std::string& group : Groups(flags)) text += Section(flags, group) + "\n";
  return text + "Options from a file:\n" + Text(kFlagFile);
}

std::string GroupHelp(const std::vector<FlagHelp>& flags, const std::string& group) {
  const std::vector<std::string> groups = Groups(flags);
  if (std::find(groups.begin(), groups.end(), group) == groups.end()) {
    throw InputError(Concat("--help is '", group, "', must be one of: all, ", JoinNames(groups)));
  }
  return Section(flags, group);
}

std::string CompletionWords(const std::vector<FlagHelp>& flags) {
  std::string words = "--help\n--help=all\n--version\n--flagfile=\n";
  for (const std::string& group : Groups(flags)) {
    if (!group.empty() && flags.size() > kFew) words += "--help=" + group + "\n";
  }
  for (const FlagHelp& flag : flags) {
    words += "--" + flag.name + (flag.is_switch ? "\n--no" + flag.name : "=") + "\n";
    for (const std::string& choice : flag.choices) words += "--" + flag.name + "=" + choice + "\n";
  }
  return words;
}

}  // namespace surfit::tools
