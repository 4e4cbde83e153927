#pragma once

#include "cost_functions/own_residual.h"

namespace surfit {

// What was registered under the type's name; null for one of our own.
const OwnResidual* OwnResidualOf(ResidualType type);

// The share of a normal's variance that the direction of its rows has, as far as its normals tell
// (FeignedInformation()): all, half where it goes by both, or none.
inline double NormalShareOf(const OwnResidual& residual) {
  if (residual.needed_normals() == NeededNormals::kNone) return 0;
  return residual.needed_normals() == NeededNormals::kTarget ? 1 : 0.5;
}

}  // namespace surfit
