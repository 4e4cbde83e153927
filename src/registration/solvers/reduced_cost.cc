#include <utility>

#include "registration/icp/own_residuals.h"
#include "registration/solvers/functor_batch.h"
#include "registration/solvers/reduced_solver.h"

namespace surfit {

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
