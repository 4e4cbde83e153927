#include "refinement/joint_cost.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "cost_functions/plane_inverse_depth.h"
#include "cost_functions/pose_manifold.h"

namespace surfit {
namespace {

// R and q of a system: see JointCost.
struct TriangularFactor {
  Eigen::MatrixXd r;
  Eigen::VectorXd q;
};

// Of the matrix scaled to a diagonal of ones, hence P S H S P^T = L D L^T with a permutation P, and
// R = sqrt(D) L^T P S^-1. The gauge and calibration that nothing observes make it semidefinite:
// pivots are at least what rounding leaves of zero. R^T q = gradient holds in any case.
TriangularFactor Factorize(const ReducedSystem& system) {
  constexpr double kLeastPivot = 1e-12;
  const Eigen::VectorXd scale =
      system.hessian.diagonal().unaryExpr([](double d) { return d > 0 ? 1 / std::sqrt(d) : 1.; });
  const Eigen::MatrixXd scaled = scale.asDiagonal() * system.hessian * scale.asDiagonal();
  const Eigen::LDLT<Eigen::MatrixXd, Eigen::Lower> ldlt(scaled);
  const Eigen::VectorXd pivots = ldlt.vectorD().cwiseMax(kLeastPivot).cwiseSqrt();
  TriangularFactor factor;
  factor.q = ldlt.transpositionsP() * (scale.asDiagonal() * system.gradient);
  ldlt.matrixL().solveInPlace(factor.q);
  factor.q.array() /= pivots.array();
  Eigen::MatrixXd root = ldlt.matrixL();
  root = ldlt.transpositionsP().transpose() * (root * pivots.asDiagonal()).eval();
  factor.r = (scale.cwiseInverse().asDiagonal() * root).transpose();
  return factor;
}

}  // namespace

void CalibrationToBlock(const DepthCalibration& calibration, double* block) {
  const PinholeCamera& camera = calibration.camera;
  block[0] = camera.fx, block[1] = camera.fy, block[2] = camera.cx, block[3] = camera.cy;
  std::copy(calibration.field.coefficients.begin(), calibration.field.coefficients.end(),
            block + kFieldBegin);
}

void CalibrationFromBlock(const double* block, DepthCalibration* calibration) {
  PinholeCamera& camera = calibration->camera;
  camera.fx = block[0], camera.fy = block[1], camera.cx = block[2], camera.cy = block[3];
  std::copy(block + kFieldBegin, block + kCalibrationSize, calibration->field.coefficients.begin());
}

JointCost::JointCost(const SharedSurfels& shared, const MotionPrior& prior,
                     const JointState& initial, const RobustKernel& kernel)
    : shared_(shared), prior_(prior), initial_(initial), kernel_(kernel) {
  const auto poses = static_cast<int>(initial.world_from_camera.size());
  mutable_parameter_block_sizes()->assign(poses, kPoseSize);
  mutable_parameter_block_sizes()->push_back(kCalibrationSize);
  set_num_residuals(kPoseTangentSize * poses + kCalibrationSize + 1);
}

JointState JointCost::StateOf(double const* const* parameters) const {
  JointState state = initial_;
  std::size_t block = 0;
  for (Rigid3d& pose : state.world_from_camera) pose = PoseFromBlock(parameters[block++]);
  CalibrationFromBlock(parameters[block], &state.calibration);
  return state;
}

bool JointCost::Evaluate(double const* const* parameters, double* residuals,
                         double** jacobians) const {
  const JointState state = StateOf(parameters);
  const int rows = num_residuals();
  if (jacobians == nullptr) {
    std::fill(residuals, residuals + rows, 0.);
    residuals[0] = std::sqrt(FitOf(shared_, state, kernel_).rho + prior_.Rho(state));
    return std::isfinite(residuals[0]);
  }
  ReducedSystem system = Reduce(shared_, state, kernel_);
  prior_.AddTo(state, &system);
  if (!std::isfinite(system.rho)) return false;
  const TriangularFactor factor = Factorize(system);
  Eigen::Map<Eigen::VectorXd>(residuals, rows - 1) = factor.q;
  residuals[rows - 1] = std::sqrt(std::max(0., system.rho - factor.q.squaredNorm()));

  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const std::size_t poses = state.world_from_camera.size();
  for (std::size_t k = 0; k < poses; ++k) {
    if (jacobians[k] == nullptr) continue;
    Eigen::Matrix<double, kPoseTangentSize, kPoseSize, Eigen::RowMajor> minus;
    ProductPoseManifold().MinusJacobian(parameters[k], minus.data());
    Eigen::Map<RowMajor> jacobian(jacobians[k], rows, kPoseSize);
    jacobian.topRows(rows - 1) =
        factor.r.middleCols<kPoseTangentSize>(kPoseTangentSize * k) * minus;
    jacobian.bottomRows(1).setZero();
  }
  if (jacobians[poses] != nullptr) {
    Eigen::Map<RowMajor> jacobian(jacobians[poses], rows, kCalibrationSize);
    jacobian.topRows(rows - 1) = factor.r.rightCols<kCalibrationSize>();
    jacobian.bottomRows(1).setZero();
  }
  return true;
}

}  // namespace surfit
