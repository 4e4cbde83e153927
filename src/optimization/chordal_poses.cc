#include "optimization/chordal_poses.h"

#include <Eigen/SVD>

#include "optimization/block_cholesky.h"
#include "optimization/unknown_poses.h"

namespace surfit {
namespace {

using Rows = Eigen::Matrix<double, Eigen::Dynamic, 3>;

// Least squares over blocks X_i of kSize rows and 3 columns: terms k |X_b - F X_a - c|^2, F
// orthogonal, one for each edge, in their order.
template <int kSize>
class BlockSystem {
 public:
  using Factor = Eigen::Matrix<double, kSize, kSize>;
  using Block = Eigen::Matrix<double, kSize, 3>;

  explicit BlockSystem(const UnknownPoses& unknowns)
      : matrix_(kSize, unknowns.count, unknowns.pairs.size()),
        right_side_(Rows::Zero(kSize * unknowns.count, 3)) {}

  // Blocks of held poses (number kHeld) have the values known_a, known_b.
  void Add(double k, int a, int b, const Factor& factor, const Block& constant,
           const Block& known_a, const Block& known_b) {
    if (a != kHeld) Fixed(matrix_.Diagonal(a)) += k * Factor::Identity();
    if (b != kHeld) Fixed(matrix_.Diagonal(b)) += k * Factor::Identity();
    if (a != kHeld && b != kHeld) Fixed(matrix_.OffDiagonal(pair_count_++)) = -k * factor;
    const Block b_part = b == kHeld ? known_b : Block::Zero();
    const Block a_part = a == kHeld ? known_a : Block::Zero();
    if (b != kHeld) right_side_.middleRows(kSize * b, kSize) += k * (factor * a_part + constant);
    if (a != kHeld) {
      right_side_.middleRows(kSize * a, kSize) += k * factor.transpose() * (b_part - constant);
    }
  }

  std::optional<Rows> Solve(BlockCholesky* cholesky) const {
    if (!cholesky->Factorize(matrix_)) return std::nullopt;
    const Rows solution = cholesky->Solve(right_side_);
    if (!solution.allFinite()) return std::nullopt;
    return solution;
  }

 private:
  template <typename Dynamic>
  static auto Fixed(Dynamic block) {
    return block.template topLeftCorner<kSize, kSize>();
  }

  BlockMatrix matrix_;
  Rows right_side_;
  std::size_t pair_count_ = 0;
};

// The rotation nearest to a matrix in the least squares of its elements.
Eigen::Quaterniond NearestRotation(const Eigen::Matrix3d& matrix) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d u = svd.matrixU();
  if ((u * svd.matrixV().transpose()).determinant() < 0) u.col(2) = -u.col(2);
  return Eigen::Quaterniond(u * svd.matrixV().transpose()).normalized();
}

// With X_i = R_i^T the terms are k |X_b - R_ab^T X_a|^2.
bool SolveRotations(const PoseGraph& graph, const UnknownPoses& unknowns, BlockCholesky* cholesky,
                    std::vector<Rigid3d>* poses) {
  const std::vector<int>& numbers = unknowns.numbers;
  BlockSystem<3> system(unknowns);
  for (const PoseGraphEdge& edge : graph.edges) {
    const auto known = [&](std::size_t i) -> Eigen::Matrix3d {
      return (*poses)[i].rotation.toRotationMatrix().transpose();
    };
    system.Add(edge.information.diagonal().head<3>().mean(), numbers[edge.a], numbers[edge.b],
               edge.a_from_b.rotation.toRotationMatrix().transpose(), Eigen::Matrix3d::Zero(),
               known(edge.a), known(edge.b));
  }
  const std::optional<Rows> solution = system.Solve(cholesky);
  if (!solution) return false;
  for (std::size_t i = 0; i < poses->size(); ++i) {
    if (numbers[i] == kHeld) continue;
    (*poses)[i].rotation = NearestRotation(solution->middleRows<3>(3 * numbers[i]).transpose());
  }
  return true;
}

bool SolveTranslations(const PoseGraph& graph, const UnknownPoses& unknowns,
                       BlockCholesky* cholesky, std::vector<Rigid3d>* poses) {
  const std::vector<int>& numbers = unknowns.numbers;
  BlockSystem<1> system(unknowns);
  for (const PoseGraphEdge& edge : graph.edges) {
    const Rigid3d &a = (*poses)[edge.a], &b = (*poses)[edge.b];
    system.Add(edge.information.diagonal().tail<3>().mean(), numbers[edge.a], numbers[edge.b],
               BlockSystem<1>::Factor::Identity(),
               (a.rotation * edge.a_from_b.translation).transpose(), a.translation.transpose(),
               b.translation.transpose());
  }
  const std::optional<Rows> solution = system.Solve(cholesky);
  if (!solution) return false;
  for (std::size_t i = 0; i < poses->size(); ++i) {
    if (numbers[i] != kHeld) (*poses)[i].translation = solution->row(numbers[i]).transpose();
  }
  return true;
}

}  // namespace

std::optional<std::vector<Rigid3d>> ChordalPoses(const PoseGraph& graph,
                                                 const std::vector<bool>& held) {
  const UnknownPoses unknowns = NumberUnknowns(graph, held);
  std::vector<Rigid3d> poses;
  for (const PoseGraphPose& pose : graph.poses) poses.push_back(pose.world_from_pose);
  if (unknowns.count == 0) return poses;
  BlockCholesky cholesky(unknowns.count, unknowns.pairs);
  if (!SolveRotations(graph, unknowns, &cholesky, &poses)) return std::nullopt;
  if (!SolveTranslations(graph, unknowns, &cholesky, &poses)) return std::nullopt;
  return poses;
}

}  // namespace surfit
