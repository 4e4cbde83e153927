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
  std::string sequences;  // folder of the sequences
  std::string output;     // folder of the batch, created if missing
  SlamRunOptions run;     // options of each run; sequence path and output are set per run

  void Visit(OptionVisitor& visitor);
};

struct BatchRun {
  // File name of the sequence. Characters except letters, digits, '.', '-' and '_' are
  // replaced by %XX.
  std::string name;
  std::string path;  // absolute
};

// Finds all folders and recordings (.klg, .sens, .bag, .db3, .mcap) in the folder of the
// sequences, except hidden ones. Writes batch.json and flags/NAME.flags (--flagfile of
// surfit_slam). Unchanged files keep their modification time, so that finished runs are not
// repeated. Returns the runs, sorted by name. Does not open the sequences. Throws InputError for
// invalid options, without a sequence, or if the output folder is one of the sequences.
std::vector<BatchRun> PlanBatch(const BatchOptions& options);

// Unknown values are std::nullopt.
struct BatchRow {
  std::string sequence;
  std::string state;  // "done", "failed" or "open" (not finished)
  std::optional<int> frames, frames_tracked, frames_lost, frames_skipped;
  std::optional<double> ate_rmse_m, rpe_translation_rmse_m, rpe_rotation_rmse_deg;
  std::optional<double> seconds, frame_ms, peak_mb;  // frame_ms: mean time per frame
  std::optional<double> map_points;
  std::string digest, error;  // empty: none
};

// Writes table.csv, summary.json and report.html.
std::vector<BatchRow> ReportBatch(const std::string& batch);

// Deletes receipts, so that the workflow repeats these runs: runs with missing output and, with
// `retry_failed`, failed runs.
void DeleteStaleRunReceipts(const std::string& batch, bool retry_failed);

}  // namespace surfit
