#include <algorithm>
#include <filesystem>

#include "apps/scan/batch.h"
#include "apps/scan/job_files.h"
#include "browser/page.h"
#include "output/output_files.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

namespace fs = std::filesystem;

struct PlannedBatch {
  std::string sequences;
  std::vector<std::string> names;
};

PlannedBatch ReadBatch(const std::string& batch) {
  const std::string path = batch + "/batch.json";
  const Json json = ReadJson(path);
  PlannedBatch planned;
  try {
    json.at("sequences").get_to(planned.sequences);
    for (const Json& name : json.at("runs")) planned.names.push_back(name);
  } catch (const Json::exception& error) {
    throw InputError(path, ": invalid batch plan: ", error.what());
  }
  return planned;
}

std::string RunFile(const std::string& name, const std::string& file) {
  return Concat("runs/", name, "/", file);
}

template <typename T>
void Take(const Json& json, const char* key, std::optional<T>* value) {
  if (json.contains(key) && json[key].is_number()) *value = json[key].get<T>();
}

// Reads values of summary.json. Missing values, for example of a failed run, are left unchanged.
void TakeSummary(const std::string& path, BatchRow* row) {
  const Json json = ReadJson(path);
  Take(json, "frames_total", &row->frames);
  Take(json, "frames_tracked", &row->frames_tracked);
  Take(json, "frames_lost", &row->frames_lost);
  Take(json, "frames_skipped", &row->frames_skipped);
  Take(json, "ate_rmse_m", &row->ate_rmse_m);
  Take(json, "rpe_translation_rmse_m", &row->rpe_translation_rmse_m);
  Take(json, "rpe_rotation_rmse_deg", &row->rpe_rotation_rmse_deg);
  Take(json, "map_points", &row->map_points);
  const Json frame_ms = json.value("frame_ms", Json());
  if (frame_ms.is_object()) Take(frame_ms, "mean", &row->frame_ms);
  const Json digest = json.value("digest", Json());
  if (digest.is_string()) digest.get_to(row->digest);
}

BatchRow RowOf(const std::string& batch, const std::string& name) {
  BatchRow row;
  row.sequence = name;
  const std::string receipt_path = ReceiptPath(batch, "run_" + name);
  if (!fs::exists(receipt_path)) {
    row.state = "open";
    row.error = "job not finished";
    return row;
  }
  const JobReceipt receipt = ReadReceipt(receipt_path);
  row.state = receipt.exit == 0 ? "done" : "failed";
  row.seconds = receipt.seconds;
  row.peak_mb = receipt.peak_mb;
  row.error = receipt.error;
  const std::string summary = Concat(batch, "/", RunFile(name, "summary.json"));
  if (fs::exists(summary)) TakeSummary(summary, &row);
  return row;
}

template <typename T>
Json JsonOf(const std::optional<T>& value) {
  return value ? Json(*value) : Json(nullptr);
}

Json ToJson(const BatchRow& row) {
  return {{"sequence", row.sequence},
          {"state", row.state},
          {"frames", JsonOf(row.frames)},
          {"frames_tracked", JsonOf(row.frames_tracked)},
          {"frames_lost", JsonOf(row.frames_lost)},
          {"frames_skipped", JsonOf(row.frames_skipped)},
          {"ate_rmse_m", JsonOf(row.ate_rmse_m)},
          {"rpe_translation_rmse_m", JsonOf(row.rpe_translation_rmse_m)},
          {"rpe_rotation_rmse_deg", JsonOf(row.rpe_rotation_rmse_deg)},
          {"seconds", JsonOf(row.seconds)},
          {"frame_ms", JsonOf(row.frame_ms)},
          {"peak_mb", JsonOf(row.peak_mb)},
          {"map_points", JsonOf(row.map_points)},
          {"digest", row.digest.empty() ? Json(nullptr) : Json(row.digest)},
          {"error", row.error.empty() ? Json(nullptr) : Json(row.error)}};
}

std::string InTable(const std::optional<double>& value, double unit, int digits) {
  return value ? Fixed(*value / unit, digits) : "";
}
std::string InTable(const std::optional<int>& value) { return value ? Concat(*value) : ""; }

int CountRows(const std::vector<BatchRow>& rows, const std::string& state) {
  return static_cast<int>(std::count_if(rows.begin(), rows.end(),
                                        [&](const BatchRow& row) { return row.state == state; }));
}

void WriteBatchPage(const std::string& batch, const std::string& sequences,
                    const std::vector<BatchRow>& rows) {
  PlainPage page;
  page.Paragraph(Concat(rows.size(), " sequences: ", CountRows(rows, "done"), " done, ",
                        CountRows(rows, "failed"), " failed, ", CountRows(rows, "open"), " open."));
  std::vector<std::vector<PlainPage::Cell>> table = {
      {"sequence", "state", "frames", "tracked", "lost", "skipped", "ATE (mm)", "RPE (mm)", "(deg)",
       "s", "ms/frame", "MB", "surfels (M)"}};
  for (const BatchRow& row : rows) {
    const auto link = [&](const std::string& file) {
      const std::string path = RunFile(row.sequence, file);
      return fs::exists(Concat(batch, "/", path)) ? path : "";
    };
    const std::string report = link("report.html");
    table.push_back(
        {{row.sequence, report.empty() ? link("summary.json") : report},
         {row.state, row.state == "open" ? "" : Concat("jobs/run_", row.sequence, ".log")},
         InTable(row.frames),
         InTable(row.frames_tracked),
         InTable(row.frames_lost),
         InTable(row.frames_skipped),
         InTable(row.ate_rmse_m, 1e-3, 1),
         InTable(row.rpe_translation_rmse_m, 1e-3, 1),
         InTable(row.rpe_rotation_rmse_deg, 1, 2),
         InTable(row.seconds, 1, 1),
         InTable(row.frame_ms, 1, 1),
         InTable(row.peak_mb, 1, 0),
         InTable(row.map_points, 1e6, 2)});
  }
  page.Table(table);
  page.Section("Failed jobs");
  if (CountRows(rows, "done") == static_cast<int>(rows.size())) page.Paragraph("None.");
  for (const BatchRow& row : rows) {
    if (row.state != "done") page.Paragraph(Concat(row.sequence, ": ", row.error));
  }
  for (const BatchRow& row : rows) {
    const std::string picture = RunFile(row.sequence, "trajectory.png");
    if (!fs::exists(Concat(batch, "/", picture))) continue;
    page.Section(row.sequence);
    page.Picture(picture);
  }
  page.Write("Batch of " + sequences, batch + "/report.html");
}

}  // namespace

std::vector<BatchRow> ReportBatch(const std::string& batch) {
  const PlannedBatch planned = ReadBatch(batch);
  std::vector<BatchRow> rows;
  Json json = Json::array();
  for (const std::string& name : planned.names) {
    rows.push_back(RowOf(batch, name));
    json.push_back(ToJson(rows.back()));
  }
  WriteCsv(json, batch + "/table.csv");
  WriteJson({{"sequences", planned.sequences},
             {"done", CountRows(rows, "done")},
             {"failed", CountRows(rows, "failed")},
             {"open", CountRows(rows, "open")},
             {"runs", json}},
            batch + "/summary.json");
  WriteBatchPage(batch, planned.sequences, rows);
  return rows;
}

void DeleteStaleRunReceipts(const std::string& batch, bool retry_failed) {
  DeleteReceipts(batch, retry_failed);
}

}  // namespace surfit
