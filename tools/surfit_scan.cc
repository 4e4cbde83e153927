// A scan of any length: plans its jobs and has Snakemake run them.

#include <fcntl.h>
#include <spawn.h>
#include <sys/file.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <iostream>

#include "common/tool_main.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"
#include "surfit/scan/scan_jobs.h"
#include "surfit/scan/scan_plan.h"

namespace surfit::tools {
namespace {

namespace fs = std::filesystem;

struct ScanOptions {
  ScanPlanOptions plan;
  int cores = 2;
  std::string profile = "local";
  bool retry_failed = false;

  void Visit(OptionVisitor& v) {
    v.AddPart(plan, "plan", "how the sequence is cut into fragments");
    v.Group("scan");
    v.Add(cores, "cores", "cores of this machine for jobs, with profile local", Between(1, 1024),
          AsFlag(), Everyday());
    v.Add(profile, "profile",
          "how Snakemake runs the jobs: local, slurm, or the folder of a Snakemake profile",
          Required(), AsFlag(), Everyday());
    v.Add(retry_failed, "retry_failed", "do again what has failed", AsFlag(), Everyday());
  }
};

// Where the programs are, and the workflow beside them or as installed.
fs::path ProgramFolder() { return fs::read_symlink("/proc/self/exe").parent_path(); }

fs::path WorkflowFolder() {
  for (const char* const folder : {"workflow", SURFIT_WORKFLOW_FROM_PROGRAM}) {
    fs::path path = (ProgramFolder() / folder).lexically_normal();
    if (fs::exists(path / "Snakefile")) return path;
  }
  throw InputError(Concat(ProgramFolder() / "workflow", ": no Snakefile there"));
}

// Held by this process and by Snakemake, which it starts, until both have ended.
void LockScan(const std::string& scan) {
  const std::string path = scan + "/.surfit_scan.lock";
  const int lock = open(path.c_str(), O_RDWR | O_CREAT | O_NOFOLLOW, 0666);
  if (lock < 0) throw InputError(Concat(path, ": cannot be made: ", std::strerror(errno)));
  if (flock(lock, LOCK_EX | LOCK_NB) != 0) {
    throw InputError(scan + " is being scanned into by another process, which must end first");
  }
}

std::string ProfileFolder(const std::string& profile, const fs::path& workflow) {
  for (const fs::path& folder : {workflow / profile, fs::path(profile)}) {
    if (fs::exists(folder / "config.yaml")) return folder;
  }
  throw InputError(Concat("profile is '", profile,
                          "', must be local, slurm or a folder with a Snakemake config.yaml"));
}

// The exit code; 128 + signal where one ended it. Throws InputError if there is no such program.
int RunCommand(std::vector<std::string> command) {
  std::vector<char*> argv;
  argv.reserve(command.size() + 1);
  for (std::string& argument : command) argv.push_back(argument.data());
  argv.push_back(nullptr);
  pid_t pid = 0;
  const int error = posix_spawnp(&pid, argv[0], nullptr, nullptr, argv.data(), environ);
  if (error != 0) {
    throw InputError(Concat("cannot run ", command[0], ": ", std::strerror(error),
                            "; Debian's package snakemake has it"));
  }
  int status = 0;
  while (waitpid(pid, &status, 0) < 0) {
    if (errno != EINTR) return 1;
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

std::vector<std::string> SnakemakeCommand(const ScanOptions& options, const fs::path& workflow) {
  const bool is_local = options.profile == "local";
  std::vector<std::string> command = {
      "snakemake", "--snakefile", workflow / "Snakefile", "--directory", options.plan.run.output,
      "--profile", ProfileFolder(options.profile, workflow),
      // What has been done is told by files' times alone.
      "--rerun-triggers", "mtime", "--rerun-incomplete", "--nolock"};
  if (is_local) command.insert(command.end(), {"--cores", std::to_string(options.cores)});
  command.insert(command.end(), {"--config", "tools=" + ProgramFolder().string()});
  return command;
}

int Run(const ScanOptions& options) {
  const std::vector<std::string> command = SnakemakeCommand(options, WorkflowFolder());
  const std::string& scan = options.plan.run.output;
  Validate(options.plan);
  std::error_code error;
  fs::create_directories(scan, error);
  if (error) throw InputError(Concat(scan, ": cannot be made: ", error.message()));
  LockScan(scan);
  const ScanPlan plan = PlanScan(options.plan);
  std::cout << plan.fragments.size() << " fragments" << std::endl;
  ForgetJobs(scan, options.retry_failed);
  const int code = RunCommand(command);
  if (code != 0) {
    throw InputError(Concat("some jobs have not come to an end (Snakemake's exit code is ", code,
                            "); the same command goes on where they stopped; see ", scan, "/jobs"));
  }
  const ScanSummary summary = ReadScanSummary(scan);
  std::cout << summary.frames << " of " << summary.frames_total << " frames have a pose";
  if (summary.ate_rmse_m) std::cout << ", ATE " << 1000 * *summary.ate_rmse_m << " mm";
  std::cout << "; " << summary.tiles << " tiles; " << scan << "/report.html" << std::endl;
  for (const std::string& failed : summary.failed) std::cerr << "warning: " << failed << '\n';
  if (!summary.failed.empty()) {
    std::cerr << "warning: --retry_failed does again what has failed" << std::endl;
  }
  return summary.frames == 0 || 2 * summary.frames < summary.frames_total ? kAlgorithmFailed
                                                                          : kDone;
}

}  // namespace
}  // namespace surfit::tools

int main(int argc, char** argv) {
  return surfit::tools::ToolMain(
      argc, argv,
      "turns a recording of any length into a trajectory and a map in tiles: cuts it into "
      "fragments, and has Snakemake run the jobs on this machine or a cluster. The same command "
      "goes on with a scan that was interrupted.",
      surfit::tools::Run);
}
