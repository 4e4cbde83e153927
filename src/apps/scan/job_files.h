#pragma once

#include <string>
#include <vector>

#include "surfit/run/slam_run.h"

namespace surfit {

// Input files and receipts of workflow jobs (tools/workflow). All functions throw InputError with
// the name of the file.

// Writes a file atomically. An unchanged file keeps its modification time, so that jobs that depend
// on it are not repeated.
void WriteIfChanged(const std::string& text, const std::string& path);

// Files of a folder with this extension, sorted by name; empty if the folder does not exist.
std::vector<std::string> FilesIn(const std::string& folder, const std::string& extension);

std::string AbsolutePath(const std::string& path);

// Makes the paths absolute, so that the sequence can be read from any working directory.
SequenceOptions WithAbsolutePaths(SequenceOptions sequence);

// Text of a flag file (--flagfile) with one flag per line. Contains the flags of `run`, except
// `output`, that differ from `other` or from the defaults.
std::string FlagFileOf(const SlamRunOptions& run, const SlamRunOptions& other);
std::string FlagFileOf(const SlamRunOptions& run);

// Result of a job, written by tools/workflow/job.py.
struct JobReceipt {
  std::string job;  // RULE or RULE_NAME
  int exit = 0;
  double seconds = 0, peak_mb = 0;
  std::string error;    // empty: success
  std::string product;  // output file, relative to the workflow folder; empty: none

  std::string Rule() const { return job.substr(0, job.find('_')); }
};

std::string ReceiptPath(const std::string& folder, const std::string& job);
JobReceipt ReadReceipt(const std::string& path);

// Deletes the receipts of jobs to repeat: successful jobs with missing product and, with
// `retry_failed`, failed jobs. Jobs that depend on them are not included.
void DeleteReceipts(const std::string& folder, bool retry_failed);

}  // namespace surfit
