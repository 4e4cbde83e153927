#pragma once

#include "cost_functions/own_residual.h"

namespace surfit {

// User-defined residual with the name of the type; null for a built-in residual.
const OwnResidual* OwnResidualOf(ResidualType type);

// Ratio of the variance of a normal that acts in the direction of the rows, see
// FeignedInformation(). 1: only the target normal is used, 0.5: both normals, 0: none.
inline double NormalShareOf(const OwnResidual& residual) {
  if (residual.needed_normals() == NeededNormals::kNone) return 0;
  return residual.needed_normals() == NeededNormals::kTarget ? 1 : 0.5;
}

}  // namespace surfit
