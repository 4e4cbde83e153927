#pragma once

#include "cost_functions/own_residual.h"

namespace surfit {

// User-defined residual with the name of the type; null for a built-in residual. Valid until the
// process ends.
const OwnResidual* OwnResidualOf(ResidualType type);

// Variance of the row direction relative to the variance of a normal, see SpuriousInformation(). 1:
// target normal, 0.5: mean of both normals, 0: no normal.
inline double NormalShareOf(const OwnResidual& residual) {
  if (residual.needed_normals() == NeededNormals::kNone) return 0;
  return residual.needed_normals() == NeededNormals::kTarget ? 1 : 0.5;
}

}  // namespace surfit
