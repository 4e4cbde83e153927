#pragma once

#include <Eigen/Core>
#include <vector>

#include "simulation/sensors/exact_view.h"

namespace surfit {

// Bias of a continuous-wave range by light that one other visible surface reflects (TofOptions).
// The visible surfaces are sampled by a coarse grid of patches.
class Multipath {
 public:
  Multipath(const ExactView& exact, const TofOptions& options);

  // Bias in m of the range of a pixel with a surface. Never negative. Occluders between two
  // surfaces are ignored. The bias is too small closer to a crease than half a patch, which is 1/48
  // of the width of the image.
  double Bias(int u, int v) const;

 private:
  static constexpr int kLanes = 8;
  using Lanes = Eigen::Array<float, kLanes, 1>;
  // Patches side by side. Unused lanes have no power.
  struct Patches {
    Lanes x, y, z, normal_x, normal_y, normal_z, range, area, power;
  };

  const ExactView& exact_;
  const double gain_;
  const float coherence_m_;  // l
  std::vector<Patches, Eigen::aligned_allocator<Patches>> patches_;
};

}  // namespace surfit
