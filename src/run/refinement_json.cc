#include "run/refinement_json.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "surfit/core/atomic_file.h"
#include "surfit/core/options.h"

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

Json LargestSigmasOf(const std::vector<Eigen::MatrixXd>& pose_covariances) {
  if (pose_covariances.empty()) return nullptr;
  double turn = 0, shift = 0;
  for (const Eigen::MatrixXd& covariance : pose_covariances) {
    turn = std::max(turn, covariance.diagonal().head<3>().maxCoeff());
    shift = std::max(shift, covariance.diagonal().tail<3>().maxCoeff());
  }
  return {{"rad", std::sqrt(turn)}, {"m", std::sqrt(shift)}};
}

Json ToJson(const RefinementFit& fit) {
  return {{"cost", fit.cost},
          {"rms_sigmas", fit.rms_sigmas},
          {"rms_m", fit.rms_m},
          {"rms_intensity", fit.rms_intensity}};
}

Json ToJson(const RefinementRound& round) {
  return {{"surfels", round.surfels},
          {"observations", round.observations},
          {"texture_observations", round.texture_observations},
          {"iterations", round.iterations},
          {"before", ToJson(round.before)},
          {"after", ToJson(round.after)},
          {"calibration", ToJson(round.calibration)}};
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
                      {"standard_deviations", SigmasOf(s.refinement.calibration_covariance)},
                      {"kept", s.refinement.calibration_kept},
                      {"squared_distance", s.refinement.calibration_distance},
                      {"limit", s.refinement.calibration_limit}};
  j["fit"] = {{"before", ToJson(s.refinement.before)}, {"after", ToJson(s.refinement.after)}};
  j["largest_standard_deviations_of_poses"] = LargestSigmasOf(s.refinement.pose_covariances);
  j["scale"] = "held: nothing in a sequence tells the size of the world";
  j["rounds"] = Json::array();
  for (const RefinementRound& round : s.refinement.rounds) j["rounds"].push_back(ToJson(round));
  j["map_points"] = s.map_points;
  j["total_s"] = s.total_s;
  j["options"] = FlagValues(options);
  WriteFileAtomically(path, [&](std::ostream& file) { file << j.dump(2) << '\n'; });
}

}  // namespace surfit
