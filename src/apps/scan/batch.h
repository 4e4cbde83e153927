#pragma once

#include <optional>
#include <string>
#include <vector>

#include "surfit/run/slam_run.h"

namespace surfit {

class OptionVisitor;

// A batch runs one surfit_slam process per sequence. Files in its folder:
//   batch.json, flags/NAME.flags    PlanBatch()
//   runs/NAME/                      output of surfit_slam for a sequence
//   jobs/run_NAME.json, .log        receipt and log of a job (tools/workflow/job.py)
//   table.csv, summary.json, report.html    ReportBatch()
// All functions throw InputError with the name of the file or option.

struct BatchOptions {
  std::string sequences;
  std::string output;
  SlamRunOptions run;    // options of each run; sequence path and output are set per run
  int memory_mb = 4000;  // maximum memory of a run, MB; for clusters
  int minutes = 600;     // maximum time of a run; for clusters

  void Visit(OptionVisitor& visitor);
};

struct BatchRun {
  // File name, with %XX for characters other than letters, digits, dot, hyphen and underscore.
  std::string name;
  std::string path;  // absolute
};

// Finds all folders and recordings (.klg, .sens, .bag, .db3, .mcap) in the folder of the sequences.
// Hidden files are skipped. Returns them sorted by name.
// Writes batch.json and flags/NAME.flags (--flagfile of surfit_slam) into the output folder.
// Unchanged files keep their modification time, so that finished runs are not repeated. The
// sequences are not opened. Throws InputError if there is no sequence, or if the output folder is
// one of them.
std::vector<BatchRun> PlanBatch(const BatchOptions& options);

// Result of a sequence. Unknown figures are std::nullopt.
struct BatchRow {
  std::string sequence;
  std::string state;  // done, failed, or open: not finished
  std::optional<int> frames, frames_tracked, frames_lost, frames_skipped;
  std::optional<double> ate_rmse_m, rpe_translation_rmse_m, rpe_rotation_rmse_deg;
  std::optional<double> seconds, frame_ms, peak_mb;  // frame_ms: mean
  std::optional<double> map_points;
  std::string digest, error;  // empty: none
};

// Collects the result of each sequence from the receipt of its job and the output of its run.
// Writes table.csv, summary.json and report.html.
std::vector<BatchRow> ReportBatch(const std::string& batch);

// Deletes the receipts of runs to repeat: runs with missing results and, with `retry_failed`,
// failed runs.
void DeleteStaleRunReceipts(const std::string& batch, bool retry_failed);

}  // namespace surfit
