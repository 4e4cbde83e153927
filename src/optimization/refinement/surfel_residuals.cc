#include <Eigen/Cholesky>

#include "cost_functions/robust_kernel.h"
#include "optimization/refinement/reduced_system.h"

namespace surfit {
namespace {

constexpr int kSteps = 4;

double BestDisplacement(const std::vector<PlaneResidual>& sights, const RobustKernel& kernel) {
  double displacement = 0;
  for (int step = 0; step < kSteps; ++step) {
    double information = 0, gradient = 0;
    for (const PlaneResidual& sight : sights) {
      const double r = sight.Residual(displacement);
      const double b = sight.ByDisplacement(displacement);
      const double weight = EvaluateKernel(kernel, r * r).slope;
      information += weight * b * b;
      gradient += weight * b * r;
    }
    if (!(information > 0)) break;
    displacement -= gradient / information;
  }
  return displacement;
}

struct OwnSystem {
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();

  void Add(const Eigen::Vector3d& by_surfel, double residual, double weight) {
    information += weight * by_surfel * by_surfel.transpose();
    gradient += weight * residual * by_surfel;
  }
};

OwnSystem SystemOf(const std::vector<PlaneResidual>& planes,
                   const std::vector<TextureResidual>& textures, const SurfelParameters& at,
                   const JointKernels& kernels) {
  OwnSystem system;
  for (const PlaneResidual& sight : planes) {
    const double r = sight.Residual(at.displacement);
    system.Add({sight.ByDisplacement(at.displacement), 0, 0}, r,
               EvaluateKernel(kernels.plane, r * r).slope);
  }
  for (const TextureResidual& sight : textures) {
    const Eigen::Vector2d r = sight.Residuals(at);
    const Eigen::Vector2d slope = sight.ByDisplacement(at.displacement);
    const double weight = EvaluateKernel(kernels.texture, r.squaredNorm()).slope;
    system.Add({slope[0], -1, 0}, r[0], weight);
    system.Add({slope[1], 0, -1}, r[1], weight);
  }
  return system;
}

Eigen::Vector2d MeanDifferences(const std::vector<TextureResidual>& textures, double displacement) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const TextureResidual& sight : textures) sum += sight.Differences(displacement);
  return sum / static_cast<double>(textures.size());
}

}  // namespace

SurfelResiduals::SurfelResiduals(const SharedSurfels& shared, const SharedSurfel& surfel,
                                 const PlacedPoses& placed) {
  const DepthCalibration& calibration = placed.state.calibration;
  const std::vector<Rigid3d>& poses = placed.state.world_from_camera;
  planes_.reserve(surfel.end - surfel.begin);
  for (std::size_t i = surfel.begin; i < surfel.end; ++i) {
    const PlaneObservation& seen = shared.observations[i];
    planes_.emplace_back(
        seen, surfel, placed.rotations[seen.keyframe], poses[seen.keyframe].translation,
        MotionOf(seen, shared.readouts[seen.keyframe], calibration.camera.height), calibration);
  }
  textures_.reserve(surfel.textures_end - surfel.textures_begin);
  for (std::size_t i = surfel.textures_begin; i < surfel.textures_end; ++i) {
    const TextureObservation& seen = shared.textures[i];
    textures_.emplace_back(seen, surfel, placed.rotations[seen.keyframe],
                           poses[seen.keyframe].translation, calibration);
  }
}

SurfelParameters SurfelResiduals::Best(const JointKernels& kernels) const {
  SurfelParameters best = {BestDisplacement(planes_, kernels.plane)};
  if (textures_.empty()) return best;
  best.texture = MeanDifferences(textures_, best.displacement);
  for (int step = 0; step < kSteps; ++step) {
    const OwnSystem system = SystemOf(planes_, textures_, best, kernels);
    const Eigen::LLT<Eigen::Matrix3d> llt(system.information);
    if (llt.info() != Eigen::Success) break;
    const Eigen::Vector3d change = llt.solve(system.gradient);
    best.displacement -= change[0];
    best.texture -= change.tail<2>();
  }
  return best;
}

JointFit SurfelResiduals::FitOf(const JointKernels& kernels) const {
  const SurfelParameters best = Best(kernels);
  JointFit fit;
  for (const PlaneResidual& sight : planes_) {
    const double r = sight.Residual(best.displacement);
    const double distance = sight.Distance(best.displacement);
    const KernelValue<double> value = EvaluateKernel(kernels.plane, r * r);
    fit.rho += value.rho;
    fit.weight += value.slope;
    fit.squared_sigmas += value.slope * r * r;
    fit.squared_metres += value.slope * distance * distance;
  }
  for (const TextureResidual& sight : textures_) {
    const double squared = sight.Residuals(best).squaredNorm();
    const KernelValue<double> value = EvaluateKernel(kernels.texture, squared);
    const double sigma = 1 / sight.inverse_sigma();
    fit.rho += value.rho;
    fit.texture_weight += 2 * value.slope;  // two differences
    fit.squared_differences += value.slope * squared * sigma * sigma;
  }
  return fit;
}

}  // namespace surfit
