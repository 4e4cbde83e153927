#pragma once

#include <Eigen/Core>
#include <vector>

#include "refinement/joint_rows.h"
#include "refinement/joint_state.h"

namespace surfit {

// All that keyframes at one state see of a surfel.
class SurfelSight {
 public:
  SurfelSight(const SharedSurfels& shared, const SharedSurfel& surfel, const PlacedPoses& placed);

  const std::vector<PlaneSight>& planes() const { return planes_; }
  const std::vector<TextureSight>& textures() const { return textures_; }  // empty without texture

  // Those for which its observations agree best, from no displacement on.
  SurfelNumbers Best(const JointKernels& kernels) const;
  // How far its observations are from those.
  JointFit FitOf(const JointKernels& kernels) const;

 private:
  std::vector<PlaneSight> planes_;
  std::vector<TextureSight> textures_;
};

}  // namespace surfit
