// A residual of one's own: the distance of a point to a line in space, for Ceres.
#include <ceres/ceres.h>

#include <cmath>
#include <cstdio>

#include "cost_functions/point_functor.h"
#include "cost_functions/pose_manifold.h"

// r = d x (R p + t - q) / sigma, three residuals: p meets the line through q along the unit vector
// d. Everything else (derivatives, SIMD batches by surfit::ReducedBatch) comes of these lines.
struct PointToLine : surfit::PointFunctor<PointToLine, 10, 3> {
  PointToLine() = default;  // no data: for batches
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

// Points on three edges of a room, moved by (0.01, 0.02, 0.03) m: the pose must find that back.
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
