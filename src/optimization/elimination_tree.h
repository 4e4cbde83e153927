#pragma once

#include <utility>
#include <vector>

namespace surfit {

// Columns of a Cholesky factor that are next to each other and have (nearly) the same rows: they
// are eliminated together, as one dense matrix.
struct Supernode {
  int first = 0, count = 0;   // its columns
  std::vector<int> rows;      // below these, ascending
  std::vector<int> children;  // supernodes whose first row is one of its columns, ascending

  int last() const { return first + count - 1; }
  int size() const { return count + static_cast<int>(rows.size()); }
};

// In what order a sparse symmetric matrix is factorised, and where its factor is not zero. All in
// blocks: what they are made of does not matter.
struct EliminationTree {
  std::vector<int> position;          // of each row of the matrix, in the factor
  std::vector<Supernode> supernodes;  // children before parents
};

// For a matrix of `count` rows whose off-diagonal elements at these pairs (either way round, more
// than once if need be) are not zero. Ordered by approximate minimum degree (Amestoy, Davis, Duff
// 1996), supernodes merged while that adds few zeros (Ashcraft, Grimes 1989).
EliminationTree AnalyzeElimination(int count, const std::vector<std::pair<int, int>>& off_diagonal);

}  // namespace surfit
