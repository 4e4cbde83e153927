#pragma once

#include <Eigen/Core>
#include <array>

#include "cost_functions/surfel_texture.h"
#include "refinement/joint_row.h"
#include "refinement/shared_surfels.h"
#include "registration/residual_rows.h"

namespace surfit {

// SurfelTexture of one observation of a surfel from one pose with one calibration, all that does
// not depend on the surfel's own numbers worked out.
class TextureSight {
 public:
  TextureSight(const TextureObservation& observation, const SharedSurfel& surfel,
               const Eigen::Matrix3d& rotation, const Eigen::Vector3d& translation,
               const DepthCalibration& calibration)
      : taps_(observation.taps),
        inverse_sigma_(observation.inverse_sigma),
        normal_in_camera_(rotation.transpose() * surfel.normal_in_world),
        camera_(calibration.camera) {
    const auto points = TexturePoints(surfel);
    for (std::size_t j = 0; j < points.size(); ++j) {
      from_camera_[j] = points[j] - translation;
      points_in_camera_[j] = rotation.transpose() * from_camera_[j];
    }
  }

  // The differences of intensity in standard deviations, without the surfel's own.
  Eigen::Vector2d Differences(double displacement) const {
    const double center = Intensity(0, displacement);
    return inverse_sigma_ * Eigen::Vector2d(Intensity(1, displacement) - center,
                                            Intensity(2, displacement) - center);
  }
  Eigen::Vector2d Residuals(const SurfelNumbers& surfel) const {
    return Differences(surfel.displacement) - surfel.texture;
  }
  double inverse_sigma() const { return inverse_sigma_; }

  // With the intensity's slope by the point in the camera, g of IntensityGradient(),
  //   dI/dw = R g x (p + d n - t),  dI/dv = -R g,  dI/dd = g . R^T n,
  //   dI/dfx = I_u x / z,  dI/dcx = I_u.
  std::array<JointRow, 2> Rows(const SurfelNumbers& surfel, const Eigen::Vector3d& normal_in_world,
                               const Eigen::Matrix3d& rotation) const {
    const double displacement = surfel.displacement;
    const Eigen::Vector2d residuals = Residuals(surfel);
    const JointRow center = IntensityRow(0, displacement, normal_in_world, rotation);
    std::array<JointRow, 2> rows;
    for (int j = 0; j < 2; ++j) {
      const JointRow beside = IntensityRow(j + 1, displacement, normal_in_world, rotation);
      rows[j].residual = residuals[j];
      rows[j].by_pose = inverse_sigma_ * (beside.by_pose - center.by_pose);
      rows[j].by_calibration = inverse_sigma_ * (beside.by_calibration - center.by_calibration);
      rows[j].by_displacement = inverse_sigma_ * (beside.by_displacement - center.by_displacement);
    }
    return rows;
  }
  // Their derivatives by the displacement alone.
  Eigen::Vector2d ByDisplacement(double displacement) const {
    const double center = Slope(0, displacement).dot(normal_in_camera_);
    return inverse_sigma_ * Eigen::Vector2d(Slope(1, displacement).dot(normal_in_camera_) - center,
                                            Slope(2, displacement).dot(normal_in_camera_) - center);
  }

 private:
  Eigen::Vector3d PointInCamera(int j, double displacement) const {
    return points_in_camera_[j] + displacement * normal_in_camera_;
  }
  double Intensity(int j, double displacement) const {
    const IntensityTap& tap = taps_[j];
    const Eigen::Vector2d at = camera_.Project(PointInCamera(j, displacement));
    return tap.value + (at.x() - tap.u) * tap.slope_u + (at.y() - tap.v) * tap.slope_v;
  }
  Eigen::Vector3d Slope(int j, double displacement) const {
    const Eigen::Vector3d p = PointInCamera(j, displacement);
    Eigen::Vector3d g;
    IntensityGradient<double>(
        taps_[j].slope_u, taps_[j].slope_v, camera_.fx, camera_.fy, p.data(),
        [&](double a) { return a / p.z(); }, g.data());
    return g;
  }
  JointRow IntensityRow(int j, double displacement, const Eigen::Vector3d& normal_in_world,
                        const Eigen::Matrix3d& rotation) const {
    const IntensityTap& tap = taps_[j];
    const Eigen::Vector3d p = PointInCamera(j, displacement), slope = Slope(j, displacement);
    const Eigen::Vector3d turned = rotation * slope;
    JointRow row;
    row.by_pose << turned.cross(from_camera_[j] + displacement * normal_in_world), -turned;
    row.by_calibration << tap.slope_u * p.x() / p.z(), tap.slope_v * p.y() / p.z(), tap.slope_u,
        tap.slope_v, 0, 0, 0, 0, 0, 0;
    row.by_displacement = slope.dot(normal_in_camera_);
    return row;
  }

  const TextureTaps& taps_;
  double inverse_sigma_;
  Eigen::Vector3d normal_in_camera_;
  const PinholeCamera& camera_;
  std::array<Eigen::Vector3d, 3> from_camera_, points_in_camera_;
};

}  // namespace surfit
