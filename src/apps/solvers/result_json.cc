#include "apps/solvers/result_json.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/shared_options.h"
#include "output/output_files.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"

namespace surfit {
namespace {

Json Rows(const Eigen::MatrixXd& matrix) {
  Json rows = Json::array();
  for (int i = 0; i < matrix.rows(); ++i) {
    Json row = Json::array();
    for (int k = 0; k < matrix.cols(); ++k) row.push_back(matrix(i, k));
    rows.push_back(row);
  }
  return rows;
}

Json ToJson(const RegisteredCloud& cloud, const std::string& path) {
  return {{"path", path},
          {"points", cloud.points},
          {"points_not_finite", cloud.not_finite},
          {"points_duplicate", cloud.duplicates},
          {"points_without_normal", cloud.without_normal},
          {"normal_radius_m", cloud.normal_radius_m}};
}

Json AteOf(const std::optional<TrajectoryEvaluation>& evaluation) {
  if (!evaluation || !evaluation->ate) return nullptr;
  return evaluation->ate->translation_m.rmse;
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

Json ToJson(const std::optional<double>& value) { return value ? Json(*value) : Json(); }

// First members of registration.json. The caller adds further members of `verification`.
template <typename Verified, typename Criteria>
Json PoseToJson(const IcpResult& icp, const Verified& verified, const Criteria& criteria) {
  Json j;
  j["target_from_source"] = Rows(icp.target_from_source.Matrix());
  j["termination"] = ToString(icp.termination);
  j["succeeded"] = verified.accepted();
  j["start"] = nullptr;
  j["verification"] = {{"result", ToString(verified.reason)},
                       {"violated_criterion", ViolatedCriterion(verified, criteria)},
                       {"overlap_ratio", verified.overlap_ratio},
                       {"score_margin", verified.score_margin},
                       {"forward_backward_m", verified.disagreement_m},
                       {"largest_sigma_m", verified.sigma_m}};
  return j;
}

void AddStatistics(const IcpResult& icp, const IcpOptions& options, const std::string& assumptions,
                   Json* json) {
  Json& j = *json;
  j["rmse_m"] = icp.rmse_m;
  j["inlier_count"] = icp.inlier_count;
  j["inlier_ratio"] = icp.inlier_ratio;
  j["step_count"] = icp.step_count;
  j["information"] = Rows(icp.information);
  j["covariance"] = icp.covariance ? Rows(*icp.covariance) : Json();
  j["covariance_assumptions"] =
      Concat("left perturbation (rad, m) about the origin of the target; ", assumptions,
             "; no systematic error of the sensor");
  j["eigenvalues"] = icp.eigenvalues;
  j["degenerate_directions"] = icp.degenerate_directions;
  j["residual"] = options.residual;
  j["association"] = options.association;
  j["solver"] = options.solver;
}

Json ToJson(const std::optional<PoseError>& error) {
  if (!error) return nullptr;
  return {{"m", error->translation_m}, {"deg", error->rotation_deg}};
}

}  // namespace

void WriteRegistrationJson(const RegisterRunResult& result, const RegisterRunOptions& options,
                           const std::string& path) {
  const CloudRegistration& registration = result.registration;
  Json j = PoseToJson(registration.icp, registration, options.start.criteria);
  j["start"] = registration.start;
  j["verification"]["surface_inlier_ratio"] = registration.inlier_ratio;
  j["verification"]["free_space_violation_ratio"] = ToJson(registration.free_space_violation_ratio);
  j["verification"]["point_spacing_m"] = registration.spacing_m;
  j["verification"]["noise_m"] = registration.noise_m;
  AddStatistics(registration.icp, options.registration.icp,
                Concat("errors of points more than ", kErrorSpacings,
                       " point spacings apart are independent"),
                &j);
  j["source"] = ToJson(result.source, options.source);
  j["target"] = ToJson(result.target, options.target);
  RegisterRunOptions recorded = options;
  j["options"] = RecordedValues(TableOf(&recorded));
  WriteJson(j, path);
}

void WriteAlignmentJson(const AlignRunResult& result, const AlignRunOptions& options,
                        const std::string& path) {
  const GlobalRegistrationResult& registration = result.registration;
  Json j = PoseToJson(registration.icp, registration, options.initialize.fit);
  j["start"] = options.initialize.method;
  if (options.initialize.method == "identity") {
    j["verification"] = nullptr;
  } else {
    j["verification"]["value_correlation"] = registration.value_correlation;
    j["verification"]["detail_correlation"] = registration.detail_correlation;
  }
  j["free_space_violation_ratio"] = registration.icp.free_space_violation_ratio;
  AddStatistics(registration.icp, options.icp, "errors of different image blocks are independent",
                &j);
  j["pose_error"] = {{"before", ToJson(result.initial_error)},
                     {"after", ToJson(result.final_error)}};
  j["source_frame"] = options.source;
  j["target_frame"] = options.target;
  j["options"] = FlagValues(options);
  WriteJson(j, path);
}

void WriteRefinementJson(const RefineRunSummary& s, const RefineRunOptions& options,
                         const std::string& path) {
  Json j;
  j["termination"] = ToString(s.refinement.termination);
  j["poses"] = s.poses;
  j["keyframes"] = s.keyframes;
  j["frames_without_pose"] = s.frames_without_pose;
  j["frames_unreadable"] = s.frames_unreadable;
  j["ate_rmse_m"] = {{"before", AteOf(s.before)}, {"after", AteOf(s.after)}};
  j["calibration"] = {
      {"before", ToJson(s.given)},
      {"after", ToJson(s.calibration)},
      {"standard_deviations", CalibrationSigmasToJson(s.refinement.calibration_covariance)},
      {"kept", s.refinement.calibration_kept},
      {"squared_distance", s.refinement.calibration_distance},
      {"limit", s.refinement.calibration_limit}};
  j["fit"] = {{"before", ToJson(s.refinement.before)}, {"after", ToJson(s.refinement.after)}};
  j["largest_standard_deviations_of_poses"] = LargestSigmasOf(s.refinement.pose_covariances);
  j["scale"] = "fixed: not observable";
  j["rounds"] = Json::array();
  for (const RefinementRound& round : s.refinement.rounds) j["rounds"].push_back(ToJson(round));
  j["map_points"] = s.map_points;
  j["total_s"] = s.total_s;
  j["failure"] = s.failure.empty() ? Json() : Json(s.failure);
  RefineRunOptions recorded = options;
  j["options"] = RecordedValues(TableOf(&recorded));
  WriteJson(j, path);
}

}  // namespace surfit
