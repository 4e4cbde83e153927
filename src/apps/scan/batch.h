#pragma once

#include <optional>
#include <string>
#include <vector>

#include "surfit/run/slam_run.h"

namespace surfit {

class OptionVisitor;

// A batch runs SLAM over sequences that have nothing to do with each other, each by a process of
// its own. Its folder has:
//   batch.json, flags/NAME.flags    PlanBatch()
//   runs/NAME/                      what surfit_slam writes for a sequence
//   jobs/run_NAME.json, .log        what became of it (tools/workflow/job.py)
//   table.csv, summary.json, report.html    ReportBatch()
// All functions throw InputError naming the file or option at fault.

// Which sequences are run, and how.
struct BatchOptions {
  std::string sequences;  // the folder that they are in
  std::string output;     // folder for all results
  SlamRunOptions run;     // of each; which sequence and where to is left open
  int memory_mb = 4000;   // that a run may take; for clusters, which end it beyond that
  int minutes = 600;      // that a run may take; likewise

  void Visit(OptionVisitor& visitor);
};

// A sequence of a batch.
struct BatchRun {
  // That of its folder or file, with what is no letter, digit, dot, hyphen or underscore as %XX.
  std::string name;
  std::string path;  // absolute
};

// All folders and recordings (.klg, .sens, .bag, .db3, .mcap) in the folder of the sequences, by
// name; what begins with a dot is passed over. Writes into the output folder batch.json and, for
// each, flags/NAME.flags: what surfit_slam is to be given for it. Files that would say the same
// stay as they are, so that nothing is done again. Throws InputError where there is no sequence, or
// the output is among them. Whether they can be read is found out by the runs.
std::vector<BatchRun> PlanBatch(const BatchOptions& options);

// What came of one sequence. Figures that are not known are nothing.
struct BatchRow {
  std::string sequence;  // its name
  std::string state;     // done, failed, or open: its job has not come to an end
  std::optional<int> frames, frames_tracked, frames_lost, frames_skipped;
  std::optional<double> ate_rmse_m, rpe_translation_rmse_m, rpe_rotation_rmse_deg;
  std::optional<double> seconds, frame_ms, peak_mb;  // of the process; frame_ms: the mean
  std::optional<double> map_points;
  std::string digest, error;  // empty if there is none
};

// One row for each sequence of the batch, from what its job and its run have left. Writes them as
// table.csv and summary.json, and report.html.
std::vector<BatchRow> ReportBatch(const std::string& batch);

// Removes the receipts of runs that are to be done again: of those whose results are gone and, if
// asked for, of those that failed.
void ForgetRuns(const std::string& batch, bool retry_failed);

}  // namespace surfit
