#pragma once

#include <Eigen/Core>

#include "refinement/joint_row.h"
#include "refinement/shared_surfels.h"

namespace surfit {

// PlaneInverseDepth of one observation of a surfel from one pose with one calibration, all that
// does not depend on the surfel's displacement worked out: with N = n . R e and D = n . (p - t),
//   r(d) = (1/z_measured + c - N / (D + d)) / sigma.
class PlaneSight {
 public:
  PlaneSight(const PlaneObservation& observation, const SharedSurfel& surfel,
             const Eigen::Matrix3d& rotation, const Eigen::Vector3d& translation,
             const DepthCalibration& calibration)
      : ray_(calibration.camera.Ray(observation.u, observation.v)),
        normal_in_camera_(rotation.transpose() * surfel.normal_in_world),
        corrected_(observation.inverse_depth + calibration.field.At(ray_.x(), ray_.y())),
        inverse_sigma_(observation.inverse_sigma),
        along_ray_(normal_in_camera_.dot(ray_)),
        from_camera_(surfel.normal_in_world.dot(surfel.point_in_world - translation)) {}

  double Residual(double displacement) const {
    return (corrected_ - PlaneInverse(displacement)) * inverse_sigma_;
  }
  double ByDisplacement(double displacement) const {
    return PlaneInverse(displacement) / (from_camera_ + displacement) * inverse_sigma_;
  }
  // Metres between the measured point and the plane.
  double Distance(double displacement) const {
    return (along_ray_ / corrected_) - (from_camera_ + displacement);
  }

  // With D standing for D + d:
  //   dr/dw = -(R e x n) / D,  dr/dv = -1/z_plane n / D,
  //   dr/dx = dc/dx - n_x / D, n in the camera's frame, dx/dfx = -x / fx, dx/dcx = -1 / fx.
  JointRow Row(double displacement, const Eigen::Vector3d& normal_in_world,
               const Eigen::Matrix3d& rotation, const DepthCalibration& calibration) const {
    const double inverse_distance = 1 / (from_camera_ + displacement);
    const double x = ray_.x(), y = ray_.y();
    const auto& c = calibration.field.coefficients;
    const double by_x = c[1] + 2 * c[3] * x + c[4] * y - normal_in_camera_.x() * inverse_distance;
    const double by_y = c[2] + c[4] * x + 2 * c[5] * y - normal_in_camera_.y() * inverse_distance;
    const PinholeCamera& camera = calibration.camera;
    JointRow row;
    row.residual = Residual(displacement);
    row.by_pose << (rotation * ray_).cross(normal_in_world),
        PlaneInverse(displacement) * normal_in_world;
    row.by_pose *= -inverse_distance * inverse_sigma_;
    row.by_calibration << -by_x * x / camera.fx, -by_y * y / camera.fy, -by_x / camera.fx,
        -by_y / camera.fy, 1, x, y, x * x, x * y, y * y;
    row.by_calibration *= inverse_sigma_;
    row.by_displacement = ByDisplacement(displacement);
    return row;
  }

 private:
  double PlaneInverse(double displacement) const {
    return along_ray_ / (from_camera_ + displacement);
  }

  Eigen::Vector3d ray_, normal_in_camera_;
  double corrected_, inverse_sigma_;
  double along_ray_, from_camera_;  // N, D
};

}  // namespace surfit
