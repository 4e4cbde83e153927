#include <Eigen/SVD>
#include <Eigen/SparseCholesky>
#include <deque>

#include "optimization/pose_graph/optimize_pose_graph.h"

namespace surfit {
namespace {

struct LinkedPose {
  std::size_t pose;
  Rigid3d pose_from_neighbour;
  bool loop;
};

std::vector<std::vector<LinkedPose>> NeighboursOf(const PoseGraph& graph) {
  std::vector<std::vector<LinkedPose>> neighbours(graph.poses.size());
  for (const PoseGraphEdge& edge : graph.edges) {
    neighbours[edge.a].push_back({edge.b, edge.a_from_b, edge.loop});
    neighbours[edge.b].push_back({edge.a, edge.a_from_b.Inverse(), edge.loop});
  }
  return neighbours;
}

class Chain {
 public:
  explicit Chain(const PoseGraph& graph)
      : graph_(graph), neighbours_(NeighboursOf(graph)), reached_(graph.poses.size(), false) {
    result_.world_from_pose.resize(graph.poses.size());
    result_.held.assign(graph.poses.size(), false);
  }

  void Hold(std::size_t pose) {
    if (reached_[pose]) return;
    result_.held[pose] = true;
    Place(pose, graph_.poses[pose].world_from_pose);
  }

  // Chains all reachable poses, along odometry edges first.
  void Spread() {
    while (!open_.empty()) {
      const auto [pose, world_from_pose] = open_.front();
      open_.pop_front();
      if (!reached_[pose]) Place(pose, world_from_pose);
    }
  }

  ChainedPoses Take() { return std::move(result_); }

 private:
  void Place(std::size_t pose, const Rigid3d& world_from_pose) {
    reached_[pose] = true;
    result_.world_from_pose[pose] = world_from_pose;
    for (const LinkedPose& n : neighbours_[pose]) {
      if (reached_[n.pose]) continue;
      const Step step{n.pose, world_from_pose * n.pose_from_neighbour};
      n.loop ? open_.push_back(step) : open_.push_front(step);
    }
  }

  struct Step {
    std::size_t pose;
    Rigid3d world_from_pose;
  };
  const PoseGraph& graph_;
  std::vector<std::vector<LinkedPose>> neighbours_;
  std::vector<bool> reached_;
  std::deque<Step> open_;
  ChainedPoses result_;
};

using RowsOf3 = Eigen::Matrix<double, Eigen::Dynamic, 3>;
constexpr int kHeld = -1;

// Indices of the poses that are not held; kHeld for held poses.
std::vector<int> NumberUnknowns(const std::vector<bool>& held, int* count) {
  std::vector<int> numbers(held.size(), kHeld);
  *count = 0;
  for (std::size_t i = 0; i < held.size(); ++i) {
    if (!held[i]) numbers[i] = (*count)++;
  }
  return numbers;
}

// Linear least squares over kSize x 3 blocks X_i. Terms: k |X_b - F X_a - c|^2 with orthogonal
// F.
template <int kSize>
class BlockSystem {
 public:
  using Factor = Eigen::Matrix<double, kSize, kSize>;
  using Block = Eigen::Matrix<double, kSize, 3>;

  explicit BlockSystem(int count) : right_side_(RowsOf3::Zero(kSize * count, 3)) {}

  // `a`, `b`: block indices. If one is kHeld, its block is the constant known_a or known_b.
  void Add(double k, int a, int b, const Factor& factor, const Block& constant,
           const Block& known_a, const Block& known_b) {
    if (a != kHeld) AddDiagonal(k, a);
    if (b != kHeld) AddDiagonal(k, b);
    if (a != kHeld && b != kHeld) {
      for (int i = 0; i < kSize; ++i) {
        for (int j = 0; j < kSize; ++j)
          AddSymmetric(kSize * b + i, kSize * a + j, -k * factor(i, j));
      }
    }
    const Block b_part = b == kHeld ? known_b : Block::Zero();
    const Block a_part = a == kHeld ? known_a : Block::Zero();
    if (b != kHeld) right_side_.middleRows(kSize * b, kSize) += k * (factor * a_part + constant);
    if (a != kHeld) {
      right_side_.middleRows(kSize * a, kSize) += k * factor.transpose() * (b_part - constant);
    }
  }

  std::optional<RowsOf3> Solve() const {
    const Eigen::Index size = right_side_.rows();
    Eigen::SparseMatrix<double> matrix(size, size);
    matrix.setFromTriplets(entries_.begin(), entries_.end());
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> ldlt(matrix);
    if (ldlt.info() != Eigen::Success) return std::nullopt;
    const RowsOf3 solution = ldlt.solve(right_side_);
    if (!solution.allFinite()) return std::nullopt;
    return solution;
  }

 private:
  void AddDiagonal(double k, int block) {
    for (int i = 0; i < kSize; ++i) {
      entries_.emplace_back(kSize * block + i, kSize * block + i, k);
    }
  }
  void AddSymmetric(int row, int column, double value) {
    entries_.emplace_back(std::max(row, column), std::min(row, column), value);
  }

  std::vector<Eigen::Triplet<double>> entries_;
  RowsOf3 right_side_;
};

// Rotation with the smallest Frobenius distance to a matrix.
Eigen::Quaterniond NearestRotation(const Eigen::Matrix3d& matrix) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d u = svd.matrixU();
  if ((u * svd.matrixV().transpose()).determinant() < 0) u.col(2) = -u.col(2);
  return Eigen::Quaterniond(u * svd.matrixV().transpose()).normalized();
}

// With X_i = R_i^T the terms are k |X_b - R_ab^T X_a|^2.
bool SolveRotations(const PoseGraph& graph, const std::vector<int>& numbers, int count,
                    std::vector<Rigid3d>* poses) {
  BlockSystem<3> system(count);
  for (const PoseGraphEdge& edge : graph.edges) {
    const auto known = [&](std::size_t i) -> Eigen::Matrix3d {
      return (*poses)[i].rotation.toRotationMatrix().transpose();
    };
    system.Add(edge.information.diagonal().head<3>().mean(), numbers[edge.a], numbers[edge.b],
               edge.a_from_b.rotation.toRotationMatrix().transpose(), Eigen::Matrix3d::Zero(),
               known(edge.a), known(edge.b));
  }
  const std::optional<RowsOf3> solution = system.Solve();
  if (!solution) return false;
  for (std::size_t i = 0; i < poses->size(); ++i) {
    if (numbers[i] == kHeld) continue;
    (*poses)[i].rotation = NearestRotation(solution->middleRows<3>(3 * numbers[i]).transpose());
  }
  return true;
}

bool SolveTranslations(const PoseGraph& graph, const std::vector<int>& numbers, int count,
                       std::vector<Rigid3d>* poses) {
  BlockSystem<1> system(count);
  for (const PoseGraphEdge& edge : graph.edges) {
    const Rigid3d &a = (*poses)[edge.a], &b = (*poses)[edge.b];
    system.Add(edge.information.diagonal().tail<3>().mean(), numbers[edge.a], numbers[edge.b],
               BlockSystem<1>::Factor::Identity(),
               (a.rotation * edge.a_from_b.translation).transpose(), a.translation.transpose(),
               b.translation.transpose());
  }
  const std::optional<RowsOf3> solution = system.Solve();
  if (!solution) return false;
  for (std::size_t i = 0; i < poses->size(); ++i) {
    if (numbers[i] != kHeld) (*poses)[i].translation = solution->row(numbers[i]).transpose();
  }
  return true;
}

}  // namespace

ChainedPoses ChainPoses(const PoseGraph& graph) {
  Chain chain(graph);
  for (std::size_t i = 0; i < graph.poses.size(); ++i) {
    if (graph.poses[i].fixed) chain.Hold(i);
  }
  for (std::size_t i = 0; i < graph.poses.size(); ++i) {
    chain.Spread();
    chain.Hold(i);
  }
  chain.Spread();
  return chain.Take();
}

std::optional<std::vector<Rigid3d>> ChordalPoses(const PoseGraph& graph,
                                                 const std::vector<bool>& held) {
  int count = 0;
  const std::vector<int> numbers = NumberUnknowns(held, &count);
  std::vector<Rigid3d> poses;
  for (const PoseGraphPose& pose : graph.poses) poses.push_back(pose.world_from_pose);
  if (count == 0) return poses;
  if (!SolveRotations(graph, numbers, count, &poses)) return std::nullopt;
  if (!SolveTranslations(graph, numbers, count, &poses)) return std::nullopt;
  return poses;
}

}  // namespace surfit
