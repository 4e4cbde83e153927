#include "registration/global/pose_certainty.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace surfit {
namespace {

// Direction of motion with the standard deviation of the source points. 0 if it is unknown.
struct UncertainDirection {
  Vector6d direction;
  double sigma_m = 0;
};

// Standard deviation of the source points along the least certain direction. Appends the
// directions with a standard deviation above the limit.
double LargestSigma(const CloudPair& pair, const IcpResult& icp,
                    std::vector<UncertainDirection>* uncertain) {
  // Motions about the centre of the source, scaled so that they move the points by about 1 m.
  const Eigen::Vector3d center = icp.target_from_source * MeanOf(pair.source().points.points);
  double radius2 = 0;
  for (const Eigen::Vector3f& point : pair.source().points.points) {
    radius2 += (icp.target_from_source * point.cast<double>() - center).squaredNorm();
  }
  radius2 /= static_cast<double>(std::max<std::size_t>(1, pair.source().points.size()));
  Matrix6d to_center = Matrix6d::Identity();  // (w, v) -> (|radius| w, motion of the centre)
  to_center.topLeftCorner<3, 3>() *= std::sqrt(radius2);
  to_center.bottomLeftCorner<3, 3>() = -CrossMatrix<double>(center);
  const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(to_center * *icp.covariance *
                                                      to_center.transpose());
  const double limit_m = pair.criteria().max_sigma_spacings * pair.spacing_m();
  const Matrix6d from_center = to_center.inverse();
  for (int i = 5; i >= 0 && eigen.eigenvalues()[i] > limit_m * limit_m; --i) {
    uncertain->push_back(
        {from_center * eigen.eigenvectors().col(i), std::sqrt(eigen.eigenvalues()[i])});
  }
  return std::sqrt(std::max(0., eigen.eigenvalues()[5]));
}

// Displacement of the points for ReturnDistance(). Correct correspondences remain within the gate.
double DisplacementOf(const CloudPair& pair) {
  constexpr double kGateRatio = 0.5;
  return kGateRatio * pair.options().icp.gates.max_distance_m;
}

// Moves the points by half the distance gate along both senses of a direction, and runs ICP.
// Returns the largest distance of the results from the pose. Surfaces that determine the
// direction pull the points back. Points that slide along surfaces stay away. A local slope of
// the cost does not show this: it depends on the sampling of the surfaces. Infinite if ICP fails.
double ReturnDistance(const CloudPair& pair, const Vector6d& direction, const Rigid3d& pose) {
  constexpr double kSmallMotion = 1e-3;  // of motions of the points by about 1 m
  const Vector6d unit = direction.normalized();
  const double change_m =
      pair.Distance(LeftIncrement<double>(kSmallMotion * unit, pose), pose) / kSmallMotion;
  if (!(change_m > 0)) return std::numeric_limits<double>::infinity();
  double largest_m = 0;
  for (const double sign : {-1., 1.}) {
    const Vector6d motion = sign * DisplacementOf(pair) / change_m * unit;
    const IcpResult moved = pair.RegisterAgain(LeftIncrement<double>(motion, pose));
    if (!moved.Succeeded()) return std::numeric_limits<double>::infinity();
    largest_m = std::max(largest_m, pair.Distance(moved.target_from_source, pose));
  }
  return largest_m;
}

// Limit of ReturnDistance(). The sampling of the surfaces gives local minima about one point
// spacing apart. Minima also spread by the standard deviation. Points that slide do not move back,
// so the limit is less than the displacement.
double MaxReturnDistance(const CloudPair& pair, double sigma_m) {
  constexpr double kDisplacementRatio = 0.75;
  return std::min(std::hypot(pair.criteria().max_disagreement_spacings * pair.spacing_m(), sigma_m),
                  kDisplacementRatio * DisplacementOf(pair));
}

}  // namespace

bool IsCertain(const CloudPair& pair, CloudRegistration* result) {
  IcpResult& icp = result->icp;
  std::vector<UncertainDirection> uncertain;
  for (const Vector6d& direction : icp.degenerate_directions) uncertain.push_back({direction, 0});
  icp.degenerate_directions.clear();
  const bool has_directions = icp.covariance || !uncertain.empty();
  if (icp.covariance) result->sigma_m = LargestSigma(pair, icp, &uncertain);
  for (const UncertainDirection& one : uncertain) {
    const double distance_m = ReturnDistance(pair, one.direction, icp.target_from_source);
    result->sigma_m = std::max(result->sigma_m, distance_m);
    if (distance_m > MaxReturnDistance(pair, one.sigma_m))
      icp.degenerate_directions.push_back(one.direction);
  }
  if (!has_directions) result->sigma_m = std::numeric_limits<double>::infinity();
  return has_directions && icp.degenerate_directions.empty();
}

}  // namespace surfit
