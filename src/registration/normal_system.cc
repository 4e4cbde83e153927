#include "surfit/registration/normal_system.h"

#include <Eigen/Eigenvalues>
#include <cmath>

namespace surfit {

NormalSystem& NormalSystem::operator+=(const NormalSystem& other) {
  hessian += other.hessian;
  right_side += other.right_side;
  weighted_square_sum += other.weighted_square_sum;
  weight_sum += other.weight_sum;
  weighted_point_square_sum += other.weighted_point_square_sum;
  pair_count += other.pair_count;
  inlier_count += other.inlier_count;
  return *this;
}

double NormalSystem::RmsDistance() const {
  return weight_sum > 0 ? std::sqrt(weighted_point_square_sum / weight_sum) : 0;
}

Vector6d NormalSystem::ScaledEigenvalues() const {
  if (!(RmsDistance() > 0)) return Vector6d::Zero();
  Vector6d scale = Vector6d::Ones();
  scale.head<3>().setConstant(1 / RmsDistance());
  const Matrix6d scaled = scale.asDiagonal() * hessian * scale.asDiagonal() / weight_sum;
  return Eigen::SelfAdjointEigenSolver<Matrix6d>(scaled, Eigen::EigenvaluesOnly).eigenvalues();
}

NormalSystem BuildNormalSystem(const Correspondences& c) {
  NormalSystem system;
  for (std::size_t i = 0; i < c.size(); ++i) {
    const Eigen::Vector3d p(c.px[i], c.py[i], c.pz[i]);
    const Eigen::Vector3d q(c.qx[i], c.qy[i], c.qz[i]);
    const Eigen::Vector3d n(c.nx[i], c.ny[i], c.nz[i]);
    Vector6d a;
    a << p.cross(n), n;
    const double b = n.dot(q - p), w = c.weight[i];
    system.hessian.noalias() += w * a * a.transpose();
    system.right_side += w * b * a;
    system.weighted_square_sum += w * b * b;
    system.weight_sum += w;
    system.weighted_point_square_sum += w * p.squaredNorm();
  }
  system.pair_count = static_cast<int>(c.size());
  system.inlier_count = c.inlier_count;
  return system;
}

}  // namespace surfit
