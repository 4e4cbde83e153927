#pragma once

#include <string>
#include <vector>

#include "surfit/run/slam_run.h"

namespace surfit {

// Input files and receipts of workflow jobs (tools/workflow). Functions of this header that read or
// write files throw InputError with the file name.

// Writes a file atomically. An unchanged file keeps its modification time, so that dependent
// jobs are not repeated.
void WriteIfChanged(const std::string& text, const std::string& path);

// Paths of the files with this extension (".json"), sorted. Empty if the folder does not exist.
std::vector<std::string> FilesIn(const std::string& folder, const std::string& extension);

// Absolute path without "." and "..", without resolving symbolic links. The file need not exist.
std::string AbsolutePath(const std::string& path);

// Makes the paths of the sequence and of an existing camera file absolute. Camera presets stay.
SequenceOptions WithAbsolutePaths(SequenceOptions sequence);

// Text of a flag file (--flagfile): flags of `run` that differ from `other` or from the
// defaults. Without `output`.
std::string FlagFileOf(const SlamRunOptions& run, const SlamRunOptions& other);
std::string FlagFileOf(const SlamRunOptions& run);

// Result of a job, written by tools/workflow/job.py.
struct JobReceipt {
  std::string job;  // RULE or RULE_NAME
  int exit = 0;     // exit code; 0: success
  double seconds = 0, peak_mb = 0;
  std::string error;    // empty: success
  std::string product;  // output file, relative to the folder of the workflow; empty: none

  std::string Rule() const { return job.substr(0, job.find('_')); }
};

// Path of the receipt of a job: FOLDER/jobs/JOB.json.
std::string ReceiptPath(const std::string& folder, const std::string& job);
// Throws InputError if the receipt is missing or invalid.
JobReceipt ReadReceipt(const std::string& path);

// Deletes receipts, so that the workflow repeats these jobs: successful jobs without their
// product and, with `retry_failed`, failed jobs. Keeps the receipts of dependent jobs.
void DeleteReceipts(const std::string& folder, bool retry_failed);

}  // namespace surfit
