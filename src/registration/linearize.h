#pragma once

#include "registration/photometric_term.h"
#include "surfit/registration/association.h"
#include "surfit/registration/error_model.h"
#include "surfit/registration/normal_system.h"

namespace surfit {

// The hand-built system of the pairs, on the source point as it is, for residuals weighted by the
// kernel. Single precision pairs: lanes of single precision, summed into double precision every few
// lanes. In a fixed order: the same at any number of threads.
template <typename S>
NormalSystem Linearize(const Pairs<S>& pairs, ResidualType residual, const RobustKernel& kernel);

// The same of what an association finds at a pose, in one pass without a list of pairs.
NormalSystem Linearize(const Association& association, const Rigid3d& target_from_source,
                       ResidualType residual, const RobustKernel& kernel);

// That of intensities, weighted by the term's kernel; of given pairs, and of what the term finds.
PhotometricSystem Linearize(const IntensityPairs& pairs, const PhotometricTerm& term);
PhotometricSystem Linearize(const PhotometricTerm& term, const Rigid3d& target_from_source);

// The error model's kernel for a solve over these pairs, its width in estimated sigmas if so asked.
template <typename S>
RobustKernel KernelFor(const Pairs<S>& pairs, ResidualType residual, const ErrorModel& error_model);

}  // namespace surfit
