#include "common/workflow.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/file.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <iostream>

#include "surfit/core/error.h"

namespace surfit::tools {
namespace {

namespace fs = std::filesystem;

fs::path ProgramFolder() { return fs::read_symlink("/proc/self/exe").parent_path(); }

fs::path WorkflowFolder(const std::string& rules) {
  for (const char* const folder : {"workflow", SURFIT_WORKFLOW_FROM_PROGRAM}) {
    fs::path path = (ProgramFolder() / folder).lexically_normal();
    if (fs::exists(path / rules)) return path;
  }
  throw InputError(Concat(ProgramFolder() / "workflow", ": ", rules, " not found"));
}

std::string ProfileFolder(const std::string& profile, const fs::path& workflow) {
  for (const fs::path& folder : {workflow / profile, fs::path(profile)}) {
    if (fs::exists(folder / "config.yaml")) return folder;
  }
  throw InputError(Concat("profile is '", profile,
                          "', must be local, slurm or a folder with a Snakemake config.yaml"));
}

// Returns the exit code, or 128 + signal. Throws InputError if the program does not exist.
int RunCommand(std::vector<std::string> command) {
  std::vector<char*> argv;
  argv.reserve(command.size() + 1);
  for (std::string& argument : command) argv.push_back(argument.data());
  argv.push_back(nullptr);
  pid_t pid = 0;
  const int error = posix_spawnp(&pid, argv[0], nullptr, nullptr, argv.data(), environ);
  if (error != 0) {
    throw InputError(Concat("cannot run ", command[0], ": ", std::strerror(error),
                            "; install it, e.g. by the Debian package snakemake"));
  }
  int status = 0;
  while (waitpid(pid, &status, 0) < 0) {
    if (errno != EINTR) return 1;
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

}  // namespace

void WorkflowOptions::Visit(OptionVisitor& v) {
  v.Group("jobs");
  v.Add(cores, "cores", "number of cores of this machine for jobs, with profile local",
        Between(1, 1024), AsFlag(), Everyday());
  v.Add(profile, "profile", "profile of Snakemake: local, slurm, or the folder of another profile",
        Required(), AsFlag(), Everyday());
  v.Add(retry_failed, "retry_failed", "repeat failed jobs", AsFlag(), Everyday());
}

Workflow::Workflow(const WorkflowOptions& options, const std::string& folder,
                   const std::string& rules)
    : folder_(folder) {
  const fs::path workflow = WorkflowFolder(rules);
  command_ = {"snakemake", "--snakefile", workflow / rules, "--directory", folder, "--profile",
              ProfileFolder(options.profile, workflow),
              // Only file times decide which jobs are repeated.
              "--rerun-triggers", "mtime", "--rerun-incomplete", "--nolock"};
  if (options.profile == "local") {
    command_.insert(command_.end(), {"--cores", std::to_string(options.cores)});
  }
  command_.insert(command_.end(), {"--config", "tools=" + ProgramFolder().string()});
}

void Workflow::Lock() const {
  std::error_code error;
  fs::create_directories(folder_, error);
  if (error) throw InputError(Concat(folder_, ": cannot be created: ", error.message()));
  const std::string path = folder_ + "/.surfit_jobs.lock";
  const int lock = open(path.c_str(), O_RDWR | O_CREAT | O_NOFOLLOW, 0666);
  if (lock < 0) throw InputError(Concat(path, ": cannot be created: ", std::strerror(errno)));
  if (flock(lock, LOCK_EX | LOCK_NB) != 0) {
    throw InputError(folder_ + " is in use by another process: wait until it ends");
  }
}

bool Workflow::Run() const {
  const int code = RunCommand(command_);
  if (code == 0) return true;
  std::cerr << "error: some jobs did not finish (exit code of Snakemake: " << code
            << "): run the same command again to continue; logs: " << folder_ << "/jobs"
            << std::endl;
  return false;
}

}  // namespace surfit::tools
