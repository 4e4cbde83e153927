#pragma once

#include <string>
#include <vector>

#include "surfit/core/options.h"

namespace surfit::tools {

// Options of the jobs of Snakemake.
struct WorkflowOptions {
  int cores = 2;  // for jobs; only with the profile "local"
  std::string profile = "local";
  bool retry_failed = false;  // no effect in Workflow: the program deletes receipts of failed jobs

  void Visit(OptionVisitor& visitor);
};

// Folder whose jobs are run by Snakemake. The folder is locked until this process and Snakemake
// end.
class Workflow {
 public:
  // Finds the file of rules (tools/workflow), next to the programs or as installed, and the
  // profile. Throws InputError with the name of the missing one.
  Workflow(const WorkflowOptions& options, const std::string& folder, const std::string& rules);

  // Creates and locks the folder. Call before Run(). Throws InputError if this fails, or if another
  // process uses the folder.
  void Lock() const;

  // Runs the jobs. Returns true if all jobs finished, successfully or not. Otherwise prints an
  // error on stderr. Throws InputError if Snakemake is not installed.
  bool Run() const;

 private:
  std::string folder_;
  std::vector<std::string> command_;
};

}  // namespace surfit::tools
