#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <utility>
#include <vector>

#include "optimization/elimination_tree.h"

namespace surfit {

// A sparse symmetric matrix of square blocks, zero at first.
class BlockMatrix {
 public:
  // Off the diagonal there is a block for each pair (a, b) of a pattern: it stands at row a, column
  // b, and transposed at row b, column a.
  BlockMatrix(int block_size, std::size_t row_count, std::size_t pair_count)
      : block_size_(block_size),
        diagonal_(Eigen::MatrixXd::Zero(block_size, block_size * row_count)),
        off_diagonal_(Eigen::MatrixXd::Zero(block_size, block_size * pair_count)) {}

  void SetZero() {
    diagonal_.setZero();
    off_diagonal_.setZero();
  }
  int block_size() const { return block_size_; }
  auto Diagonal(std::size_t row) { return diagonal_.middleCols(block_size_ * row, block_size_); }
  auto Diagonal(std::size_t row) const {
    return diagonal_.middleCols(block_size_ * row, block_size_);
  }
  auto OffDiagonal(std::size_t pair) {
    return off_diagonal_.middleCols(block_size_ * pair, block_size_);
  }
  auto OffDiagonal(std::size_t pair) const {
    return off_diagonal_.middleCols(block_size_ * pair, block_size_);
  }

 private:
  int block_size_;
  Eigen::MatrixXd diagonal_, off_diagonal_;  // side by side
};

// Cholesky's factorisation of such matrices by dense matrices (Liu: The multifrontal method for
// sparse matrix solution, SIAM Review 1992), on one thread.
class BlockCholesky {
 public:
  // For matrices of this many rows, in blocks, with off-diagonal blocks at pairs of two different
  // rows; blocks at the same place add up.
  BlockCholesky(int row_count, std::vector<std::pair<int, int>> pattern);

  // False if the matrix is not positive definite.
  bool Factorize(const BlockMatrix& matrix);

  // Solves for as many right-hand sides as there are columns, with the last factor.
  Eigen::MatrixXd Solve(const Eigen::MatrixXd& right_side) const;

 private:
  void AddOwnBlocks(const BlockMatrix& matrix, std::size_t supernode, Eigen::MatrixXd* panel) const;

  std::vector<std::pair<int, int>> pattern_;
  EliminationTree tree_;
  std::vector<int> rows_at_;             // which row of the matrix is at a position
  std::vector<std::vector<int>> pairs_;  // of pattern_, that each supernode takes in
  std::vector<Eigen::MatrixXd> panels_;  // the factor: a supernode's columns, its own rows first
  int block_size_ = 1;
};

}  // namespace surfit
