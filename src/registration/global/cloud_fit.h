#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <vector>

#include "surfit/geometry/rigid3.h"
#include "surfit/registration/association.h"

namespace surfit {

// Length scales of a cloud, in m.
struct CloudScale {
  double spacing_m = 0;  // median point spacing; 0: 24 points or fewer, or equal points
  double noise_m = 0;    // median deviation of points from a plane through their neighbours
};

CloudScale MeasureScale(const std::vector<Eigen::Vector3f>& points);

// Agreement of two clouds at a pose, measured in one direction.
struct CloudAgreement {
  double overlap_ratio = 0;  // source points on the target surface, per source point
  double inlier_ratio = 0;  // source points on the target surface, per source point near the target
};

// Source point at a pose, in the frame of the target.
struct ComparedPoint {
  Eigen::Vector3f point, normal;
  bool is_near = false, is_on_surface = false;
};

// Scales of CloudComparison.
struct ComparisonLimits {
  double near_m = 0;        // a source point within this distance of a target point is near it
  double tolerance_m = 0;   // maximum distance of a point on the surface from the tangent plane
  bool uses_signs = false;  // normals with opposite signs disagree
};

// Compares clouds at poses. A source point on the surface of the target is near a target point. It
// is within the tolerance of the tangent plane, and both normals agree. Points without a normal are
// ignored.
class CloudComparison {
 public:
  CloudComparison(const PointSet& source, const PointSet& target, const ComparisonLimits& limits);
  ~CloudComparison();

  CloudAgreement At(const Rigid3d& target_from_source) const;
  // Source points with a normal, in their order.
  std::vector<ComparedPoint> PointsAt(const Rigid3d& target_from_source) const;
  // Root mean square of the distances of the source points at two poses, m.
  double Distance(const Rigid3d& a, const Rigid3d& b) const;

 private:
  struct Data;
  std::unique_ptr<const Data> data_;
};

// Ranges of a cloud that was observed from one viewpoint, on the six faces of a cube. Free space
// ends at the smallest range in a pixel and its neighbours.
class RangeImage {
 public:
  RangeImage(const std::vector<Eigen::Vector3f>& points, const Eigen::Vector3d& viewpoint,
             double spacing_m);

  enum class Visibility {
    kUnknown,    // the image has no range in this direction
    kFreeSpace,  // in front of the surface
    kSurface,
    kHidden,  // behind the surface
  };
  // `point` is in the frame of the image.
  Visibility VisibilityOf(const Eigen::Vector3d& point, double tolerance_m) const;

  // Ratio of free-space violations: points more than `tolerance_m` in front of the surface, per
  // point that is not behind it. `pose` maps the points to the frame of the image. 0 without points
  // in view.
  double ViolationRatio(const std::vector<Eigen::Vector3f>& points, const Rigid3d& pose,
                        double tolerance_m) const;

 private:
  // Pixel of a direction; the face is the largest component.
  struct Pixel {
    int face, u, v;
  };
  Pixel PixelOf(const Eigen::Vector3d& direction) const;
  std::size_t Index(const Pixel& pixel) const;
  // Smallest range around a pixel; 0 without a point in the pixel.
  float FreeRange(const Pixel& pixel) const;

  Eigen::Vector3d viewpoint_;
  int size_ = 0;                           // pixels along an edge of the cube
  std::vector<float> nearest_, farthest_;  // 0: no point
};

}  // namespace surfit
