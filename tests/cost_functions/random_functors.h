#pragma once

#include <ceres/ceres.h>

#include <vector>

#include "cost_functions/angle_axis_pose.h"
#include "cost_functions/photometric.h"
#include "cost_functions/plane_to_plane.h"
#include "cost_functions/point_to_plane.h"
#include "cost_functions/point_to_point.h"
#include "cost_functions/pose_manifold.h"
#include "cost_functions/reduced_batch.h"
#include "cost_functions/symmetric_point_to_plane.h"
#include "testing/random_pose.h"

namespace surfit::testing {

// Point about 2 m in front of the source camera, and its noisy transformed point.
struct Match {
  Eigen::Vector3d p, q, m, n;  // m: normal at p; n = R m: normal at q
  double sigma_m;
};

inline Match RandomMatch(const Rigid3d& target_from_source, double noise_m, std::mt19937_64* rng) {
  Match match;
  match.p = RandomVector(1, rng) + Eigen::Vector3d(0, 0, 2);
  match.q = target_from_source * match.p + RandomVector(noise_m, rng);
  match.m = RandomVector(1, rng).normalized();
  match.n = target_from_source.rotation * match.m;
  match.sigma_m = 0.005 + 0.002 * RandomVector(1, rng).x();
  return match;
}

inline void Append(const Match& m, std::vector<PointToPoint>* functors) {
  functors->emplace_back(m.p, m.q, m.sigma_m);
}
inline void Append(const Match& m, std::vector<PointToPlane>* functors) {
  functors->emplace_back(m.p, m.q, m.n, m.sigma_m);
}
inline void Append(const Match& m, std::vector<SymmetricPointToPlane>* functors) {
  functors->emplace_back(m.p, m.m, m.q, m.n, m.sigma_m);
}
inline void Append(const Match& m, std::vector<PlaneToPlane>* functors) {
  functors->emplace_back(m.p, m.q, 2 * PlaneToPlane::CovarianceOfPlane(m.n, m.sigma_m, 0.1));
}
// Linear image around the projection of q, where it has the intensity of the point.
inline void Append(const Match& m, std::vector<Photometric>* functors) {
  const Photometric camera(500, 510, 320, 240);
  const double u = camera.fx * m.q.x() / m.q.z() + camera.cx;
  const double v = camera.fy * m.q.y() / m.q.z() + camera.cy;
  const Eigen::Vector2d gradient(3 * m.n.x(), 3 * m.n.y());
  functors->push_back(camera);
  functors->back().SetPoint(m.p, 100, u, v, 100, gradient, 1000 * m.sigma_m);
}

template <typename Functor>
std::vector<Functor> RandomFunctors(int count, const Rigid3d& target_from_source, double noise_m,
                                    std::uint64_t seed) {
  std::mt19937_64 rng(seed);
  std::vector<Functor> functors;
  for (int i = 0; i < count; ++i) Append(RandomMatch(target_from_source, noise_m, &rng), &functors);
  return functors;
}

template <typename Functor>
Functor Definition() {
  return Functor();
}
template <>
inline Photometric Definition<Photometric>() {
  return Photometric(500, 510, 320, 240);
}

using PoseBlock = Eigen::Matrix<double, kPoseSize, 1>;

inline PoseBlock AsBlock(const Rigid3d& pose) {
  PoseBlock block;
  PoseToBlock(pose, block.data());
  return block;
}

// Solves to the limit of double precision.
inline ceres::Solver::Summary Solve(ceres::Problem* problem) {
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.max_num_iterations = 100;
  options.function_tolerance = 1e-15;
  options.gradient_tolerance = 1e-15;
  options.parameter_tolerance = 1e-14;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, problem, &summary);
  return summary;
}

template <typename Functor>
ceres::CostFunction* PerPointCost(const Functor& functor) {
  return new ceres::AutoDiffCostFunction<Functor, Functor::kResidualSize, kPoseSize>(
      new Functor(functor));
}

template <typename Functor>
Rigid3d SolvePerPoint(const std::vector<Functor>& functors, const Rigid3d& initial,
                      ceres::Manifold* manifold) {
  PoseBlock pose = AsBlock(initial);
  ceres::Problem problem;
  problem.AddParameterBlock(pose.data(), kPoseSize, manifold);
  for (const Functor& f : functors) problem.AddResidualBlock(PerPointCost(f), nullptr, pose.data());
  Solve(&problem);
  return PoseFromBlock(pose.data());
}

template <typename Functor>
Rigid3d SolveWithAngleAxis(const std::vector<Functor>& functors, const Rigid3d& initial) {
  Eigen::Matrix<double, 6, 1> pose;
  pose << QuaternionLog<double>(initial.rotation), initial.translation;
  ceres::Problem problem;
  for (const Functor& f : functors) {
    using Cost = WithAngleAxisPose<Functor>;
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<Cost, Functor::kResidualSize, 6>(new Cost(f)), nullptr,
        pose.data());
  }
  Solve(&problem);
  return {QuaternionExp<double>(pose.head<3>()), pose.tail<3>()};
}

}  // namespace surfit::testing
