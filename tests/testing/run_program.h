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
#include <vector>

#include "testing/matchers.h"
#include "testing/temp_folder.h"

namespace surfit::testing {

struct ProgramResult {
  int exit_code = -1;  // 128 + signal if one ended it, as in a shell
  std::string out;     // all it wrote to stdout
  std::string err;     // and to stderr
};

// One of our programs (by its name in the build's tools folder), or the one at a path from the root
// on, running as a process of its own.
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

  void Signal(int signal) { kill(pid_, signal); }
  // Whether it is still at work.
  bool IsRunning() const {
    siginfo_t ended = {};
    return waitid(P_PID, static_cast<id_t>(pid_), &ended, WEXITED | WNOHANG | WNOWAIT) == 0 &&
           ended.si_pid == 0;
  }
  // Of its memory, what is not swapped out.
  std::size_t ResidentBytes() const {
    std::size_t pages = 0, resident = 0;
    std::ifstream("/proc/" + std::to_string(pid_) + "/statm") >> pages >> resident;
    return resident * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  }

  // What it has written so far.
  std::string StdoutSoFar() const { return ReadBytes(out()); }
  std::string StderrSoFar() const { return ReadBytes(err()); }

  // Waits for its end; once.
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

// What a program says on stderr but for the notes of what it takes for granted of a sequence, and
// for the progress that it shows where a machine is slow.
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

// Bad input: exit code 1, one sentence on stderr, nothing on stdout.
inline void ExpectRefused(const ProgramResult& result, const std::string& message) {
  EXPECT_EQ(result.exit_code, 1) << message;
  EXPECT_THAT(result.out, IsEmpty()) << message;
  EXPECT_THAT(WithoutNotes(result.err), AllOf(MatchesRegex("error: [^\n]*\n"), HasSubstr(message)));
}

// Runs one of our programs to its end: RunProgram("surfit_evaluate", {"--estimate=" + path}).
inline ProgramResult RunProgram(const std::string& name,
                                const std::vector<std::string>& arguments) {
  return RunningProgram(name, arguments).Wait();
}

// Runs commands of the shell, of which ours are in the folder $tools.
inline ProgramResult RunShell(const std::string& commands) {
  return RunProgram("/bin/sh",
                    {"-c", "tools='" + std::string(SURFIT_TOOLS_DIR) + "'\n" + commands});
}

// Expects that it did what it was asked for.
inline ProgramResult Succeeded(const ProgramResult& result) {
  EXPECT_EQ(result.exit_code, 0) << result.err;
  return result;
}

}  // namespace surfit::testing
