#include "apps/solvers/comparison_files.h"

#include "surfit/core/atomic_file.h"

namespace surfit {
namespace {

using Json = nlohmann::ordered_json;

Json ToJson(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }
Json ToJson(const std::string& text) { return text.empty() ? Json(nullptr) : Json(text); }

Json ToJson(const SlamComparisonRow& row) {
  return {{"solver", row.combination.solver},
          {"linear_solver", ToJson(row.combination.linear_solver)},
          {"residual", row.combination.residual},
          {"association", row.combination.association},
          {"threads", row.threads},
          {"frames", row.frames},
          {"frames_lost", row.frames_lost},
          {"ate_m", ToJson(row.ate_m)},
          {"frame_ms", row.frame_ms},
          {"track_ms", row.track_ms},
          {"map_points", row.map_points},
          {"surface_distance_mean_m", ToJson(row.surface_distance_mean_m)},
          {"surface_distance_p90_m", ToJson(row.surface_distance_p90_m)},
          {"shared_surface", ToJson(row.shared_surface)}};
}

template <typename Row>
Json AllToJson(const std::vector<Row>& rows) {
  Json json = Json::array();
  for (const Row& row : rows) json.push_back(ToJson(row));
  return json;
}

}  // namespace

Json ToJson(const ComparisonRow& row) {
  return {{"solver", row.combination.solver},
          {"linear_solver", ToJson(row.combination.linear_solver)},
          {"residual", row.combination.residual},
          {"association", row.combination.association},
          {"points", row.points},
          {"threads", row.threads},
          {"runs", row.runs},
          {"build_ms", ToJson(row.build_ms)},
          {"linearize_ms", ToJson(row.linearize_ms)},
          {"solve_ms", ToJson(row.solve_ms)},
          {"total_ms", row.total_ms},
          {"iterations", row.iterations},
          {"iteration_ms", ToJson(row.iteration_ms)},
          {"memory_bytes", ToJson(row.memory_bytes)},
          {"final_cost", ToJson(row.final_cost)},
          {"rotation_error_deg", ToJson(row.rotation_error_deg)},
          {"translation_error_m", ToJson(row.translation_error_m)},
          {"converged_ratio", ToJson(row.converged_ratio)},
          {"converged_low", ToJson(row.converged_low)},
          {"converged_high", ToJson(row.converged_high)},
          {"termination", ToJson(row.termination)}};
}

void WriteComparisonFiles(const Comparison& comparison, const std::string& folder) {
  Json json;
  json["rows"] = AllToJson(comparison.rows);
  WriteCsv(json["rows"], folder + "/comparison.csv");
  if (!comparison.slam.empty()) {
    json["slam"] = AllToJson(comparison.slam);
    WriteCsv(json["slam"], folder + "/slam.csv");
  }
  json["notes"] = comparison.notes;
  WriteFileAtomically(folder + "/comparison.json",
                      [&](std::ostream& file) { file << json.dump(2) << '\n'; });
}

}  // namespace surfit
