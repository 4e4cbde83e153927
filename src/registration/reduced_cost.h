#pragma once

#include <ceres/cost_function.h>

#include <memory>

#include "registration/photometric_term.h"
#include "surfit/core/robust_kernel.h"
#include "surfit/registration/pairs.h"
#include "surfit/registration/residual_type.h"

namespace surfit {

// All pairs as one ReducedBatch over the residual's functor, in the precision of the pairs, whose
// arrays must be of their size. The pose block starts at the identity: see functor_batch.h.
template <typename S>
std::unique_ptr<ceres::CostFunction> MakeReducedCost(Pairs<S> pairs, ResidualType residual,
                                                     const RobustKernel& kernel);

// The same of intensities.
std::unique_ptr<ceres::CostFunction> MakeReducedCost(const IntensityPairs& pairs,
                                                     const PhotometricTerm& term);

}  // namespace surfit
