// Example of docs/extend.md: residuals of Surfit in a separate Ceres problem.
#include <ceres/ceres.h>

#include <cmath>
#include <cstdio>

#include "cost_functions/point_to_plane.h"
#include "cost_functions/pose_manifold.h"

int main() {
  double pose[] = {0, 0, 0, 1, 0, 0, 0};  // qx qy qz qw tx ty tz
  ceres::Problem problem;
  problem.AddParameterBlock(pose, surfit::kPoseSize, new surfit::LeftPoseManifold);
  for (int i = 0; i < 300; ++i) {
    const Eigen::Vector3d p(std::sin(7. * i), std::sin(11. * i), 2 + std::sin(13. * i));
    const Eigen::Vector3d q = p + Eigen::Vector3d(0.01, 0.02, 0.03);
    const Eigen::Vector3d n = Eigen::Vector3d::Unit(i % 3);
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<surfit::PointToPlane, 1, surfit::kPoseSize>(
            new surfit::PointToPlane(p, q, n, 0.005)),
        new ceres::HuberLoss(1.5), pose);
  }
  ceres::Solver::Summary summary;
  ceres::Solve(ceres::Solver::Options(), &problem, &summary);
  std::printf("t = %.4f %.4f %.4f\n", pose[4], pose[5], pose[6]);
  return std::fabs(pose[6] - 0.03) < 1e-6 ? 0 : 1;
}
