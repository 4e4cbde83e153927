#pragma once

#include <string>
#include <vector>

#include "surfit/core/options.h"

namespace surfit::tools {

// How Snakemake runs the jobs of a program.
struct WorkflowOptions {
  int cores = 2;
  std::string profile = "local";
  bool retry_failed = false;

  void Visit(OptionVisitor& visitor);
};

// A folder whose jobs Snakemake runs. Its lock is held by this process and by Snakemake, which it
// starts, until both have ended.
class Workflow {
 public:
  // Finds the file of rules (tools/workflow), beside the programs or as installed, and the profile.
  // Throws InputError naming the one that is missing.
  Workflow(const WorkflowOptions& options, const std::string& folder, const std::string& rules);

  // Makes the folder. Throws InputError if it cannot, or if another process works in it.
  void Lock() const;

  // Whether all jobs have come to an end, failed or not. Else it is told on stderr. Throws
  // InputError if there is no Snakemake.
  bool Run() const;

 private:
  std::string folder_;
  std::vector<std::string> command_;
};

}  // namespace surfit::tools
