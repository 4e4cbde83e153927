#pragma once

#include <vector>

#include "registration/global/view_fit.h"
#include "surfit/registration/far_registration.h"

namespace surfit {

// A view as registration from afar needs it.
struct FarView {
  const FramePyramid& pyramid;  // on which all starts are registered
  const FramePyramid& finest;   // on which the best of them is then; the same where that is done
  ViewLevel level;              // on which fits are measured
  bool has_color = false;
};

struct FarOptions {
  IcpOptions icp_from_start;  // on the pyramid; its error model measures fits
  IcpOptions icp;             // on the finest
  FitCriteria fit;
};

// Registers a view to another from each of the starts, and looks for reasons to refuse the best
// fit: in how the views look there, in the registration on the finest level, in rival poses (from
// other starts, and to both sides along what the data holds least) and in the registration the
// other way round. Adds what it finds to a verdict.
FarVerdict RegisterFrom(const std::vector<Rigid3d>& starts, const FarView& source,
                        const FarView& target, const FarOptions& options,
                        const FarVerdict& verdict = {});

// Whether two poses are one and the same fit.
bool AreSame(const Rigid3d& a, const Rigid3d& b);

// What a fit's covariance is in truth, from registration's and from how far registration the other
// way round disagrees. Registration's own is as if all residuals were independent, but neighbours
// share noise through filters; and both views share what is wrong with the camera's calibration,
// which many points do not make less.
Matrix6d RealisticCovariance(const Matrix6d& covariance, double disagreement_rad,
                             double disagreement_m);

}  // namespace surfit
