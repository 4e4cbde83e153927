#include <Eigen/SparseCholesky>

#include "optimization/pose_graph/optimize_pose_graph.h"
#include "registration/solvers/decompositions.h"

namespace surfit {
namespace {

using RowsOf3 = Eigen::Matrix<double, Eigen::Dynamic, 3>;
constexpr int kHeld = -1;

double Weight(const PoseGraph& graph, const PoseGraphEdge& edge, bool of_rotation) {
  const auto diagonal = edge.information.diagonal();
  if (of_rotation) return graph.planar ? diagonal[2] : diagonal.head<3>().mean();
  return diagonal.tail<3>().mean();
}

// Returns the fixed poses, and the first pose of each connected set without a fixed pose. Edges of
// positive weight connect poses. Appends the poses of sets without a fixed pose to `undetermined`.
std::vector<bool> Anchors(const PoseGraph& graph, const std::vector<bool>& fixed, bool of_rotation,
                          std::vector<std::size_t>* undetermined) {
  const std::size_t count = graph.poses.size();
  PoseSets sets(count);
  for (const PoseGraphEdge& edge : graph.edges) {
    if (Weight(graph, edge, of_rotation) > 0) sets.Join(edge.a, edge.b);
  }
  std::vector<bool> is_determined(count, false), anchors = fixed;
  for (std::size_t i = 0; i < count; ++i) {
    if (fixed[i]) is_determined[sets.Find(i)] = true;
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (is_determined[sets.Find(i)]) continue;
    if (sets.Find(i) == i) anchors[i] = true;
    undetermined->push_back(i);
  }
  return anchors;
}

// Index of each pose among the poses that are not held.
std::vector<int> NumberUnknowns(const std::vector<bool>& held, int* count) {
  std::vector<int> numbers(held.size(), kHeld);
  *count = 0;
  for (std::size_t i = 0; i < held.size(); ++i) {
    if (!held[i]) numbers[i] = (*count)++;
  }
  return numbers;
}

// Linear least squares over blocks X_i of kSize rows and 3 columns, with terms k |X_b - F X_a -
// c|^2 and orthogonal F.
template <int kSize>
class BlockSystem {
 public:
  using Factor = Eigen::Matrix<double, kSize, kSize>;
  using Block = Eigen::Matrix<double, kSize, 3>;

  explicit BlockSystem(int count) : right_side_(RowsOf3::Zero(kSize * count, 3)) {}

  // Held poses (number kHeld) have the constant blocks known_a, known_b.
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
  // The solver reads the lower triangle.
  void AddSymmetric(int row, int column, double value) {
    entries_.emplace_back(std::max(row, column), std::min(row, column), value);
  }

  std::vector<Eigen::Triplet<double>> entries_;
  RowsOf3 right_side_;
};

// With X_i = R_i^T the terms are k |X_b - R_ab^T X_a|^2.
bool SolveRotations(const PoseGraph& graph, const std::vector<bool>& held,
                    std::vector<Rigid3d>* poses) {
  int count = 0;
  const std::vector<int> numbers = NumberUnknowns(held, &count);
  if (count == 0) return true;
  BlockSystem<3> system(count);
  for (const PoseGraphEdge& edge : graph.edges) {
    if (!(Weight(graph, edge, true) > 0)) continue;
    const auto known = [&](std::size_t i) -> Eigen::Matrix3d {
      return (*poses)[i].rotation.toRotationMatrix().transpose();
    };
    system.Add(Weight(graph, edge, true), numbers[edge.a], numbers[edge.b],
               edge.a_from_b.rotation.toRotationMatrix().transpose(), Eigen::Matrix3d::Zero(),
               known(edge.a), known(edge.b));
  }
  const std::optional<RowsOf3> solution = system.Solve();
  if (!solution) return false;
  for (std::size_t i = 0; i < poses->size(); ++i) {
    if (numbers[i] == kHeld) continue;
    (*poses)[i].rotation =
        Eigen::Quaterniond(NearestRotation(solution->middleRows<3>(3 * numbers[i]).transpose()))
            .normalized();
  }
  return true;
}

bool SolveTranslations(const PoseGraph& graph, const std::vector<bool>& held,
                       std::vector<Rigid3d>* poses) {
  int count = 0;
  const std::vector<int> numbers = NumberUnknowns(held, &count);
  if (count == 0) return true;
  BlockSystem<1> system(count);
  for (const PoseGraphEdge& edge : graph.edges) {
    if (!(Weight(graph, edge, false) > 0)) continue;
    const Rigid3d &a = (*poses)[edge.a], &b = (*poses)[edge.b];
    system.Add(Weight(graph, edge, false), numbers[edge.a], numbers[edge.b],
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

std::optional<StartPoses> ChordalPoses(const PoseGraph& graph, const std::vector<bool>& fixed) {
  StartPoses start;
  for (const PoseGraphPose& pose : graph.poses)
    start.world_from_pose.push_back(pose.world_from_pose);
  const std::vector<bool> rotations = Anchors(graph, fixed, true, &start.undetermined_rotations);
  const std::vector<bool> positions = Anchors(graph, fixed, false, &start.undetermined_positions);
  if (!SolveRotations(graph, rotations, &start.world_from_pose)) return std::nullopt;
  if (!SolveTranslations(graph, positions, &start.world_from_pose)) return std::nullopt;
  return start;
}

}  // namespace surfit
