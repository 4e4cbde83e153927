#include "surfit/optimization/pose_graph.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <unordered_set>

#include "surfit/core/error.h"

namespace surfit {
namespace {

constexpr double kNormTolerance = 1e-6;
constexpr double kSymmetryTolerance = 1e-9;  // of the largest element
// Tolerance of negative eigenvalues, relative to the largest. Rounding to 6 digits changes
// eigenvalues by at most 6 * 5e-6 of the largest element.
constexpr double kRounding = 3e-5;

bool IsRigid(const Rigid3d& pose) {
  return pose.translation.allFinite() && pose.rotation.coeffs().allFinite() &&
         std::abs(pose.rotation.norm() - 1) < kNormTolerance;
}

void Require(bool holds, const std::string& what, const char* constraint) {
  ThrowIf(!holds, what, " must be ", constraint);
}

std::string Name(const PoseGraph& graph, const PoseGraphEdge& edge) {
  return Concat("the edge between poses ", graph.poses[edge.a].id, " and ", graph.poses[edge.b].id);
}

void ValidateEdge(const PoseGraph& graph, std::size_t index) {
  const PoseGraphEdge& edge = graph.edges[index];
  ThrowIf(edge.a >= graph.poses.size() || edge.b >= graph.poses.size() || edge.a == edge.b, "edge ",
          index, " joins poses ", edge.a, " and ", edge.b, ", must be two of ", graph.poses.size());
  if (!IsRigid(edge.a_from_b)) {
    throw InputError(Name(graph, edge), " must have a finite pose with a unit quaternion");
  }
  if (!IsInformation(edge.information)) {
    throw InputError("the information of ", Name(graph, edge),
                     " must be finite, symmetric and positive semidefinite");
  }
}

}  // namespace

bool IsInformation(const Eigen::Matrix<double, 6, 6>& matrix) {
  if (!matrix.allFinite()) return false;
  const double asymmetry = (matrix - matrix.transpose()).cwiseAbs().maxCoeff();
  if (asymmetry > kSymmetryTolerance * matrix.cwiseAbs().maxCoeff()) return false;
  if (matrix.llt().info() == Eigen::Success) return true;  // the common case, fast to test
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 6, 6>> eigen(matrix,
                                                                         Eigen::EigenvaluesOnly);
  return eigen.eigenvalues()(0) >= -kRounding * eigen.eigenvalues()(5);
}

void PoseGraph::Validate() const {
  std::unordered_set<std::int64_t> ids;
  for (const PoseGraphPose& pose : poses) {
    Require(ids.insert(pose.id).second, Concat("the id ", pose.id, " of a pose"), "unique");
    Require(IsRigid(pose.world_from_pose), Concat("pose ", pose.id),
            "finite with a unit quaternion");
  }
  for (std::size_t i = 0; i < edges.size(); ++i) ValidateEdge(*this, i);
}

double SquaredError(const PoseGraph& graph, const PoseGraphEdge& edge) {
  const Rigid3d& world_from_a = graph.poses[edge.a].world_from_pose;
  const Rigid3d& world_from_b = graph.poses[edge.b].world_from_pose;
  const Rigid3d error = world_from_a.Inverse() * world_from_b * edge.a_from_b.Inverse();
  Eigen::Matrix<double, 6, 1> e;
  e << QuaternionLog<double>(error.rotation), error.translation;
  return e.dot(edge.information * e);
}

double Cost(const PoseGraph& graph) {
  double sum = 0;
  for (const PoseGraphEdge& edge : graph.edges) sum += SquaredError(graph, edge);
  return sum / 2;
}

}  // namespace surfit
