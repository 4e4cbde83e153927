#include "common/tool_main.h"

#include <gflags/gflags.h>
#include <glog/logging.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <new>
#include <vector>

#include "common/console.h"
#include "common/flags.h"
#include "surfit/core/error.h"

namespace google {
// gflags' exit function: exported by the library for its own tests, declared in no header.
extern void (*gflags_exitfunc)(int);
}  // namespace google

namespace surfit::tools {
namespace {

// gflags prints and then exits on a bad flag; this exception takes the place of its exit.
struct GflagsExit {};

// Parses the flags; throws InputError with gflags' own sentence for a bad one.
void ParseFlags(int argc, char** argv) {
  std::vector<std::string> arguments = ExpandFlagFiles({argv, argv + argc});
  std::vector<char*> pointers;
  pointers.reserve(arguments.size() + 1);
  for (std::string& argument : arguments) pointers.push_back(argument.data());
  pointers.push_back(nullptr);
  argc = static_cast<int>(arguments.size());
  argv = pointers.data();
  char* text = nullptr;
  std::size_t size = 0;
  std::FILE* const terminal = stderr;
  stderr = open_memstream(&text, &size);
  google::gflags_exitfunc = [](int) { throw GflagsExit(); };
  bool failed = false;
  try {
    gflags::ParseCommandLineNonHelpFlags(&argc, &argv, /*remove_flags=*/true);
  } catch (const GflagsExit&) {
    failed = true;
  }
  std::fclose(stderr);
  stderr = terminal;
  std::string message(text, size);
  std::free(text);
  if (failed) {
    if (message.rfind("ERROR: ", 0) == 0) message = message.substr(7);
    while (!message.empty() && message.back() == '\n') message.pop_back();
    throw InputError(message);
  }
  if (argc > 1)
    throw InputError(Concat("unexpected argument '", argv[1], "', flags begin with --"));
}

bool FlagIsSet(const char* name) {
  std::string value;
  return gflags::GetCommandLineOption(name, &value) && value == "true";
}

// The help that is asked for; nothing if none is.
std::string Help(const std::vector<FlagHelp>& flags) {
  std::string group;
  gflags::GetCommandLineOption("helpon", &group);
  if (!group.empty()) return GroupHelp(flags, group);
  if (FlagIsSet("helpfull")) return FullHelp(flags);
  if (FlagIsSet("help") || FlagIsSet("helpshort")) return EverydayHelp(flags);
  return "";
}

}  // namespace

namespace {

// The flags of our programs that name what is written, and what is read.
constexpr std::array kOutputs = {"output", "summary", "trace", "dump_failures"};
constexpr std::array kInputs = {"sequence",    "graph", "cloud",  "trajectory", "estimate",
                                "groundtruth", "map",   "source", "target",     "reference"};

// Whether the flag is one of those, and has a path, no number of a frame.
template <std::size_t kCount>
bool IsPathOf(const std::array<const char*, kCount>& names, const FlagHelp& flag) {
  const bool is_number = flag.default_value.find_first_not_of("0123456789") == std::string::npos;
  return !is_number && std::find(names.begin(), names.end(), flag.name) != names.end();
}

// No file or folder that a flag names to be read may be one that is written. The flags have their
// present values as defaults.
void RequireInputsKept(const std::vector<FlagHelp>& flags) {
  namespace fs = std::filesystem;
  for (const FlagHelp& output : flags) {
    if (!IsPathOf(kOutputs, output)) continue;
    for (const FlagHelp& input : flags) {
      std::error_code none;
      if (IsPathOf(kInputs, input) &&
          fs::equivalent(input.default_value, output.default_value, none)) {
        throw InputError(Concat("--", output.name, " is '", output.default_value, "', which --",
                                input.name, " reads, must be another"));
      }
    }
  }
}

// Results that are not taken are none: the disk is full, or the pipe closed.
void RequireOutputTaken() {
  std::cout.flush();
  const bool failed = std::fflush(stdout) != 0 || std::ferror(stdout) != 0 || !std::cout;
  if (failed) throw InputError("stdout cannot be written");
}

}  // namespace

int ToolMain(int argc, char** argv, const std::string& summary, const OptionTable& options,
             const std::function<int()>& run, const std::function<void()>& prepare) {
  PrepareStreams();
  try {
    const std::string path = argv[0];
    FLAGS_logtostderr = true;
    google::InitGoogleLogging(argv[0]);
    const Flags flags(options);
    ParseFlags(argc, argv);
    const std::string help = Help(flags.Described());
    if (!help.empty()) {
      std::cout << path.substr(path.find_last_of('/') + 1) << ": " << summary << "\n\n" << help;
      return kDone;
    }
    flags.Apply();
    if (prepare) {
      prepare();
      flags.Apply();
    }
    flags.Check();
    RequireInputsKept(flags.Described());
    const int exit_code = run();
    RequireOutputTaken();
    return exit_code;
  } catch (const std::bad_alloc&) {
    std::cerr << "error: memory is exhausted" << std::endl;
    return kBadInput;
  } catch (const std::exception& error) {
    std::cerr << "error: " << error.what() << std::endl;
    return kBadInput;
  }
}

void RequireFlag(const std::string& name, const std::string& value) {
  if (value.empty()) throw InputError(Concat("--", name, " is missing, must be set"));
}

}  // namespace surfit::tools
