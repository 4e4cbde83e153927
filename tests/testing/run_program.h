#pragma once

#include <fcntl.h>
#include <gmock/gmock.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <regex>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "testing/matchers.h"
#include "testing/temp_folder.h"

namespace surfit::testing {

struct ProgramResult {
  int exit_code = -1;  // 128 + signal number after a signal, as in a shell
  std::string out;     // complete stdout
  std::string err;     // complete stderr
};

// A child process. `name` is a program of the tools folder in the build, or an absolute path.
class RunningProgram {
 public:
  RunningProgram(const std::string& name, std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(),
                     name[0] == '/' ? name : std::string(SURFIT_TOOLS_DIR) + "/" + name);
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    constexpr int kFlags = O_WRONLY | O_CREAT | O_TRUNC;
    posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, out().c_str(), kFlags, 0600);
    posix_spawn_file_actions_addopen(&files, STDERR_FILENO, err().c_str(), kFlags, 0600);
    const int error = posix_spawn(&pid_, argv[0], &files, nullptr, argv.data(), environ);
    posix_spawn_file_actions_destroy(&files);
    if (error != 0) {
      pid_ = -1;
      ADD_FAILURE() << "cannot run " << argv[0];
    }
  }
  ~RunningProgram() {
    if (pid_ < 0) return;
    kill(pid_, SIGKILL);
    Wait();
  }
  RunningProgram(const RunningProgram&) = delete;
  RunningProgram& operator=(const RunningProgram&) = delete;

  // Call it before Wait().
  void Signal(int signal) {
    if (pid_ > 0) kill(pid_, signal);
  }
  // True until the process ends.
  bool IsRunning() const {
    siginfo_t ended = {};
    return waitid(P_PID, static_cast<id_t>(pid_), &ended, WEXITED | WNOHANG | WNOWAIT) == 0 &&
           ended.si_pid == 0;
  }
  // Resident memory of the process; 0 after its end.
  std::size_t ResidentBytes() const {
    std::size_t pages = 0, resident = 0;
    std::ifstream("/proc/" + std::to_string(pid_) + "/statm") >> pages >> resident;
    return resident * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  }

  // Output up to now.
  std::string StdoutSoFar() const { return ReadBytes(out()); }
  std::string StderrSoFar() const { return ReadBytes(err()); }

  // Waits for the end of the process. Call it once.
  ProgramResult Wait() {
    int status = 0;
    if (pid_ < 0 || waitpid(pid_, &status, 0) != pid_) return {};
    pid_ = -1;
    const int exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    return {exit_code, StdoutSoFar(), StderrSoFar()};
  }

 private:
  std::string out() const { return folder_ / "stdout"; }
  std::string err() const { return folder_ / "stderr"; }

  TempFolder folder_;
  pid_t pid_ = -1;
};

// stderr without notes about the sequence and without progress lines, which appear on slow
// machines.
inline std::string WithoutNotes(const std::string& err) {
  std::string text;
  std::istringstream lines(err);
  for (std::string line; std::getline(lines, line);) {
    const bool is_note = line.rfind("note: ", 0) == 0;
    const bool is_progress = std::regex_match(line, std::regex("[0-9]+ %  .*"));
    if (!is_note && !is_progress) text += line + "\n";
  }
  return text;
}

// Expects rejected input: exit code 1, one line with the names on stderr, and an empty stdout.
inline void ExpectRefused(const ProgramResult& result, const NamesMatcher& names) {
  EXPECT_EQ(result.exit_code, 1) << result.err;
  EXPECT_THAT(result.out, IsEmpty()) << result.err;
  EXPECT_THAT(WithoutNotes(result.err), AllOf(MatchesRegex("error: [^\n]*\n"), names));
}
template <typename... Parts>
void ExpectRefused(const ProgramResult& result, const Parts&... names) {
  ExpectRefused(result, Names(names...));
}

// Command lines with the names that the error message must contain.
using RefusedFlags = std::vector<std::pair<std::vector<std::string>, std::vector<std::string>>>;

// The lines of a text that contain `mark`.
inline std::vector<std::string> LinesWith(const std::string& mark, const std::string& text) {
  std::vector<std::string> found;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.find(mark) != std::string::npos) found.push_back(line);
  }
  return found;
}

// Matches the stderr of a program with a warning that contains all names.
template <typename... Parts>
auto HasWarning(const Parts&... names) {
  return ::testing::ResultOf([](const std::string& err) { return LinesWith("warning: ", err); },
                             ::testing::Contains(Names("warning", names...)));
}

// Matches the stderr of a program with an error that contains all names.
template <typename... Parts>
auto HasError(const Parts&... names) {
  return ::testing::ResultOf([](const std::string& err) { return LinesWith("error: ", err); },
                             ::testing::Contains(Names("error", names...)));
}

// Runs a program and waits for its end: RunProgram("surfit_evaluate", {"--estimate=" + path}).
inline ProgramResult RunProgram(const std::string& name,
                                const std::vector<std::string>& arguments) {
  return RunningProgram(name, arguments).Wait();
}

// Runs shell commands. $tools is the folder of the programs.
inline ProgramResult RunShell(const std::string& commands) {
  return RunProgram("/bin/sh",
                    {"-c", "tools='" + std::string(SURFIT_TOOLS_DIR) + "'\n" + commands});
}

// Expects exit code 0.
inline ProgramResult Succeeded(const ProgramResult& result) {
  EXPECT_EQ(result.exit_code, 0) << result.err;
  return result;
}

}  // namespace surfit::testing
