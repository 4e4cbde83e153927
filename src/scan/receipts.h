#pragma once

#include <string>
#include <vector>

namespace surfit {

// What became of a job, as tools/workflow/job.py wrote it down.
struct Receipt {
  std::string job;  // RULE or RULE_NAME
  int exit = 0;
  double seconds = 0, peak_mb = 0;
  std::string error;    // empty unless it failed
  std::string product;  // the file that it wrote, in the scan's folder; empty if none

  std::string Rule() const { return job.substr(0, job.find('_')); }
};

// Throws InputError naming the file.
Receipt ReadReceipt(const std::string& path);

}  // namespace surfit
