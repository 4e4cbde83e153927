#include "optimization/block_cholesky.h"

#include <Eigen/Cholesky>
#include <algorithm>

namespace surfit {
namespace {

using Eigen::MatrixXd;

// The place of each of a child's rows among the columns and rows of its parent.
std::vector<int> PlacesInParent(const Supernode& child, const Supernode& parent) {
  std::vector<int> places;
  auto row = parent.rows.begin();
  for (const int r : child.rows) {
    if (r <= parent.last()) {
      places.push_back(r - parent.first);
    } else {
      row = std::lower_bound(row, parent.rows.end(), r);
      places.push_back(parent.count + static_cast<int>(row - parent.rows.begin()));
    }
  }
  return places;
}

int PlaceOf(int position, const Supernode& s) {
  if (position <= s.last()) return position - s.first;
  const auto row = std::lower_bound(s.rows.begin(), s.rows.end(), position);
  return s.count + static_cast<int>(row - s.rows.begin());
}

// Adds the lower triangle of what is left of a child to its parent's columns and what they leave.
void AddChild(const MatrixXd& child, const std::vector<int>& places, int block_size, int own_count,
              MatrixXd* panel, MatrixXd* rest) {
  const int k = block_size, count = static_cast<int>(places.size());
  for (int j = 0; j < count; ++j) {
    const bool own = places[j] < own_count;
    MatrixXd& target = own ? *panel : *rest;
    const int shift = own ? 0 : own_count;
    for (int begin = j, end; begin < count; begin = end) {  // runs of rows
      for (end = begin + 1; end < count && places[end] == places[end - 1] + 1;) ++end;
      target.block(k * (places[begin] - shift), k * (places[j] - shift), k * (end - begin), k) +=
          child.block(k * begin, k * j, k * (end - begin), k);
    }
  }
}

// The first columns of a symmetric matrix become those of its factor; the rest what they leave.
bool Eliminate(int columns, MatrixXd* panel, MatrixXd* rest) {
  Eigen::Ref<MatrixXd> own = panel->topRows(columns);
  const Eigen::LLT<Eigen::Ref<MatrixXd>> llt(own);  // in place
  if (llt.info() != Eigen::Success) return false;
  auto below = panel->bottomRows(panel->rows() - columns);
  if (below.rows() == 0) return true;
  own.transpose().triangularView<Eigen::Upper>().solveInPlace<Eigen::OnTheRight>(below);
  rest->selfadjointView<Eigen::Lower>().rankUpdate(below, -1);
  return true;
}

}  // namespace

BlockCholesky::BlockCholesky(int row_count, std::vector<std::pair<int, int>> pattern)
    : pattern_(std::move(pattern)),
      tree_(AnalyzeElimination(row_count, pattern_)),
      rows_at_(row_count),
      pairs_(tree_.supernodes.size()) {
  for (int i = 0; i < row_count; ++i) rows_at_[tree_.position[i]] = i;
  std::vector<int> supernode_of(row_count);
  for (std::size_t i = 0; i < tree_.supernodes.size(); ++i) {
    const Supernode& s = tree_.supernodes[i];
    std::fill_n(supernode_of.begin() + s.first, s.count, static_cast<int>(i));
  }
  for (std::size_t i = 0; i < pattern_.size(); ++i) {
    const auto& [a, b] = pattern_[i];
    pairs_[supernode_of[std::min(tree_.position[a], tree_.position[b])]].push_back(
        static_cast<int>(i));
  }
}

void BlockCholesky::AddOwnBlocks(const BlockMatrix& matrix, std::size_t supernode,
                                 MatrixXd* panel) const {
  const Supernode& s = tree_.supernodes[supernode];
  const int k = matrix.block_size();
  for (int i = 0; i < s.count; ++i) {
    panel->block(k * i, k * i, k, k) += matrix.Diagonal(rows_at_[s.first + i]);
  }
  for (const int pair : pairs_[supernode]) {
    const int a = PlaceOf(tree_.position[pattern_[pair].first], s);
    const int b = PlaceOf(tree_.position[pattern_[pair].second], s);
    const auto block = matrix.OffDiagonal(pair);
    if (a > b) {
      panel->block(k * a, k * b, k, k) += block;
    } else {
      panel->block(k * b, k * a, k, k) += block.transpose();
    }
  }
}

bool BlockCholesky::Factorize(const BlockMatrix& matrix) {
  const int k = block_size_ = matrix.block_size();
  panels_.resize(tree_.supernodes.size());
  std::vector<MatrixXd> rests(tree_.supernodes.size());  // until parents take them in
  for (std::size_t i = 0; i < tree_.supernodes.size(); ++i) {
    const Supernode& s = tree_.supernodes[i];
    const Eigen::Index below = k * static_cast<Eigen::Index>(s.rows.size());
    panels_[i].setZero(k * s.size(), k * s.count);
    rests[i].setZero(below, below);
    AddOwnBlocks(matrix, i, &panels_[i]);
    for (const int child : s.children) {
      AddChild(rests[child], PlacesInParent(tree_.supernodes[child], s), k, s.count, &panels_[i],
               &rests[i]);
      rests[child].resize(0, 0);
    }
    if (!Eliminate(k * s.count, &panels_[i], &rests[i])) return false;
  }
  return true;
}

MatrixXd BlockCholesky::Solve(const MatrixXd& right_side) const {
  const int k = block_size_;
  MatrixXd x(right_side.rows(), right_side.cols());
  for (std::size_t i = 0; i < rows_at_.size(); ++i) {
    x.middleRows(k * i, k) = right_side.middleRows(k * rows_at_[i], k);
  }
  for (std::size_t i = 0; i < panels_.size(); ++i) {
    const Supernode& s = tree_.supernodes[i];
    auto own = x.middleRows(k * s.first, k * s.count);
    panels_[i].topRows(own.rows()).triangularView<Eigen::Lower>().solveInPlace(own);
    const MatrixXd below = panels_[i].bottomRows(k * s.rows.size()) * own;
    for (std::size_t r = 0; r < s.rows.size(); ++r) {
      x.middleRows(k * s.rows[r], k) -= below.middleRows(k * r, k);
    }
  }
  for (std::size_t i = panels_.size(); i-- > 0;) {
    const Supernode& s = tree_.supernodes[i];
    MatrixXd below(k * s.rows.size(), x.cols());
    for (std::size_t r = 0; r < s.rows.size(); ++r) {
      below.middleRows(k * r, k) = x.middleRows(k * s.rows[r], k);
    }
    auto own = x.middleRows(k * s.first, k * s.count);
    own -= panels_[i].bottomRows(below.rows()).transpose() * below;
    panels_[i].topRows(own.rows()).triangularView<Eigen::Lower>().transpose().solveInPlace(own);
  }
  MatrixXd solution(right_side.rows(), right_side.cols());
  for (std::size_t i = 0; i < rows_at_.size(); ++i) {
    solution.middleRows(k * rows_at_[i], k) = x.middleRows(k * i, k);
  }
  return solution;
}

}  // namespace surfit
