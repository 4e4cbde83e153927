#include "optimization/refinement/reduced_factor.h"

#include <cmath>
#include <limits>

#include "surfit/core/parallel.h"

namespace surfit {
namespace {

constexpr int kSize = kPoseTangentSize;

// Calls add(row, column, value) for the lower triangle of S P S + damping I without the first pose,
// by columns, with ascending rows.
template <typename Add>
void ForEachLower(const ReducedSystem& system, const Eigen::VectorXd& scale, double damping,
                  const Add& add) {
  const BlockPattern& pattern = *system.pattern;
  for (Eigen::Index column = 0; column < kSize * (pattern.pose_count() - 1); ++column) {
    const int first = static_cast<int>(column / kSize) + 1, j = static_cast<int>(column % kSize);
    add(column, column, 1 + damping);
    for (int pose = first; pose < pattern.pose_count(); ++pose) {
      const std::int32_t block = pattern.IndexOf(pose, first);
      if (block == BlockPattern::kNoBlock) continue;
      for (int i = pose == first ? j + 1 : 0; i < kSize; ++i) {
        const Eigen::Index row = kSize * (pose - 1) + i;
        add(row, column, scale[kSize + row] * scale[kSize + column] * system.poses[block](i, j));
      }
    }
  }
}

Eigen::SparseMatrix<double> SparseLower(const ReducedSystem& system, const Eigen::VectorXd& scale,
                                        double damping) {
  const Eigen::Index size = kSize * (system.pattern->pose_count() - 1);
  Eigen::SparseMatrix<double> lower(size, size);
  lower.reserve(static_cast<Eigen::Index>(system.poses.size() * kSize * kSize));
  ForEachLower(system, scale, damping, [&](Eigen::Index row, Eigen::Index column, double value) {
    if (row == column) lower.startVec(column);
    lower.insertBack(row, column) = value;
  });
  lower.finalize();
  return lower;
}

double ScaleOf(double diagonal) { return diagonal > 0 ? 1 / std::sqrt(diagonal) : 0; }

}  // namespace

PoseFactor::PoseFactor(const BlockPattern& pattern) : size_(kSize * (pattern.pose_count() - 1)) {
  const Eigen::VectorXd scale = Eigen::VectorXd::Zero(size_ + kSize);
  sparse_llt_.analyzePattern(SparseLower(ReducedSystem(pattern), scale, 0));
  const auto size = static_cast<double>(size_);
  is_dense_ = sparse_llt_.Operations() * kDenseSpeed > size * size * size / 6;
}

bool PoseFactor::Factorize(const ReducedSystem& system, const Eigen::VectorXd& scale,
                           double damping) {
  if (!is_dense_) {
    sparse_llt_.factorize(SparseLower(system, scale, damping));
    return sparse_llt_.info() == Eigen::Success;
  }
  dense_.setZero(size_, size_);
  ForEachLower(system, scale, damping, [&](Eigen::Index row, Eigen::Index column, double value) {
    dense_(row, column) = value;
  });
  return Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>>(dense_).info() == Eigen::Success;
}

Eigen::MatrixXd PoseFactor::Solve(const Eigen::MatrixXd& right) const {
  if (!is_dense_) return sparse_llt_.solve(right);
  const auto lower = dense_.triangularView<Eigen::Lower>();
  return lower.transpose().solve(lower.solve(right));
}

// With the columns E of the identity for this pose, the block is X^T X for L X = E.
ReducedSystem::PoseMatrix PoseFactor::InverseBlock(int pose) const {
  const Eigen::Index begin = kSize * (pose - 1);
  if (is_dense_) {
    const Eigen::Index rest = size_ - begin;
    const Eigen::MatrixXd x = dense_.bottomRightCorner(rest, rest)
                                  .triangularView<Eigen::Lower>()
                                  .solve(Eigen::MatrixXd::Identity(rest, kSize));
    return x.transpose() * x;
  }
  Eigen::MatrixXd unit = Eigen::MatrixXd::Zero(size_, kSize);
  unit.middleRows<kSize>(begin).setIdentity();
  Eigen::MatrixXd x = sparse_llt_.permutationP() * unit;
  sparse_llt_.matrixL().solveInPlace(x);
  return x.transpose() * x;
}

ReducedFactor::ReducedFactor(const BlockPattern& pattern,
                             const std::vector<bool>& fixed_calibration)
    : fixed_calibration_(fixed_calibration), poses_(pattern) {}

void ReducedFactor::SetScale(const ReducedSystem& system) {
  scale_ = Eigen::VectorXd::Zero(system.gradient.size());
  for (int k = 1; k < system.pattern->pose_count(); ++k) {
    scale_.segment<kPoseTangentSize>(kPoseTangentSize * k) =
        system.poses[system.pattern->IndexOf(k, k)].diagonal().unaryExpr(&ScaleOf);
  }
  for (int i = 0; i < kCalibrationSize; ++i) {
    if (fixed_calibration_[i]) continue;
    scale_[system.CalibrationBegin() + i] = ScaleOf(system.calibration(i, i));
  }
}

Eigen::MatrixXd ReducedFactor::ScaledBorder(const ReducedSystem& system) const {
  const auto calibration = scale_.tail<kCalibrationSize>().asDiagonal();
  Eigen::MatrixXd border(system.CalibrationBegin() - kPoseTangentSize, kCalibrationSize);
  for (std::size_t k = 1; k < system.mixed.size(); ++k) {
    const auto row = static_cast<Eigen::Index>(kPoseTangentSize * k);
    border.middleRows<kPoseTangentSize>(row - kPoseTangentSize) =
        scale_.segment<kPoseTangentSize>(row).asDiagonal() * system.mixed[k].transpose() *
        calibration;
  }
  return border;
}

bool ReducedFactor::Factorize(const ReducedSystem& system, double damping) {
  damping_ = damping;
  SetScale(system);
  if (!poses_.Factorize(system, scale_, damping)) return false;
  border_ = ScaledBorder(system);
  solved_border_ = poses_.Solve(border_);
  const auto scale = scale_.tail<kCalibrationSize>().asDiagonal();
  CalibrationMatrix calibration = scale * system.calibration * scale;
  calibration.diagonal().setConstant(1 + damping);
  calibration -= border_.transpose() * solved_border_;
  calibration_.compute(calibration);
  return calibration_.info() == Eigen::Success;
}

// With (S H S + damping I) y = S g, the step is -S y. The predicted rho = r^2 of the model is
//   rho - 2 g . S y + y . S H S y = rho - g . S y - damping y . y.
ReducedStep ReducedFactor::Solve(const Eigen::VectorXd& gradient) const {
  const Eigen::VectorXd scaled = scale_.cwiseProduct(gradient);
  const Eigen::Index poses = scaled.size() - kPoseTangentSize - kCalibrationSize;
  const Eigen::VectorXd of_poses = scaled.segment(kPoseTangentSize, poses);
  Eigen::VectorXd y = Eigen::VectorXd::Zero(scaled.size());
  y.tail<kCalibrationSize>() =
      calibration_.solve(scaled.tail<kCalibrationSize>() - solved_border_.transpose() * of_poses);
  y.segment(kPoseTangentSize, poses) =
      poses_.Solve(of_poses) - solved_border_ * y.tail<kCalibrationSize>();
  return {-scale_.cwiseProduct(y), scaled.dot(y) + damping_ * y.squaredNorm()};
}

// Block inverse: P^-1 + P^-1 B (C - B^T P^-1 B)^-1 B^T P^-1.
Eigen::MatrixXd ReducedFactor::PoseCovariance(int pose) const {
  using Rows = Eigen::Matrix<double, kPoseTangentSize, kCalibrationSize>;
  const Eigen::Index begin = kPoseTangentSize * pose;
  const Eigen::VectorXd scale = scale_.segment<kPoseTangentSize>(begin);
  const Rows solved = solved_border_.middleRows<kPoseTangentSize>(begin - kPoseTangentSize);
  Eigen::MatrixXd covariance =
      poses_.InverseBlock(pose) + solved * calibration_.solve(solved.transpose());
  covariance = scale.asDiagonal() * covariance * scale.asDiagonal();
  for (int i = 0; i < kPoseTangentSize; ++i) {
    if (scale[i] == 0) covariance(i, i) = std::numeric_limits<double>::infinity();
  }
  return covariance;
}

JointCovariance ReducedFactor::Covariance() const {
  const auto scale = scale_.tail<kCalibrationSize>().asDiagonal();
  const CalibrationMatrix calibration = calibration_.solve(CalibrationMatrix::Identity());
  JointCovariance covariance;
  covariance.calibration = scale * calibration * scale;
  const auto count = static_cast<int>((scale_.size() - kCalibrationSize) / kPoseTangentSize);
  covariance.poses.assign(count, Eigen::MatrixXd::Zero(kPoseTangentSize, kPoseTangentSize));
  ParallelFor(1, count, 1, [&](int begin, int end) {
    for (int k = begin; k < end; ++k) covariance.poses[k] = PoseCovariance(k);
  });
  return covariance;
}

// The factorised matrix is C - B^T P^-1 B with C = S H_cc S + damping I, and 1 for fixed
// parameters.
CalibrationModel ReducedFactor::Marginal(const Eigen::VectorXd& gradient) const {
  const CalibrationRow scale = scale_.tail<kCalibrationSize>();
  const CalibrationRow unscale = scale.unaryExpr([](double s) { return s > 0 ? 1 / s : 0; });
  const Eigen::VectorXd scaled = scale_.cwiseProduct(gradient);
  const Eigen::Index poses = scaled.size() - kPoseTangentSize - kCalibrationSize;
  const CalibrationRow reduced =
      scaled.tail<kCalibrationSize>() -
      solved_border_.transpose() * scaled.segment(kPoseTangentSize, poses);
  CalibrationMatrix matrix = calibration_.reconstructedMatrix();
  matrix.diagonal().array() -= damping_;
  return {unscale.asDiagonal() * matrix * unscale.asDiagonal(), unscale.cwiseProduct(reduced)};
}

namespace {

void FactorizeDamped(const ReducedSystem& system, ReducedFactor* factor) {
  // Typical rounding error of the pivots of a singular matrix with a unit diagonal.
  constexpr double kMinPivot = 1e-12, kGrowth = 10;
  double damping = kMinPivot;
  while (damping < 1 && !factor->Factorize(system, damping)) damping *= kGrowth;
}

}  // namespace

JointCovariance CovarianceOf(const ReducedSystem& system,
                             const std::vector<bool>& fixed_calibration) {
  ReducedFactor factor(*system.pattern, fixed_calibration);
  FactorizeDamped(system, &factor);
  return factor.Covariance();
}

CalibrationModel MarginalOf(const ReducedSystem& system,
                            const std::vector<bool>& fixed_calibration) {
  ReducedFactor factor(*system.pattern, fixed_calibration);
  FactorizeDamped(system, &factor);
  return factor.Marginal(system.gradient);
}

}  // namespace surfit
