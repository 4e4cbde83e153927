#include "apps/solvers/comparison_files.h"
#include "browser/page.h"

namespace surfit {
namespace {

using Json = nlohmann::ordered_json;

// Initial pose for the convergence plot. Both indices are equal, because slow combinations run only
// for equal indices.
PerturbationCell ShownStart(const CompareOptions& options) {
  const bool has_second = options.rotations_deg.size() > 1 && options.translations_m.size() > 1;
  return has_second ? PerturbationCell{1, 1} : PerturbationCell{0, 0};
}

// Elements: [ratio, lower limit, upper limit] of converged runs, see WilsonInterval(). Rows:
// initial rotation errors. Columns: initial translation errors. null without ground truth.
Json SharesOf(const ComparedRuns& runs, const CompareOptions& options) {
  if (!runs.runs.front().converged) return nullptr;
  Json shares = Json::array();
  for (std::size_t i = 0; i < options.rotations_deg.size(); ++i) {
    Json row = Json::array();
    for (std::size_t j = 0; j < options.translations_m.size(); ++j) {
      const RunCounts counts = CountsOf(runs, {static_cast<int>(i), static_cast<int>(j)});
      const auto [low, high] = WilsonInterval(counts);
      row.push_back(counts.runs > 0 ? Json{*counts.Ratio(), low, high} : Json(nullptr));
    }
    shares.push_back(row);
  }
  return shares;
}

Json LossesOf(const ComparedRuns& runs, const PerturbationCell& start) {
  for (const ComparedRun& run : runs.runs) {
    if (run.problem == 0 && run.cell == start) return run.outcome.losses;
  }
  return Json::array();
}

Json DataOf(const std::vector<ComparedRuns>& all, const std::vector<std::string>& notes,
            const CompareOptions& options) {
  const PerturbationCell start = ShownStart(options);
  Json rows = Json::array();
  for (const ComparedRuns& runs : all) {
    if (runs.runs.empty()) continue;
    Json row = ToJson(RowOf(runs));
    row["title"] = runs.combination.SolverTitle();
    row["shares"] = SharesOf(runs, options);
    row["losses"] = LossesOf(runs, start);
    rows.push_back(row);
  }
  return {{"known_pairs", options.synthetic_points > 0},
          {"refinement", !options.run.empty()},
          {"rotations_deg", options.rotations_deg},
          {"translations_m", options.translations_m},
          {"max_rotation_error_deg", kMaxRotationError_deg},
          {"max_translation_error_m", kMaxTranslationError_m},
          {"start",
           {{"rotation_deg", options.rotations_deg[start.rotation]},
            {"translation_m", options.translations_m[start.translation]}}},
          {"notes", notes},
          {"rows", rows}};
}

}  // namespace

void WriteComparisonPage(const std::vector<ComparedRuns>& all,
                         const std::vector<std::string>& notes, const CompareOptions& options) {
  const Json data = DataOf(all, notes, options);
  if (data["rows"].empty()) return;
  WritePage(kComparisonPage, options.output + "/comparison.html",
            [&](std::ostream& file) { WriteData("comparison", data, &file); });
}

}  // namespace surfit
