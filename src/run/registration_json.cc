#include "run/registration_json.h"

#include <nlohmann/json.hpp>

#include "surfit/core/atomic_file.h"
#include "surfit/core/options.h"

namespace surfit {
namespace {

using Json = nlohmann::ordered_json;

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
          {"points_without_normal", cloud.without_normal},
          {"normal_radius_m", cloud.normal_radius_m}};
}

}  // namespace

void WriteRegistrationJson(const RegisterRunResult& result, const RegisterRunOptions& options,
                           const std::string& path) {
  const IcpResult& icp = result.icp;
  Json j;
  j["target_from_source"] = Rows(icp.target_from_source.Matrix());
  j["termination"] = ToString(icp.termination);
  j["succeeded"] = icp.Succeeded();
  j["rmse_m"] = icp.rmse_m;
  j["inlier_count"] = icp.inlier_count;
  j["inlier_share"] = icp.inlier_share;
  j["step_count"] = icp.step_count;
  j["information"] = Rows(icp.information);
  j["covariance"] = icp.covariance ? Rows(*icp.covariance) : Json();
  j["eigenvalues"] = icp.eigenvalues;
  j["free_directions"] = icp.free_directions;
  j["source"] = ToJson(result.source, options.source);
  j["target"] = ToJson(result.target, options.target);
  j["residual"] = options.registration.icp.residual;
  j["association"] = options.registration.icp.association;
  j["solver"] = options.registration.icp.solver;
  j["options"] = FlagValues(options);
  WriteFileAtomically(path, [&](std::ostream& file) {
    file << j.dump(2, ' ', false, Json::error_handler_t::replace) << '\n';
  });
}

}  // namespace surfit
