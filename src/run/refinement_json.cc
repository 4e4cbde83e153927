#include "run/refinement_json.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "surfit/core/atomic_file.h"

namespace surfit {
namespace {

using Json = nlohmann::ordered_json;

Json AteOf(const std::optional<TrajectoryEvaluation>& evaluation) {
  if (!evaluation || !evaluation->ate) return nullptr;
  return evaluation->ate->translation_m.rmse;
}

Json ToJson(const DepthCalibration& calibration) {
  const PinholeCamera& c = calibration.camera;
  return {{"fx", c.fx},
          {"fy", c.fy},
          {"cx", c.cx},
          {"cy", c.cy},
          {"inverse_depth_field", calibration.field.coefficients}};
}

Json SigmasOf(const Eigen::MatrixXd& covariance) {
  if (covariance.size() == 0) return nullptr;
  const Eigen::VectorXd sigma = covariance.diagonal().cwiseSqrt();
  const std::vector<double> field(sigma.data() + 4, sigma.data() + sigma.size());
  return {{"fx", sigma[0]},
          {"fy", sigma[1]},
          {"cx", sigma[2]},
          {"cy", sigma[3]},
          {"inverse_depth_field", field}};
}

Json ToJson(const RefinementFit& fit) {
  return {{"cost", fit.cost}, {"rms_sigmas", fit.rms_sigmas}, {"rms_m", fit.rms_m}};
}

Json ToJson(const RefinementRound& round) {
  return {{"surfels", round.surfels},       {"observations", round.observations},
          {"iterations", round.iterations}, {"before", ToJson(round.before)},
          {"after", ToJson(round.after)},   {"calibration", ToJson(round.calibration)}};
}

}  // namespace

void WriteRefinementJson(const RefineRunSummary& s, const RefineRunOptions& options,
                         const std::string& path) {
  Json j;
  j["termination"] = ToString(s.refinement.termination);
  j["poses"] = s.poses;
  j["keyframes"] = s.keyframes;
  j["frames_without_pose"] = s.frames_without_pose;
  j["frames_unreadable"] = s.frames_unreadable;
  j["ate_rmse_m"] = {{"before", AteOf(s.before)}, {"after", AteOf(s.after)}};
  j["calibration"] = {{"before", ToJson(s.given)},
                      {"after", ToJson(s.calibration)},
                      {"standard_deviations", SigmasOf(s.refinement.calibration_covariance)}};
  j["scale"] = "held: nothing in a sequence tells the size of the world";
  j["rounds"] = Json::array();
  for (const RefinementRound& round : s.refinement.rounds) j["rounds"].push_back(ToJson(round));
  j["map_points"] = s.map_points;
  j["total_s"] = s.total_s;
  j["options"] = options.record;
  WriteFileAtomically(path, [&](std::ostream& file) { file << j.dump(2) << '\n'; });
}

}  // namespace surfit
