#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

#include "optimization/refinement/joint_state.h"
#include "optimization/refinement/shared_surfels.h"

namespace surfit {

RefinementFit Agreement(const JointFit& fit) {
  if (!(fit.weight > 0)) return {};
  const double intensity =
      fit.texture_weight > 0 ? std::sqrt(fit.squared_differences / fit.texture_weight) : 0;
  return {fit.rho / 2, std::sqrt(fit.squared_sigmas / fit.weight),
          std::sqrt(fit.squared_metres / fit.weight), intensity};
}

double VarianceOf(const JointFit& fit, const SharedSurfels& shared, const JointState& state,
                  const RefinementOptions& options) {
  const double all = static_cast<double>(shared.observations.size());
  const double found = static_cast<double>(shared.surfels.size() +
                                           kPoseTangentSize * state.world_from_camera.size());
  if (!(all > found && fit.weight > 0)) return 0;
  const double cells_per_window =
      static_cast<double>(options.correlation_px) / CellSize(state.calibration, options);
  return fit.squared_sigmas / fit.weight * all / (all - found) *
         std::max(1., cells_per_window * cells_per_window);
}

Eigen::MatrixXd ModelErrorOf(const DepthCalibration& calibration, const std::vector<bool>& held,
                             const RefinementOptions& options) {
  constexpr double kDepth_m = 3;
  const PinholeCamera& camera = calibration.camera;
  Eigen::Matrix<double, kCalibrationSize, 1> sigma;
  sigma.setConstant(options.model_error_ratio / kDepth_m);  // of inverse depth
  sigma.head<kFieldBegin>() =
      options.model_error_ratio * Eigen::Vector4d(camera.fx, camera.fy, camera.fx, camera.fy);
  sigma[kReadout] = options.model_error_ratio;  // s
  for (int i = 0; i < kCalibrationSize; ++i) {
    if (held[i]) sigma[i] = 0;
  }
  return sigma.cwiseAbs2().asDiagonal();
}

double CalibrationChange::Limit(double sigmas) const {
  return free + sigmas * std::sqrt(2. * free);
}

CalibrationChange ChangeOf(const DepthCalibration& calibration, const DepthCalibration& given,
                           const Eigen::MatrixXd& covariance) {
  using Vector = Eigen::Matrix<double, kCalibrationSize, 1>;
  Vector found, was;
  CalibrationToBlock(calibration, found.data());
  CalibrationToBlock(given, was.data());
  std::vector<Eigen::Index> free;
  for (Eigen::Index i = 0; i < kCalibrationSize; ++i) {
    if (covariance(i, i) > 0) free.push_back(i);
  }
  const Eigen::VectorXd change = (found - was)(free);
  // Scaling is necessary, because px and 1/m differ by orders of magnitude.
  const Eigen::VectorXd sigma = covariance.diagonal()(free).cwiseSqrt();
  const Eigen::MatrixXd correlation = sigma.cwiseInverse().asDiagonal() *
                                      covariance(free, free).eval() *
                                      sigma.cwiseInverse().asDiagonal();
  const Eigen::VectorXd scaled = change.cwiseQuotient(sigma);
  return {scaled.dot(correlation.ldlt().solve(scaled)), static_cast<int>(free.size())};
}

}  // namespace surfit
