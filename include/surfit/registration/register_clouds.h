#pragma once

#include <Eigen/Core>
#include <vector>

#include "surfit/geometry/rigid3.h"
#include "surfit/geometry/sensor.h"
#include "surfit/registration/association.h"
#include "surfit/registration/icp.h"

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

// How normals come from the points around each point of a cloud.
//
// A plane is fitted to all N neighbours within a radius. With l0 <= l1 <= l2 the eigenvalues of
// their covariance, the points' deviation from the plane is s = sqrt(l0 N / (N - 3)), the plane's
// thickness for its width is sqrt(l0 / l1), and the normal's standard deviation is
// sqrt(l0 / ((N - 3) l1)) rad. The radius grows until there are enough neighbours, the plane is
// thin and the normal is certain (compare Mitra and Nguyen 2003): small where the data is exact,
// larger as it is noisy. Where that never happens (edges, foliage, strays) there is no normal.
//
// Noise need not show among close neighbours: depth cameras round, so that far surfaces fall into
// layers that look like exact planes across the viewing direction. The radius therefore begins no
// smaller than 2 sigma / max_thickness, about where noise of a known sigma makes a thin plane (the
// points' deviation along the plane is half the radius).
struct CloudNormalOptions {
  double radius_m = 0;                 // to begin with; 0 = kSpacings of the cloud's own
  double max_growth = 8;               // of the radius, for whatever reason
  int min_neighbors = 10;              // the point itself included
  double max_thickness = 0.35;         // sqrt(l0 / l1)
  double max_normal_sigma_rad = 0.03;  // standard deviation of the normal

  static constexpr double kSpacings = 3;

  void Visit(OptionVisitor& visitor);
};

// Where a cloud's points were measured from, and how well.
struct CloudSensor {
  Eigen::Vector3d viewpoint = Eigen::Vector3d::Zero();  // normals face it
  DepthNoise noise;                                     // of distances from there

  void Visit(OptionVisitor& visitor);
};

// The normals of a cloud's points, in their order.
struct CloudNormals {
  std::vector<Eigen::Vector3f> normals;  // unit length; (0, 0, 0) where there is none
  std::vector<float> deviation_m;        // s: the points' noise; 0 where there is no normal
  int missing = 0;                       // points without a normal
  double radius_m = 0;                   // to begin with
};

// Points must be finite, in metres, fewer than 2^31. Throws InputError for impossible options.
CloudNormals EstimateCloudNormals(const std::vector<Eigen::Vector3f>& points,
                                  const CloudSensor& sensor, const CloudNormalOptions& options);

}  // namespace surfit
