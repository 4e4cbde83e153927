#pragma once

#include <Eigen/Core>
#include <vector>

#include "surfit/geometry/rigid3.h"
#include "surfit/geometry/sensor.h"
#include "surfit/registration/association.h"
#include "surfit/registration/icp.h"

namespace surfit {

class OptionVisitor;

// Options of the registration of two point clouds.
struct RegisterCloudsOptions {
  IcpOptions icp = DefaultIcp();  // options for images have no effect
  bool reciprocal = false;        // on the finest level, use mutual nearest neighbours only
  // Number of levels. Level l uses every 4^l-th source point. Coarse levels with fewer than
  // kMinPoints source points are skipped.
  int levels = 4;

  static constexpr int kMinPoints = 1000;

  // IcpOptions with association "kd_tree", which clouds require, and a wide kernel on coarse
  // levels, because residuals are large at a wrong initial pose.
  static IcpOptions DefaultIcp();

  void Visit(OptionVisitor& visitor);
};

// Registers source to target with ICP and nearest neighbours, coarse to fine. Throws InputError for
// invalid options. A failed registration is a termination, not an error.
IcpResult RegisterClouds(const PointSet& source, const PointSet& target,
                         const Rigid3d& target_from_source_initial,
                         const RegisterCloudsOptions& options);

// Options for normals of point clouds.
//
// A plane is fitted to all N neighbours of a point within a radius. With the eigenvalues l0 <= l1
// <= l2 of their covariance:
// - s = sqrt(l0 N / (N - 3)): deviation of the points from the plane,
// - sqrt(l0 / l1): relative thickness of the plane,
// - sqrt(l0 / ((N - 3) l1)) rad: standard deviation of the normal.
// The radius grows until all three limits hold: neighbours, thickness and normal (compare Mitra and
// Nguyen 2003). It is small for accurate data and larger for noisy data. Points without a suitable
// radius, for example at edges and in foliage, get no normal.
//
// The initial radius is at least 2 sigma / max_thickness, with the known noise sigma, because near
// neighbours can hide the noise. Depth cameras quantise depth, so distant surfaces consist of
// layers that look like exact planes across the viewing direction. The deviation of the points
// along the plane is half the radius, so a plane of noisy points is just thin enough at this
// radius.
struct CloudNormalOptions {
  double radius_m = 0;                 // initial radius; 0: kSpacings times the point spacing
  double max_growth = 8;               // maximum growth factor of the radius
  int min_neighbors = 10;              // including the point itself
  double max_thickness = 0.35;         // limit of sqrt(l0 / l1)
  double max_normal_sigma_rad = 0.03;  // limit of the standard deviation of the normal

  static constexpr double kSpacings = 3;

  void Visit(OptionVisitor& visitor);
};

// Viewpoint and noise of a point cloud.
struct CloudSensor {
  Eigen::Vector3d viewpoint = Eigen::Vector3d::Zero();  // m; normals point to it
  DepthNoise noise;                                     // of distances from the viewpoint

  void Visit(OptionVisitor& visitor);
};

// Normals of a point cloud, in the order of its points.
struct CloudNormals {
  std::vector<Eigen::Vector3f> normals;  // unit length; (0, 0, 0): none
  std::vector<float> deviation_m;        // s, the noise of the points; 0: no normal
  int missing = 0;                       // points without a normal
  double radius_m = 0;                   // initial radius
};

// Estimates normals. The points are finite, in m, and fewer than 2^31. Throws InputError for
// invalid options.
CloudNormals EstimateCloudNormals(const std::vector<Eigen::Vector3f>& points,
                                  const CloudSensor& sensor, const CloudNormalOptions& options);

}  // namespace surfit
