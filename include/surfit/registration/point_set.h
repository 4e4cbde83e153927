#pragma once

#include <Eigen/Core>
#include <vector>

#include "surfit/frame/frame_pyramid.h"
#include "surfit/registration/error_model.h"

namespace surfit {

// Points of a surface in no particular order; all of these have the same size.
struct PointSet {
  std::vector<Eigen::Vector3f> points;   // metres, finite
  std::vector<Eigen::Vector3f> normals;  // unit length; (0, 0, 0) if unknown
  std::vector<float> sigma_m;            // standard deviation of a residual of the point

  std::size_t size() const { return points.size(); }
  void Add(const Eigen::Vector3f& point, const Eigen::Vector3f& normal, float point_sigma_m) {
    points.push_back(point);
    normals.push_back(normal);
    sigma_m.push_back(point_sigma_m);
  }
};

// The valid points of a frame, with the error model's sigma for their depth.
PointSet PointSetOf(const FrameLevel& level, const ErrorModel& error_model);

}  // namespace surfit
