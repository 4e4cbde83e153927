#pragma once

#include <optional>
#include <vector>

#include "surfit/evaluation/error_statistics.h"
#include "surfit/evaluation/matched_poses.h"

namespace surfit {

// The interval over which drift is measured.
struct RelativePoseErrorOptions {
  enum class Unit {
    kFrames,  // delta counts matched poses, as in evo and the TUM scripts: lost frames are no steps
    kSeconds,  // the pose whose stamp is nearest to delta later, if off by at most a tenth of delta
  };
  double delta = 1;
  Unit delta_unit = Unit::kFrames;

  // Throws InputError naming the field, its value and the constraint.
  void Validate() const;
};

// Drift over a fixed interval. With P the estimate and Q the ground truth, for every pose i and
// its partner j: E = (Q_i^-1 Q_j)^-1 (P_i^-1 P_j) (Sturm et al., IROS 2012, eq. 1; evo's
// --all_pairs). The TUM script takes the relative poses the other way round, j to i: the same
// rotation, and a translation that differs in second order.
struct RelativePoseError {
  ErrorStatistics translation_m;  // of the length of E's translation
  ErrorStatistics rotation_deg;   // of the angle of E's rotation
};

// Nothing if no two poses are delta apart.
std::optional<RelativePoseError> ComputeRelativePoseError(const std::vector<MatchedPose>& poses,
                                                          const RelativePoseErrorOptions& options);

}  // namespace surfit
