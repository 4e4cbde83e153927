// Custom residual for Ceres: the distance of a point to a line.
#include <ceres/ceres.h>

#include <cmath>
#include <cstdio>

#include "cost_functions/point_functor.h"
#include "cost_functions/pose_manifold.h"

// Three residuals r = d x (R p + t - q) / sigma of a point p and the line through q with the unit
// vector d. The base class adds derivatives and SIMD batches (surfit::ReducedBatch).
struct PointToLine : surfit::PointFunctor<PointToLine, 10, 3> {
  PointToLine() = default;  // required by batches
  PointToLine(const Eigen::Vector3d& p, const Eigen::Vector3d& q, const Eigen::Vector3d& d,
              double sigma_m) {
    Set(0, p);
    Set(3, q);
    Set(6, d);
    data[9] = 1 / sigma_m;
  }
  template <typename T, typename D>
  void AtMovedPoint(const T* y, const D* numbers, T* residuals) const {
    const T offset[3] = {y[0] - numbers[3], y[1] - numbers[4], y[2] - numbers[5]};
    surfit::Cross(numbers + 6, offset, residuals);
    for (int i = 0; i < 3; ++i) residuals[i] = residuals[i] * numbers[9];
  }
};

// Estimates the translation (0.01, 0.02, 0.03) m from points on three edges of a room.
int main() {
  double pose[] = {0, 0, 0, 1, 0, 0, 0};  // qx qy qz qw tx ty tz
  ceres::Problem problem;
  problem.AddParameterBlock(pose, surfit::kPoseSize, new surfit::LeftPoseManifold);
  for (int i = 0; i < 300; ++i) {
    const Eigen::Vector3d line = Eigen::Vector3d::Unit(i % 3);
    const Eigen::Vector3d edge(std::cos(2. * (i % 3)), std::sin(3. * (i % 3)), 2);
    const Eigen::Vector3d p = edge + 0.01 * i * line - Eigen::Vector3d(0.01, 0.02, 0.03);
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<PointToLine, 3, surfit::kPoseSize>(
                                 new PointToLine(p, edge, line, 0.005)),
                             nullptr, pose);
  }
  ceres::Solver::Summary summary;
  ceres::Solve(ceres::Solver::Options(), &problem, &summary);
  std::printf("t = %.4f %.4f %.4f\n", pose[4], pose[5], pose[6]);
  const Eigen::Vector3d error = Eigen::Vector3d(0.01, 0.02, 0.03) - Eigen::Vector3d(pose + 4);
  return error.norm() < 1e-6 ? 0 : 1;
}
