#pragma once

#include "registration/photometric_term.h"
#include "surfit/registration/normal_system.h"

namespace surfit {

// The hand-built system of the intensities, weighted by the term's kernel: lanes of single
// precision, summed into double precision every few lanes. In a fixed order: the same at any number
// of threads.
PhotometricSystem Linearize(const IntensityPairs& pairs, const PhotometricTerm& term);

// The same of what the term finds at a pose, without a list of all pairs.
PhotometricSystem Linearize(const PhotometricTerm& term, const Rigid3d& target_from_source);

}  // namespace surfit
