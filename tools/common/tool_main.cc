#include "common/tool_main.h"

#include <gflags/gflags.h>
#include <glog/logging.h>
#include <malloc.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <new>
#include <utility>

#include "common/command_line.h"
#include "common/console.h"
#include "common/flags.h"
#include "common/removed_flags.h"
#include "common/residual_library.h"
#include "surfit/core/error.h"

namespace surfit::tools {
namespace {

// Flags with output paths and with input paths.
constexpr std::array kOutputs = {"output", "summary", "trace", "dump_failures"};
constexpr std::array kInputs = {"sequence", "sequences", "graph",  "estimate",  "groundtruth",
                                "map",      "source",    "target", "reference", "residual_library"};

template <std::size_t kCount>
bool IsOneOf(const std::array<const char*, kCount>& names, const FlagHelp& flag) {
  return std::find(names.begin(), names.end(), flag.name) != names.end();
}

// Throws InputError if an input is also an output. Default values of the flags are their present
// values.
void RequireDistinctPaths(const std::vector<FlagHelp>& flags) {
  namespace fs = std::filesystem;
  for (const FlagHelp& output : flags) {
    if (!IsOneOf(kOutputs, output)) continue;
    for (const FlagHelp& input : flags) {
      std::error_code none;
      if (IsOneOf(kInputs, input) &&
          fs::equivalent(input.default_value, output.default_value, none)) {
        throw InputError(Concat("--", output.name, " is '", output.default_value, "', which --",
                                input.name, " reads, must be another path"));
      }
    }
  }
}

// Prefix of a line of the log: its kind and, for faults of the program, the source line.
void WriteKind(std::ostream& line, const google::LogMessageInfo& message, void*) {
  const char kind = message.severity[0];
  line << (kind == 'I' ? "note:" : kind == 'W' ? "warning:" : "fault:");
  if (kind != 'I' && kind != 'W') line << ' ' << message.filename << ':' << message.line_number;
}

// With a heap per thread, freed memory of background tasks is not reused, and long runs grow. About
// 400,000 allocations a second do not contend for one heap.
void UseOneHeap() {
#ifdef M_ARENA_MAX
  mallopt(M_ARENA_MAX, 1);
#endif
}

// Throws InputError if stdout was not written completely, e.g. due to a full disk or a closed pipe.
void RequireStdoutWritten() {
  std::cout.flush();
  const bool failed = std::fflush(stdout) != 0 || std::ferror(stdout) != 0 || !std::cout;
  if (failed) throw InputError("stdout cannot be written");
}

}  // namespace

int ToolMain(int argc, char** argv, const std::string& summary, const ModeFlag& flag,
             std::vector<Mode> modes) {
  UseOneHeap();
  PrepareStreams();
  const std::string program = std::filesystem::path(argv[0]).filename().string();
  try {
    FLAGS_logtostderr = true;
    google::InitGoogleLogging(argv[0], &WriteKind);
    ResidualLibrary residuals;
    for (Mode& mode : modes) mode.options = residuals.With(mode.options);
    const std::vector<std::string> arguments =
        WithPresentNames(ExpandFlagFiles({argv, argv + argc}));
    const Modes all(flag, std::move(modes), arguments);
    const Mode& mode = all.selected();
    const Flags flags(mode.options);
    const std::vector<FlagHelp> described = Describe(mode.options);
    ParseCommandLine(arguments, described, [&](const std::string& name) {
      const std::string positive = name.rfind("no", 0) == 0 ? name.substr(2) : name;
      for (const std::string& known : {Replacement(program, name), all.ModesOf(name),
                                       Replacement(program, positive), all.ModesOf(positive)}) {
        if (!known.empty()) return known;
      }
      return std::string();
    });
    const std::string text = RequestedText(program, summary, described, all.Described());
    if (!text.empty()) {
      std::cout << text;
      RequireStdoutWritten();
      return kDone;
    }
    flags.Apply();
    residuals.Load();
    if (mode.prepare) {
      mode.prepare();
      flags.Apply();
    }
    flags.Check();
    RequireDistinctPaths(Describe(mode.options));
    const int exit_code = mode.run();
    RequireStdoutWritten();
    return exit_code;
  } catch (const std::bad_alloc&) {
    std::cerr << "error: out of memory" << std::endl;
    return kBadInput;
  } catch (const std::exception& error) {
    const std::string hint = argc > 1 ? "" : "; " + program + " --help lists the options";
    std::cerr << "error: " << error.what() << hint << std::endl;
    return kBadInput;
  }
}

void RequireFlag(const std::string& name, const std::string& value) {
  if (value.empty()) throw InputError(Concat("--", name, " is missing, must be set"));
}

}  // namespace surfit::tools
