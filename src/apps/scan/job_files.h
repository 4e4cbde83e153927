#pragma once

#include <string>
#include <vector>

#include "surfit/run/slam_run.h"

namespace surfit {

// What the jobs of a workflow (tools/workflow) are given, and what is known of those that ended.
// All throw InputError naming the file that is at fault.

// Writes a file atomically, unless it says the same already: who goes by its time has nothing to do
// again.
void WriteUnlessSame(const std::string& text, const std::string& path);

// The files of a folder with that extension, by name; none if there is no folder.
std::vector<std::string> FilesIn(const std::string& folder, const std::string& extension);

std::string AbsolutePath(const std::string& path);

// The same sequence, to be read from any working folder.
SequenceOptions WithAbsolutePaths(SequenceOptions sequence);

// The flags of a run that differ from those of another one, or from the defaults, but for its
// output: a line each, as --flagfile takes them.
std::string FlagFileOf(const SlamRunOptions& run, const SlamRunOptions& other);
std::string FlagFileOf(const SlamRunOptions& run);

// What became of a job, as tools/workflow/job.py wrote it down.
struct JobReceipt {
  std::string job;  // RULE or RULE_NAME
  int exit = 0;
  double seconds = 0, peak_mb = 0;
  std::string error;    // empty unless it failed
  std::string product;  // the file that it wrote, in the workflow's folder; empty if none

  std::string Rule() const { return job.substr(0, job.find('_')); }
};

// Where the receipt of a job is, in the workflow's folder.
std::string ReceiptPath(const std::string& folder, const std::string& job);
JobReceipt ReadReceipt(const std::string& path);

// Removes the receipts of jobs that are to be done again by themselves: of those whose products are
// gone and, if asked for, of those that failed.
void ForgetReceipts(const std::string& folder, bool retry_failed);

}  // namespace surfit
