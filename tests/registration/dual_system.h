#pragma once

#include <ceres/jet.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <vector>

#include "cost_functions/robust_kernel.h"
#include "surfit/registration/association.h"
#include "surfit/registration/error_model.h"
#include "surfit/registration/normal_system.h"

namespace surfit::testing {

using Jet = ceres::Jet<double, 6>;
using JetVector = Eigen::Matrix<Jet, 3, 1>;

// U with U^T U = C^-1, where C is the mean covariance of the planes: 1 along the normal, 1000 in
// the plane.
inline Eigen::Matrix3d WhiteningOf(const Eigen::Vector3d& n, const Eigen::Vector3d& m) {
  const auto covariance = [](const Eigen::Vector3d& normal) -> Eigen::Matrix3d {
    const Eigen::Matrix3d across = normal * normal.transpose();
    return across + 1000 * (Eigen::Matrix3d::Identity() - across);
  };
  const Eigen::Matrix3d inverse = (0.5 * (covariance(n) + covariance(m))).inverse();
  return inverse.llt().matrixU();
}

// Residuals of a correspondence by definition, at the left increment 0, with derivatives by
// autodiff.
inline std::vector<Jet> DualResiduals(const Correspondences& c, int i, ResidualType type) {
  JetVector w, v;
  for (int k = 0; k < 3; ++k) {
    w[k] = Jet(0, k);
    v[k] = Jet(0, k + 3);
  }
  const JetVector moved = QuaternionExp<Jet>(w) * JetVector(c.p(i).cast<Jet>()) + v;
  const JetVector turned = QuaternionExp<Jet>(w) * JetVector(c.m(i).cast<Jet>());
  const JetVector difference = moved - c.q(i).cast<Jet>();
  const JetVector n = c.n(i).cast<Jet>();
  switch (type) {
    case ResidualType::kPointToPlane:
      return {n.dot(difference)};
    case ResidualType::kSymmetricPointToPlane:
      return {Jet(0.5) * (n + turned).dot(difference)};
    case ResidualType::kPointToPoint:
      return {difference[0], difference[1], difference[2]};
    case ResidualType::kPlaneToPlane:
      break;
  }
  const JetVector white = WhiteningOf(c.n(i), c.m(i)).cast<Jet>() * difference;
  return {white[0], white[1], white[2]};
}

inline NormalSystem DualSystem(const Correspondences& c, ResidualType type,
                               const RobustKernel& kernel = {}) {
  NormalSystem system;
  for (int i = 0; i < c.size; ++i) {
    const std::vector<Jet> residuals = DualResiduals(c, i, type);
    double square = 0;
    for (const Jet& r : residuals) square += r.a * r.a;
    const double s = square * c.information[i];
    const KernelValue<double> value = EvaluateKernel(kernel, s);
    const double weight = c.information[i] * value.slope;
    for (const Jet& r : residuals) {
      system.hessian += weight * r.v * r.v.transpose();
      system.right_side -= weight * r.a * r.v;
      ++system.row_count;
    }
    system.cost += 0.5 * value.rho;
    system.weighted_square_sum += weight * square;
    system.weight_sum += weight;
    system.point_sum += weight * c.p(i);
    system.point_product_sum += weight * c.p(i) * c.p(i).transpose();
    system.normal_difference_sum += weight * (c.m(i) - c.n(i)).norm();
    system.inlier_count += s <= ErrorModel::kInlierSigmas * ErrorModel::kInlierSigmas;
    ++system.pair_count;
  }
  return system;
}

}  // namespace surfit::testing
