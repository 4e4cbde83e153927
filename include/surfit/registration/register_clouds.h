#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "surfit/geometry/rigid3.h"
#include "surfit/geometry/sensor.h"
#include "surfit/registration/association.h"
#include "surfit/registration/global_registration.h"
#include "surfit/registration/icp.h"

namespace surfit {

class OptionVisitor;

// Options of the registration of two point clouds.
struct RegisterCloudsOptions {
  // Options for images have no effect, nor does error_model.floor_sigma_m: the weights are
  // 1 / PointSet::sigma_m^2.
  IcpOptions icp = DefaultIcp();
  bool reciprocal = false;  // on the finest level, use mutual nearest neighbours only
  // Number of levels. Level l uses every 4^l-th source point, or more to have at least kMinPoints
  // points.
  int levels = 4;

  static constexpr int kMinPoints = 1000;

  // IcpOptions with association "kd_tree", which clouds require, and a wide kernel on coarse
  // levels, because residuals are large at a wrong initial pose.
  static IcpOptions DefaultIcp();

  void Visit(OptionVisitor& visitor);
};

// Registers source to target with ICP and nearest neighbours, coarse to fine.
// `target_from_source_initial` maps the frame of `source` to the frame of `target`, m.
// point_to_plane needs target normals. A normal gate, symmetric_point_to_plane and plane_to_plane
// need the normals of both clouds. An empty cloud gives kTooFewInliers. Throws InputError for
// invalid options. Throws if the vectors of a PointSet have different sizes. Keeps no reference.
// The result is the same for any number of threads.
//
// `covariance` includes the noise of points and normals, and correlated errors of neighbouring
// points. It also includes errors that source points share through a common target point.
// `information` is its inverse. `covariance` is std::nullopt along `degenerate_directions`, and
// with fewer than 12 independent regions. `information` is then that of Register(). Assumptions:
// - The errors of points more than kErrorSpacings point spacings apart are independent.
// - Both clouds show the same rigid surfaces.
// - The sensor has no systematic error.
IcpResult RegisterClouds(const PointSet& source, const PointSet& target,
                         const Rigid3d& target_from_source_initial,
                         const RegisterCloudsOptions& options);

// Distance from which the errors of points are independent, in point spacings.
inline constexpr double kErrorSpacings = 8;

// Acceptance criteria of a registration of two clouds, which must all hold. Points are on the other
// surface if they are near its tangent plane and the normals agree.
struct CloudCriteria {
  double min_overlap_ratio = 0.1;                // of points on the surface of the other cloud
  double min_inlier_ratio = 0.65;                // points on the other surface, per point near it
  double max_free_space_violation_ratio = 0.06;  // if both viewpoints are known
  // 1 - second-best score / best score. Not tested for a given or identity start with an overlap of
  // at least 0.5 and an inlier ratio of at least 0.85.
  double min_score_margin = 0.1;
  double max_disagreement_spacings = 1;  // RMS of points, plus 3 sigma_m
  double max_sigma_spacings = 0.5;       // of the points, in the least certain direction

  void Visit(OptionVisitor& visitor);
};

// Cloud and the position of its sensor.
struct SensedCloud {
  PointSet points;
  Eigen::Vector3d viewpoint = Eigen::Vector3d::Zero();  // m
  bool has_viewpoint = false;                           // all points were observed from `viewpoint`
  bool has_signed_normals = false;  // false: the signs of the normals are arbitrary
};

// Source of the initial pose of two clouds.
// - identity: no motion.
// - file: the given pose.
// - global: matches of local shapes (FPFH).
// - auto: the given pose, or the identity without one; then global if the result is not accepted.
std::vector<std::string> CloudStartNames();

// Options of the registration of two clouds from any pose.
struct CloudStartOptions {
  std::string method = "auto";  // a name of CloudStartNames()
  CloudCriteria criteria;

  void Visit(OptionVisitor& visitor);
};

// Registration of two clouds with its verification result. Values that were not computed are 0.
struct CloudRegistration {
  GlobalRegistrationReason reason = GlobalRegistrationReason::kNoStart;
  std::string start;  // initial pose of the result: a name of CloudStartNames() except auto
  IcpResult icp;
  double overlap_ratio = 0;  // larger of both directions
  double inlier_ratio = 0;   // smaller of both directions
  // Larger of both directions. std::nullopt: a viewpoint is unknown, or ICP failed.
  std::optional<double> free_space_violation_ratio;
  double score_margin = 0;
  // Forward and backward registration, RMS of the source points. Infinite if backward failed.
  double disagreement_m = 0;
  double sigma_m = 0;    // of the source points, in the least certain direction; may be infinite
  double spacing_m = 0;  // larger median point spacing of both clouds
  double noise_m = 0;    // larger median deviation of points from a plane

  bool accepted() const { return reason == GlobalRegistrationReason::kAccepted; }
};

// Violated criterion or reason, with value and limit if there are any. Empty for kAccepted.
std::string ViolatedCriterion(const CloudRegistration& result, const CloudCriteria& criteria);

// Registers source to target from the initial poses of start.method and verifies the result.
// `given`: target_from_source. Standard deviations of points are at least the noise of the clouds
// and a tenth of the point spacing, or half for point_to_point. If the distance gate is 0, it
// follows from spacing and noise. Clouds without a point spacing give kNoStart. Throws InputError
// for invalid options, and for "file" without a given pose. A rejected registration is a result,
// not an error.
CloudRegistration RegisterCloudsFrom(const SensedCloud& source, const SensedCloud& target,
                                     const std::optional<Rigid3d>& given,
                                     const CloudStartOptions& start,
                                     const RegisterCloudsOptions& options);

// Options for normals of point clouds.
//
// A plane is fitted to the N neighbours of a point within a radius. Dense neighbourhoods are
// thinned. With the eigenvalues l0 <= l1 <= l2 of their covariance:
// - s = sqrt(l0 N / (N - 3)): deviation of the points from the plane,
// - sqrt(l0 / l1): relative thickness of the plane,
// - sqrt(l0 / ((N - 3) l1)) rad: standard deviation of the normal.
// The radius grows until all limits hold: neighbours, thickness, normal, and sqrt(l1 / l2) > 0.01,
// because narrower neighbourhoods are lines (compare Mitra and Nguyen 2003). It is small for
// accurate data and larger for noisy data. Points without a suitable radius, for example at edges
// and in foliage, get no normal.
//
// The search starts at radius_m, or at 2 sigma / max_thickness if that is larger. sigma is the
// known noise. A smaller start would be wrong, because near neighbours can hide the noise. Depth
// cameras quantise depth, so distant surfaces consist of layers that look like exact planes across
// the viewing direction. The deviation of the points along the plane is half the radius, so a plane
// of noisy points is just thin enough at this radius.
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
  double radius_m = 0;                   // initial radius; 0: too few points or all equal
};

// Estimates normals. The points are finite, in m, and fewer than 2^31. Throws InputError for
// invalid options.
CloudNormals EstimateCloudNormals(const std::vector<Eigen::Vector3f>& points,
                                  const CloudSensor& sensor, const CloudNormalOptions& options);

}  // namespace surfit
