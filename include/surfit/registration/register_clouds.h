#pragma once

#include "surfit/geometry/rigid3.h"
#include "surfit/registration/icp.h"
#include "surfit/registration/point_set.h"

namespace surfit {

class OptionVisitor;

// How two clouds are registered.
struct RegisterCloudsOptions {
  IcpOptions icp = DefaultIcp();  // what is about images is not used
  bool reciprocal = false;        // on the finest level, pairs must be each other's nearest points
  // Level l uses every 4^l-th source point. Levels that would leave fewer than kMinPoints are left
  // out, but never the finest.
  int levels = 4;

  static constexpr int kMinPoints = 1000;

  // Those of frames, with nearest neighbours: the only association that clouds have. Far from the
  // right pose most residuals are large, so that coarse levels need a wide kernel.
  static IcpOptions DefaultIcp();

  void Visit(OptionVisitor& visitor);
};

// Registers source to target from an initial pose, coarse to fine, by ICP with nearest neighbours.
// Throws InputError for impossible options; failure to register is a termination, not an error.
IcpResult RegisterClouds(const PointSet& source, const PointSet& target,
                         const Rigid3d& target_from_source_initial,
                         const RegisterCloudsOptions& options);

}  // namespace surfit
