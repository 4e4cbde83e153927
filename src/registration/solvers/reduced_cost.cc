#include <ceres/autodiff_cost_function.h>

#include <utility>

#include "cost_functions/pose_prior.h"
#include "registration/icp/own_residuals.h"
#include "registration/solvers/functor_batch.h"
#include "registration/solvers/reduced_solver.h"

namespace surfit {
namespace {

struct PaddedPosePrior {
  PosePrior prior;

  template <typename T>
  bool operator()(const T* pose, T* residuals) const {
    residuals[kRowColumns - 1] = T(0);
    return prior(pose, residuals);
  }
};

}  // namespace

// With an increment D from `pose`, the error of the pose D * pose from the prior Z equals the error
// of D from Z pose^-1.
std::unique_ptr<ceres::CostFunction> MakePriorCost(const PriorTerm& prior, const Rigid3d& pose) {
  return std::make_unique<ceres::AutoDiffCostFunction<PaddedPosePrior, kRowColumns, kPoseSize>>(
      new PaddedPosePrior{PosePrior(prior.target_from_source * pose.Inverse(), prior.information)});
}

template <typename S>
std::unique_ptr<ReducedBlock> MakeReducedCost(Pairs<S> pairs, ResidualType residual,
                                              const RobustKernel& kernel) {
  if (const OwnResidual* const own = OwnResidualOf(residual))
    return own->Reduced(std::move(pairs), kernel);
  return WithFunctorOf(residual, [&](const auto& functor) -> std::unique_ptr<ReducedBlock> {
    return std::make_unique<ReducedBatch<std::decay_t<decltype(functor)>, S>>(
        functor, MakeBatch(std::move(pairs), functor), kernel);
  });
}

std::unique_ptr<ReducedBlock> MakeReducedCost(const IntensityPairs& pairs,
                                              const PhotometricTerm& term) {
  return std::make_unique<ReducedBatch<Photometric>>(FunctorOf(term.camera()),
                                                     MakeBatch(pairs, term), term.kernel());
}

template std::unique_ptr<ReducedBlock> MakeReducedCost(Pairs<float>, ResidualType,
                                                       const RobustKernel&);
template std::unique_ptr<ReducedBlock> MakeReducedCost(Pairs<double>, ResidualType,
                                                       const RobustKernel&);

}  // namespace surfit
