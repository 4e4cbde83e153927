#include "optimization/elimination_tree.h"

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <algorithm>
#include <utility>

namespace surfit {
namespace {

using Pairs = std::vector<std::pair<int, int>>;
constexpr int kNone = -1;

std::vector<int> MinimumDegreeOrder(int count, const Pairs& off_diagonal) {
  std::vector<Eigen::Triplet<int>> entries;
  for (const auto& [a, b] : off_diagonal) {
    entries.emplace_back(a, b, 1);
    entries.emplace_back(b, a, 1);
  }
  for (int i = 0; i < count; ++i) entries.emplace_back(i, i, 1);
  Eigen::SparseMatrix<int> pattern(count, count);
  pattern.setFromTriplets(entries.begin(), entries.end());
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> order;
  Eigen::AMDOrdering<int>()(pattern, order);
  return {order.indices().data(), order.indices().data() + count};
}

std::vector<int> Inverse(const std::vector<int>& order) {
  std::vector<int> inverse(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) inverse[order[i]] = static_cast<int>(i);
  return inverse;
}

// Of each column the rows below the diagonal, or of each row the columns left of it.
std::vector<std::vector<int>> Lower(int count, const Pairs& off_diagonal,
                                    const std::vector<int>& position, bool by_row) {
  std::vector<std::vector<int>> lower(count);
  for (const auto& [a, b] : off_diagonal) {
    const auto [column, row] = std::minmax(position[a], position[b]);
    by_row ? lower[row].push_back(column) : lower[column].push_back(row);
  }
  return lower;
}

// The parent of a column: the first row below the diagonal of the factor (Liu 1986, with paths
// compressed).
std::vector<int> Parents(const std::vector<std::vector<int>>& columns_of_row) {
  const int count = static_cast<int>(columns_of_row.size());
  std::vector<int> parents(count, kNone), ancestors(count, kNone);
  for (int row = 0; row < count; ++row) {
    for (int column : columns_of_row[row]) {
      while (column != kNone && column < row) {
        const int next = std::exchange(ancestors[column], row);
        if (next == kNone) parents[column] = row;
        column = next;
      }
    }
  }
  return parents;
}

// Columns so that each subtree is a range that ends with its root.
std::vector<int> PostOrder(const std::vector<int>& parents) {
  const int count = static_cast<int>(parents.size());
  std::vector<std::vector<int>> children(count + 1);
  for (int i = 0; i < count; ++i) children[parents[i] == kNone ? count : parents[i]].push_back(i);
  std::vector<int> order, open = {count};
  while (!open.empty()) {  // parents before children, which is turned round
    const int node = open.back();
    open.pop_back();
    if (node != count) order.push_back(node);
    open.insert(open.end(), children[node].begin(), children[node].end());
  }
  std::reverse(order.begin(), order.end());
  return order;
}

// The rows of each column of the factor: its own and those of its children.
std::vector<std::vector<int>> FactorRows(std::vector<std::vector<int>> rows) {
  const int count = static_cast<int>(rows.size());
  std::vector<std::vector<int>> children(count);
  for (int column = 0; column < count; ++column) {
    std::vector<int>& mine = rows[column];
    for (const int child : children[column]) {
      mine.insert(mine.end(), rows[child].begin() + 1, rows[child].end());
    }
    std::sort(mine.begin(), mine.end());
    mine.erase(std::unique(mine.begin(), mine.end()), mine.end());
    if (!mine.empty()) children[mine.front()].push_back(column);
  }
  return rows;
}

// Blocks that are zero but stored if a supernode is merged with its parent.
double ZerosOfMerging(const Supernode& child, const Supernode& parent) {
  return 1. * child.count * (parent.size() - static_cast<double>(child.rows.size()));
}

bool IsWorthMerging(const Supernode& child, const Supernode& parent) {
  if (child.rows.empty() || child.rows.front() > parent.last()) return false;
  const double count = child.count + parent.count, size = child.count + parent.size();
  const double stored = count * size - count * (count - 1) / 2;
  const double share = ZerosOfMerging(child, parent) / stored;
  return share <= (count <= 4 ? 0.4 : count <= 16 ? 0.15 : 0.04);
}

std::vector<Supernode> FindSupernodes(const std::vector<std::vector<int>>& rows) {
  std::vector<Supernode> supernodes;
  for (int column = 0; column < static_cast<int>(rows.size()); ++column) {
    supernodes.push_back({column, 1, rows[column], {}});
    while (supernodes.size() > 1 && IsWorthMerging(supernodes.end()[-2], supernodes.back())) {
      Supernode parent = std::move(supernodes.back());
      supernodes.pop_back();
      parent.first = supernodes.back().first;
      parent.count += supernodes.back().count;
      supernodes.back() = std::move(parent);
    }
  }
  return supernodes;
}

void FindChildren(int count, std::vector<Supernode>* supernodes) {
  std::vector<int> supernode_of(count);
  for (std::size_t i = 0; i < supernodes->size(); ++i) {
    const Supernode& s = (*supernodes)[i];
    std::fill_n(supernode_of.begin() + s.first, s.count, static_cast<int>(i));
  }
  for (std::size_t i = 0; i < supernodes->size(); ++i) {
    const std::vector<int>& rows = (*supernodes)[i].rows;
    if (!rows.empty()) {
      (*supernodes)[supernode_of[rows.front()]].children.push_back(static_cast<int>(i));
    }
  }
}

}  // namespace

EliminationTree AnalyzeElimination(int count, const Pairs& off_diagonal) {
  EliminationTree tree;
  const std::vector<int> order = MinimumDegreeOrder(count, off_diagonal);
  const std::vector<int> first_position = Inverse(order);
  const std::vector<int> post_position =
      Inverse(PostOrder(Parents(Lower(count, off_diagonal, first_position, true))));
  for (const int position : first_position) tree.position.push_back(post_position[position]);
  tree.supernodes = FindSupernodes(FactorRows(Lower(count, off_diagonal, tree.position, false)));
  FindChildren(count, &tree.supernodes);
  return tree;
}

}  // namespace surfit
