#include "surfit/evaluation/alignment.h"

#include <glog/logging.h>

#include <Eigen/SVD>

namespace surfit {
namespace {

// Rounding leaves a line's cross-covariance with a second singular value of some 1e-16 of the
// first; the millimetre noise of a real path of 10 m leaves 1e-8.
constexpr double kRankTolerance = 1e-12;

Eigen::Vector3d Mean(const std::vector<Eigen::Vector3d>& points) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& point : points) sum += point;
  return sum / static_cast<double>(points.size());
}

}  // namespace

// With centred points, R maximises tr(R^T C), C = sum target_i source_i^T = U D V^T, D >= 0 in
// descending order. The maximum over rotations is R = U S V^T, S = diag(1, 1, det U det V). It is
// attained by one R only if d_2 + s_3 d_3 > 0: otherwise turning the last two axes costs nothing.
Alignment AlignPoints(const std::vector<Eigen::Vector3d>& source,
                      const std::vector<Eigen::Vector3d>& target) {
  CHECK_EQ(source.size(), target.size());
  Alignment alignment;
  if (source.size() < 3) return alignment;
  const Eigen::Vector3d source_mean = Mean(source), target_mean = Mean(target);
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < source.size(); ++i) {
    covariance += (target[i] - target_mean) * (source[i] - source_mean).transpose();
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance,
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  CHECK_EQ(svd.info(), Eigen::Success) << "a point is not finite";
  const Eigen::Matrix3d &u = svd.matrixU(), &v = svd.matrixV();
  const Eigen::Vector3d& d = svd.singularValues();
  const Eigen::Vector3d s(1, 1, u.determinant() * v.determinant() < 0 ? -1 : 1);
  const Eigen::Matrix3d rotation = u * s.asDiagonal() * v.transpose();
  alignment.target_from_source = Rigid3d(rotation, target_mean - rotation * source_mean);
  alignment.status = d[1] + s[2] * d[2] > kRankTolerance * d[0]
                         ? AlignmentStatus::kAligned
                         : AlignmentStatus::kRotationNotUnique;
  return alignment;
}

}  // namespace surfit
