#include "refinement/pose_factor.h"

namespace surfit {
namespace {

constexpr int kSize = kPoseTangentSize;

// Calls add(row, column, value) for the lower triangle of S P S + damping I without the first pose,
// column by column, rows ascending.
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

// With E the pose's columns of the identity, that is X^T X for L X = E.
ReducedSystem::PoseMatrix PoseFactor::InverseBlock(int pose) const {
  const Eigen::Index begin = kSize * (pose - 1);
  if (is_dense_) {
    // All above the pose's rows is zero.
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

}  // namespace surfit
