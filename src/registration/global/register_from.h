#pragma once

#include <vector>

#include "registration/global/view_fit.h"
#include "surfit/registration/global_registration.h"

namespace surfit {

// Each pyramid needs at least one level. References must outlive the registration.
struct GlobalView {
  const FramePyramid& pyramid;  // registered from all initial poses
  // For the final registration of the best pose. The same object as `pyramid`: no final
  // registration.
  const FramePyramid& finest;
  ViewLevel level;  // for the score of fits
  bool has_color = false;
};

struct GlobalRegistrationOptions {
  IcpOptions icp_from_start;  // on `pyramid`; the error model also scores fits
  IcpOptions icp;             // on `finest`
  FitCriteria fit;
};

// Registers two views from several initial poses and verifies the best fit. The checks are:
// 1. agreement of the views at that pose,
// 2. final registration on the finest level,
// 3. score margin over other poses: other initial poses, and shifts along the weakest direction,
// 4. backward registration.
//
// The result extends `verdict`, which has the feature counts. Without initial poses, the reason is
// kNotRegistered.
GlobalRegistrationResult RegisterFrom(const std::vector<Rigid3d>& starts, const GlobalView& source,
                                      const GlobalView& target,
                                      const GlobalRegistrationOptions& options,
                                      const GlobalRegistrationResult& verdict = {});

// True if two poses are equal within the tolerance of a registration: 4 cm and 2 degrees.
bool AreSame(const Rigid3d& a, const Rigid3d& b);

// Covariance (w [rad], v [m]) of a fit with systematic errors. Registration assumes independent
// residuals, but filters correlate neighbouring pixels. Calibration errors are common to both
// views, so more points do not reduce them. The disagreement of forward and backward registration
// is added, too.
Matrix6d RealisticCovariance(const Matrix6d& covariance, double disagreement_rad,
                             double disagreement_m);

}  // namespace surfit
