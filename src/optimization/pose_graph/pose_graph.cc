#include "surfit/optimization/pose_graph.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <numeric>
#include <unordered_set>

#include "core/named_values.h"
#include "optimization/pose_graph/optimize_pose_graph.h"
#include "optimization/pose_graph/pose_graph_names.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

constexpr double kNormTolerance = 1e-6;
constexpr double kSymmetryTolerance = 1e-9;  // of the largest element
// Tolerance of negative eigenvalues, relative to the largest. Rounding to 6 digits changes
// eigenvalues by at most 6 * 5e-6 of the largest element.
constexpr double kRounding = 3e-5;
constexpr double kPlanarTolerance = 1e-9;  // rad and m

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

bool IsPlanar(const Rigid3d& pose) {
  return std::abs(pose.translation.z()) < kPlanarTolerance &&
         pose.rotation.vec().head<2>().norm() < kPlanarTolerance;
}

bool IsPlanar(const Eigen::Matrix<double, 6, 6>& information) {
  Eigen::Matrix<double, 6, 6> rest = information;
  rest.block<3, 3>(2, 2).setZero();
  return rest.isZero(0);
}

template <typename Matrix>
void RequireInformation(const Matrix& information, const std::string& name) {
  if (!IsInformation(information)) {
    throw InputError("the information of ", name,
                     " must be finite, symmetric and positive semidefinite");
  }
}

void ValidateEdge(const PoseGraph& graph, std::size_t index) {
  const PoseGraphEdge& edge = graph.edges[index];
  ThrowIf(edge.a >= graph.poses.size() || edge.b >= graph.poses.size() || edge.a == edge.b, "edge ",
          index, " joins poses ", edge.a, " and ", edge.b, ", must be two of ", graph.poses.size());
  if (!IsRigid(edge.a_from_b)) {
    throw InputError(Name(graph, edge), " must have a finite pose with a unit quaternion");
  }
  if (!IsInformation(edge.information)) RequireInformation(edge.information, Name(graph, edge));
  if (graph.planar && !(IsPlanar(edge.a_from_b) && IsPlanar(edge.information))) {
    throw InputError(Name(graph, edge), " must be in SE(2)");
  }
}

void RequirePose(const PoseGraph& graph, std::size_t pose) {
  ThrowIf(pose >= graph.poses.size(), "a prior refers to pose ", pose, ", must be one of ",
          graph.poses.size());
}

void ValidatePrior(const PoseGraph& graph, const PoseGraphPrior& prior) {
  RequirePose(graph, prior.pose);
  const std::string name = Concat("the prior of pose ", graph.poses[prior.pose].id);
  Require(IsRigid(prior.pose_from_sensor) && IsRigid(prior.world_from_sensor), name,
          "finite with a unit quaternion");
  RequireInformation(prior.information, name);
  Require(!graph.planar || (IsPlanar(prior.pose_from_sensor) && IsPlanar(prior.world_from_sensor) &&
                            IsPlanar(prior.information)),
          name, "in SE(2)");
}

void ValidatePosition(const PoseGraph& graph, const PoseGraphPosition& position) {
  RequirePose(graph, position.pose);
  const std::string name = Concat("the position prior of pose ", graph.poses[position.pose].id);
  Require(position.sensor_in_pose.allFinite() && position.sensor_in_world.allFinite(), name,
          "finite");
  RequireInformation(position.information, name);
  Require(!graph.planar || (position.sensor_in_pose.z() == 0 && position.sensor_in_world.z() == 0 &&
                            position.information.row(2).isZero(0)),
          name, "in SE(2)");
}

// Marks edges between neighbours in the order of ids.
void SelectConsecutive(PoseGraph* graph) {
  std::vector<std::size_t> order(graph->poses.size()), rank(graph->poses.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(),
            [&](std::size_t x, std::size_t y) { return graph->poses[x].id < graph->poses[y].id; });
  for (std::size_t i = 0; i < order.size(); ++i) rank[order[i]] = i;
  for (PoseGraphEdge& edge : graph->edges) {
    edge.loop = std::max(rank[edge.a], rank[edge.b]) - std::min(rank[edge.a], rank[edge.b]) != 1;
  }
}

void SelectSpanningTree(PoseGraph* graph) {
  PoseSets sets(graph->poses.size());
  for (PoseGraphEdge& edge : graph->edges) edge.loop = !sets.Join(edge.a, edge.b);
}

template <typename Matrix>
bool IsInformationMatrix(const Matrix& matrix) {
  if (!matrix.allFinite()) return false;
  const double asymmetry = (matrix - matrix.transpose()).cwiseAbs().maxCoeff();
  if (asymmetry > kSymmetryTolerance * matrix.cwiseAbs().maxCoeff()) return false;
  if (matrix.llt().info() == Eigen::Success) return true;  // the common case, fast to test
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(matrix, Eigen::EigenvaluesOnly);
  return eigen.eigenvalues()(0) >= -kRounding * eigen.eigenvalues()(matrix.rows() - 1);
}

}  // namespace

bool IsInformation(const Eigen::Matrix<double, 6, 6>& matrix) {
  return IsInformationMatrix(matrix);
}

bool IsInformation(const Eigen::Matrix3d& matrix) { return IsInformationMatrix(matrix); }

void SelectOdometry(const std::string& odometry, PoseGraph* graph) {
  switch (ValueOf("odometry", odometry, kOdometryRules)) {
    case OdometryRule::kConsecutive:
      return SelectConsecutive(graph);
    case OdometryRule::kSpanningTree:
      return SelectSpanningTree(graph);
    case OdometryRule::kNone:
      for (PoseGraphEdge& edge : graph->edges) edge.loop = true;
  }
}

void ChainPosesOf(PoseGraph* graph) {
  const ChainedPoses chained = ChainPoses(*graph);
  for (std::size_t i = 0; i < graph->poses.size(); ++i) {
    graph->poses[i].world_from_pose = chained.world_from_pose[i];
  }
}

void PoseGraph::Validate() const {
  std::unordered_set<std::int64_t> ids;
  for (const PoseGraphPose& pose : poses) {
    Require(ids.insert(pose.id).second, Concat("the id ", pose.id, " of a pose"), "unique");
    Require(IsRigid(pose.world_from_pose), Concat("pose ", pose.id),
            "finite with a unit quaternion");
  }
  for (const PoseGraphPose& pose : poses) {
    Require(!planar || IsPlanar(pose.world_from_pose), Concat("pose ", pose.id), "in SE(2)");
  }
  for (std::size_t i = 0; i < edges.size(); ++i) ValidateEdge(*this, i);
  for (const PoseGraphPrior& prior : priors) ValidatePrior(*this, prior);
  for (const PoseGraphPosition& position : positions) ValidatePosition(*this, position);
}

double SquaredError(const PoseGraph& graph, const PoseGraphEdge& edge) {
  const Rigid3d& world_from_a = graph.poses[edge.a].world_from_pose;
  const Rigid3d& world_from_b = graph.poses[edge.b].world_from_pose;
  const Rigid3d error = world_from_a.Inverse() * world_from_b * edge.a_from_b.Inverse();
  Eigen::Matrix<double, 6, 1> e;
  e << QuaternionLog<double>(error.rotation), error.translation;
  return e.dot(edge.information * e);
}

double SquaredError(const PoseGraph& graph, const PoseGraphPrior& prior) {
  const Rigid3d error = prior.world_from_sensor.Inverse() *
                        graph.poses[prior.pose].world_from_pose * prior.pose_from_sensor;
  Eigen::Matrix<double, 6, 1> e;
  e << QuaternionLog<double>(error.rotation), error.translation;
  return e.dot(prior.information * e);
}

double SquaredError(const PoseGraph& graph, const PoseGraphPosition& position) {
  const Eigen::Vector3d e = graph.poses[position.pose].world_from_pose * position.sensor_in_pose -
                            position.sensor_in_world;
  return e.dot(position.information * e);
}

double Cost(const PoseGraph& graph) {
  double sum = 0;
  for (const PoseGraphEdge& edge : graph.edges) sum += SquaredError(graph, edge);
  for (const PoseGraphPrior& prior : graph.priors) sum += SquaredError(graph, prior);
  for (const PoseGraphPosition& position : graph.positions) sum += SquaredError(graph, position);
  return sum / 2;
}

}  // namespace surfit
