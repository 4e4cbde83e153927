#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCholesky>

#include "refinement/reduced_system.h"

namespace surfit {

// A Cholesky factor L L^T of the poses' part P of a reduced hessian, without the first pose, which
// is held.
//
// By Eigen's sparse solver, in minimum degree order, or by its dense one where that is faster: in a
// room that is seen all over again half of all pairs share surfels, and the factor of those is
// nearly full. Both run on one thread.
class PoseFactor {
 public:
  // Orders the unknowns and counts the operations.
  explicit PoseFactor(const BlockPattern& pattern);

  bool is_dense() const { return is_dense_; }

  // Of S P S + damping I, with ones on the diagonal of S P S in any case: scale, the diagonal of S,
  // makes them ones or is zero. False if that is not positive definite.
  bool Factorize(const ReducedSystem& system, const Eigen::VectorXd& scale, double damping);

  Eigen::MatrixXd Solve(const Eigen::MatrixXd& right) const;

  // The block of the inverse for a pose from 1 on.
  ReducedSystem::PoseMatrix InverseBlock(int pose) const;

 private:
  struct SparseLlt : Eigen::SimplicialLLT<Eigen::SparseMatrix<double>, Eigen::Lower> {
    // Multiplications that factorising takes, about; after analyzePattern().
    double Operations() const { return m_nonZerosPerCol.cast<double>().squaredNorm() / 2; }
  };
  // How many times as many operations the dense solver does in the same time, about: 6 with 1300
  // unknowns, 10 with 2300.
  static constexpr double kDenseSpeed = 10;

  Eigen::Index size_;
  SparseLlt sparse_llt_;
  Eigen::MatrixXd dense_;  // its lower triangle is L
  bool is_dense_;
};

}  // namespace surfit
