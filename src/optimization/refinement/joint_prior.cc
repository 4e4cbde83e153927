#include <ceres/normal_prior.h>

#include <Eigen/Cholesky>

#include "cost_functions/kernel_loss.h"
#include "cost_functions/pose_manifold.h"
#include "optimization/refinement/joint_solver.h"

namespace surfit {
namespace {

// Bounds the gradient of inconsistent edges, for example across lost frames. Six residuals of
// unit variance have a norm of 2.4.
constexpr RobustKernel kKernel = {RobustKernelType::kHuber, 4};

PoseInformation InformationOf(double sigma_m, double sigma_rad) {
  PoseInformation information = PoseInformation::Identity();
  information.diagonal().head<3>().setConstant(1 / (sigma_rad * sigma_rad));
  information.diagonal().tail<3>().setConstant(1 / (sigma_m * sigma_m));
  return information;
}

// Returns A with A^T A = information, which may be singular.
ceres::Matrix RootOf(const ReducedSystem::CalibrationMatrix& information) {
  using Matrix = ReducedSystem::CalibrationMatrix;
  const Eigen::LDLT<Matrix> ldlt(information);
  const CalibrationRow roots = ldlt.vectorD().cwiseMax(0).cwiseSqrt();
  const Matrix upper = ldlt.matrixU(), order = ldlt.transpositionsP() * Matrix::Identity();
  return roots.asDiagonal() * upper * order;
}

struct EdgeRows {
  Eigen::Matrix<double, 6, 1> residual;
  Eigen::Matrix<double, 6, 2 * kPoseTangentSize> jacobian;  // by the perturbations of both poses
};

EdgeRows RowsOf(const AnalyticRelativePose& edge, const Rigid3d& a, const Rigid3d& b) {
  using ByBlock = Eigen::Matrix<double, 6, kPoseSize, Eigen::RowMajor>;
  double blocks[2][kPoseSize];
  PoseToBlock(a, blocks[0]);
  PoseToBlock(b, blocks[1]);
  const double* poses[] = {blocks[0], blocks[1]};
  ByBlock by_block[2];
  double* jacobians[] = {by_block[0].data(), by_block[1].data()};
  EdgeRows rows;
  edge.Evaluate(poses, rows.residual.data(), jacobians);
  for (int i = 0; i < 2; ++i) {
    Eigen::Matrix<double, kPoseSize, kPoseTangentSize, Eigen::RowMajor> plus;
    ProductPoseManifold().PlusJacobian(blocks[i], plus.data());
    rows.jacobian.middleCols<kPoseTangentSize>(kPoseTangentSize * i) = by_block[i] * plus;
  }
  return rows;
}

}  // namespace

JointPrior::JointPrior(const std::vector<Rigid3d>& world_from_camera, double sigma_m,
                       double sigma_rad) {
  const PoseInformation information = InformationOf(sigma_m, sigma_rad);
  for (std::size_t k = 1; k < world_from_camera.size(); ++k) {
    edges_.push_back(std::make_unique<AnalyticRelativePose>(
        world_from_camera[k - 1].Inverse() * world_from_camera[k], information));
  }
}

JointPrior::JointPrior(const DepthCalibration& given, const CalibrationPrior& prior) {
  CalibrationToBlock(given, given_.data());
  const auto information = [](double sigma) { return sigma > 0 ? 1 / (sigma * sigma) : 0; };
  const PinholeCamera& camera = given.camera;
  information_.diagonal().setConstant(information(prior.inverse_depth_sigma));
  information_(kReadout, kReadout) = information(prior.readout_s);
  information_.diagonal().head<kFieldBegin>()
      << information(prior.focal_relative_sigma * camera.fx),
      information(prior.focal_relative_sigma * camera.fy), information(prior.center_px),
      information(prior.center_px);
  // Residual of the aspect ratio: (fx / given fx - fy / given fy) / aspect_relative_sigma.
  CalibrationRow aspect = CalibrationRow::Zero();
  aspect.head<2>() << 1 / camera.fx, -1 / camera.fy;
  information_ += information(prior.aspect_relative_sigma) * aspect * aspect.transpose();
  if (!information_.isZero(0)) {
    residuals_ = std::make_unique<ceres::NormalPrior>(RootOf(information_), given_);
  }
}

CalibrationRow JointPrior::ChangeOf(const DepthCalibration& calibration) const {
  CalibrationRow now;
  CalibrationToBlock(calibration, now.data());
  return now - given_;
}

double JointPrior::Rho(const JointState& state) const {
  const CalibrationRow change = ChangeOf(state.calibration);
  double rho = weight_ * change.dot(information_ * change);
  for (std::size_t k = 0; k < edges_.size(); ++k) {
    double a[kPoseSize], b[kPoseSize];
    PoseToBlock(state.world_from_camera[k], a);
    PoseToBlock(state.world_from_camera[k + 1], b);
    const double* poses[] = {a, b};
    Eigen::Matrix<double, 6, 1> residual;
    edges_[k]->Evaluate(poses, residual.data(), nullptr);
    rho += weight_ * EvaluateKernel(kKernel, residual.squaredNorm()).rho;
  }
  return rho;
}

void JointPrior::AddTo(const JointState& state, ReducedSystem* system) const {
  const CalibrationRow change = ChangeOf(state.calibration);
  system->calibration += weight_ * information_;
  system->gradient.tail<kCalibrationSize>() += weight_ * information_ * change;
  system->rho += weight_ * change.dot(information_ * change);
  for (std::size_t k = 0; k < edges_.size(); ++k) {
    const EdgeRows rows =
        RowsOf(*edges_[k], state.world_from_camera[k], state.world_from_camera[k + 1]);
    const KernelValue<double> kernel = EvaluateKernel(kKernel, rows.residual.squaredNorm());
    const double weight = weight_ * kernel.slope;
    const auto a = rows.jacobian.leftCols<kPoseTangentSize>();
    const auto b = rows.jacobian.rightCols<kPoseTangentSize>();
    const int first = static_cast<int>(k), second = first + 1;
    system->PoseBlock(first, first) += weight * a.transpose() * a;
    system->PoseBlock(second, first) += weight * b.transpose() * a;
    system->PoseBlock(second, second) += weight * b.transpose() * b;
    system->gradient.segment<2 * kPoseTangentSize>(kPoseTangentSize * first) +=
        weight * rows.jacobian.transpose() * rows.residual;
    system->rho += weight_ * kernel.rho;
  }
}

void JointPrior::AddTo(const std::vector<double*>& poses, double* calibration,
                       std::vector<std::unique_ptr<ceres::LossFunction>>* losses,
                       ceres::Problem* problem) const {
  const auto weighted = [&](std::unique_ptr<ceres::LossFunction> loss) {
    losses->push_back(
        std::make_unique<ceres::ScaledLoss>(loss.release(), weight_, ceres::TAKE_OWNERSHIP));
    return losses->back().get();
  };
  if (residuals_) problem->AddResidualBlock(residuals_.get(), weighted(nullptr), calibration);
  for (std::size_t k = 0; k < edges_.size(); ++k) {
    problem->AddResidualBlock(edges_[k].get(), weighted(std::make_unique<KernelLoss>(kKernel)),
                              poses[k], poses[k + 1]);
  }
}

}  // namespace surfit
