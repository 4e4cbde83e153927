#pragma once

#include <optional>
#include <vector>

#include "surfit/evaluation/alignment.h"
#include "surfit/evaluation/error_statistics.h"
#include "surfit/evaluation/matched_poses.h"

namespace surfit {

// How far the estimated camera centres are from the true ones, once the estimate as a whole is
// placed as well as a rigid motion can (Sturm et al., IROS 2012, eq. 3-4).
struct AbsoluteTrajectoryError {
  Alignment alignment;            // target: the ground truth's world, source: the estimate's
  ErrorStatistics translation_m;  // of |true centre - aligned centre|
};

// Nothing if fewer than 3 poses match. On a straight path the rotation is not unique, the error is.
std::optional<AbsoluteTrajectoryError> ComputeAbsoluteTrajectoryError(
    const std::vector<MatchedPose>& poses);

}  // namespace surfit
