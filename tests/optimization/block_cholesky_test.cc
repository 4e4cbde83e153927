#include "optimization/block_cholesky.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <random>

namespace surfit {
namespace {

using Eigen::MatrixXd;
using Pairs = std::vector<std::pair<int, int>>;

MatrixXd RandomMatrix(int rows, int columns, std::mt19937_64* rng) {
  std::normal_distribution<double> normal;
  return MatrixXd::NullaryExpr(rows, columns, [&] { return normal(*rng); });
}

// A chain and as many other pairs, some of them more than once and either way round.
Pairs RandomPairs(int count, std::mt19937_64* rng) {
  Pairs pairs;
  std::uniform_int_distribution<int> any(0, count - 1);
  for (int i = 1; i < count; ++i) {
    pairs.emplace_back(i, i - 1);
    const int a = any(*rng), b = any(*rng);
    if (a != b) pairs.emplace_back(a, b);
  }
  return pairs;
}

// Sums of J^T J, J = [A B] at each pair, and a little of the identity.
BlockMatrix PositiveDefinite(int block_size, int count, const Pairs& pairs, std::mt19937_64* rng) {
  BlockMatrix matrix(block_size, count, pairs.size());
  for (int i = 0; i < count; ++i) matrix.Diagonal(i).diagonal().setConstant(0.1);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const MatrixXd a = RandomMatrix(block_size, block_size, rng);
    const MatrixXd b = RandomMatrix(block_size, block_size, rng);
    matrix.Diagonal(pairs[i].first) += a.transpose() * a;
    matrix.Diagonal(pairs[i].second) += b.transpose() * b;
    matrix.OffDiagonal(i) = a.transpose() * b;
  }
  return matrix;
}

MatrixXd Dense(int count, const Pairs& pairs, const BlockMatrix& matrix) {
  const int k = matrix.block_size();
  MatrixXd dense = MatrixXd::Zero(k * count, k * count);
  for (int i = 0; i < count; ++i) dense.block(k * i, k * i, k, k) = matrix.Diagonal(i);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const auto [a, b] = pairs[i];
    dense.block(k * a, k * b, k, k) += matrix.OffDiagonal(i);
    dense.block(k * b, k * a, k, k) += matrix.OffDiagonal(i).transpose();
  }
  return dense;
}

void ExpectSolves(int block_size, int count, const Pairs& pairs, std::mt19937_64* rng) {
  const BlockMatrix matrix = PositiveDefinite(block_size, count, pairs, rng);
  const MatrixXd dense = Dense(count, pairs, matrix);
  const MatrixXd right_side = RandomMatrix(block_size * count, 2, rng);
  BlockCholesky cholesky(count, pairs);
  ASSERT_TRUE(cholesky.Factorize(matrix));
  const MatrixXd solution = cholesky.Solve(right_side);
  EXPECT_LT((dense * solution - right_side).norm(), 1e-12 * dense.norm() * solution.norm());
}

TEST(BlockCholesky, SolvesAsTheMatrixSays) {
  std::mt19937_64 rng(1);
  for (const int block_size : {1, 3, 6}) {
    for (const int count : {1, 2, 10, 60}) {
      SCOPED_TRACE(testing::Message() << block_size << " " << count);
      ExpectSolves(block_size, count, RandomPairs(count, &rng), &rng);
    }
  }
}

TEST(BlockCholesky, TakesRowsThatNothingJoinsAndThoseThatAllDo) {
  std::mt19937_64 rng(2);
  ExpectSolves(2, 5, {}, &rng);
  ExpectSolves(2, 6, {{1, 3}, {3, 1}}, &rng);
  Pairs all;
  for (int a = 0; a < 20; ++a) {
    for (int b = 0; b < a; ++b) all.emplace_back(a, b);
  }
  ExpectSolves(3, 20, all, &rng);
  BlockCholesky none(0, {});
  EXPECT_TRUE(none.Factorize(BlockMatrix(6, 0, 0)));
  EXPECT_EQ(none.Solve(MatrixXd(0, 1)).rows(), 0);
}

TEST(BlockCholesky, RefusesWhatIsNotPositiveDefinite) {
  std::mt19937_64 rng(3);
  const Pairs pairs = RandomPairs(30, &rng);
  BlockMatrix matrix = PositiveDefinite(3, 30, pairs, &rng);
  BlockCholesky cholesky(30, pairs);
  ASSERT_TRUE(cholesky.Factorize(matrix));
  const double least = Dense(30, pairs, matrix).selfadjointView<Eigen::Lower>().eigenvalues()[0];
  for (int i = 0; i < 30; ++i) matrix.Diagonal(i).diagonal().array() -= 1.001 * least;
  EXPECT_FALSE(cholesky.Factorize(matrix));
}

// Every element of the factor that is not zero is in the tree: the rows of a supernode below its
// parent's columns are rows of the parent.
TEST(EliminationTree, HoldsTheRowsThatAnEliminationLeaves) {
  std::mt19937_64 rng(4);
  const EliminationTree tree = AnalyzeElimination(200, RandomPairs(200, &rng));
  int columns = 0;
  for (const Supernode& parent : tree.supernodes) {
    EXPECT_EQ(parent.first, columns);
    columns += parent.count;
    for (const int i : parent.children) {
      const Supernode& child = tree.supernodes[i];
      EXPECT_LT(child.first, parent.first);
      for (const int row : child.rows) {
        const bool own = row >= parent.first && row <= parent.last();
        EXPECT_TRUE(own || std::binary_search(parent.rows.begin(), parent.rows.end(), row));
      }
    }
  }
  EXPECT_EQ(columns, 200);
}

}  // namespace
}  // namespace surfit
