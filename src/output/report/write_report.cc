#include "output/report/write_report.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "browser/page.h"
#include "core/shared_options.h"
#include "output/report/compare_runs.h"
#include "output/report/report_data.h"
#include "surfit/core/options.h"
#include "surfit/geometry/rigid3.h"

namespace surfit {
namespace {

using Json = nlohmann::ordered_json;

// Limit of all runs together.
constexpr std::size_t kMaxThumbnails = 120;

std::vector<std::optional<RunAlignment>> AlignWithFirst(const std::vector<ReportedRun>& runs) {
  std::vector<std::optional<RunAlignment>> alignments = {RunAlignment()};
  for (std::size_t i = 1; i < runs.size(); ++i) {
    alignments.push_back(AlignRuns(runs[i].trajectory, runs.front().trajectory));
  }
  return alignments;
}

Json ToJson(const RunAlignment& alignment) {
  const Rigid3d& pose = alignment.target_from_source;
  const Eigen::Quaterniond& q = pose.rotation;
  const Eigen::Vector3d& t = pose.translation;
  return {{"rotation", {q.x(), q.y(), q.z(), q.w()}},
          {"translation", {t.x(), t.y(), t.z()}},
          {"poses", alignment.poses},
          {"rms_m", alignment.rms_m}};
}

// Compares the first run with the second run, and all other runs with the first run.
void Compare(const std::vector<ReportedRun>& runs, std::size_t max_points,
             std::vector<Json>* pages) {
  if (runs.size() < 2) return;
  const auto alignments = AlignWithFirst(runs);
  for (std::size_t i = 0; i < runs.size(); ++i) {
    if (!alignments[i]) continue;
    (*pages)[i]["first_from_run"] = ToJson(*alignments[i]);
    const std::size_t other = i == 0 ? 1 : 0;
    if (!alignments[other]) continue;
    const Rigid3d other_from_run =
        alignments[other]->target_from_source.Inverse() * alignments[i]->target_from_source;
    (*pages)[i]["compared_with"] = (*pages)[other]["label"];
    (*pages)[i]["map"]["distance"] = PackDistances(DistancesFromMap(
        EvenlySpread(runs[i].surfels, max_points), other_from_run, runs[other].surfels));
  }
}

}  // namespace

void ReportOptions::Visit(OptionVisitor& v) {
  v.Add(runs, SharedOption("run", InField("runs"), Required(), Repeatable()));
  v.Add(output, SharedOption("output", Required()));
}

std::vector<ReportedMap> WriteReport(const ReportOptions& options) {
  constexpr std::size_t kMaxPoints = 500000;  // of all runs; larger maps are sampled evenly
  Validate(options);
  const std::size_t count = options.runs.size(), max_points = kMaxPoints / count;
  const std::vector<std::string> names = ShortNames(options.runs);
  std::vector<ReportedMap> maps;
  std::vector<ReportedRun> runs;
  std::vector<Json> pages;
  for (std::size_t i = 0; i < count; ++i) {
    runs.push_back(ReadRun(options.runs[i], std::max<std::size_t>(1, kMaxThumbnails / count)));
    Json page = std::move(runs[i].page);
    page["label"] = names[i];
    page["map"] = PackMap(runs[i].surfels, max_points);
    maps.push_back({options.runs[i], page["map"]["points"], page["map"]["shown"]});
    pages.push_back(std::move(page));
  }
  Compare(runs, max_points, &pages);
  WritePage(kReportPage, options.output, [&](std::ostream& file) {
    for (const Json& page : pages) WriteData("run", page, &file);
  });
  return maps;
}

}  // namespace surfit
