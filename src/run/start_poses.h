#pragma once

#include <cstdint>
#include <vector>

#include "surfit/geometry/rigid3.h"

namespace surfit {

// A place in the grid of perturbations.
struct GridCell {
  int rotation = 0;  // indices of what is perturbed by
  int translation = 0;
  bool on_diagonal() const { return rotation == translation; }
  friend bool operator==(const GridCell& a, const GridCell& b) {
    return a.rotation == b.rotation && a.translation == b.translation;
  }
};

// All cells, rotation by rotation.
std::vector<GridCell> AllCells(int rotations, int translations);

// The pose turned about the target's origin by an angle and shifted by a distance, about and along
// axes that are random and depend on the seed alone.
Rigid3d Perturbed(const Rigid3d& target_from_source, double rotation_rad, double translation_m,
                  std::uint64_t seed);

}  // namespace surfit
