#pragma once

#include <Eigen/Core>
#include <array>

#include "cost_functions/plane_inverse_depth.h"
#include "cost_functions/pose.h"
#include "cost_functions/surfel_texture.h"
#include "optimization/refinement/shared_surfels.h"
#include "registration/icp/residual_rows.h"

namespace surfit {

// Number of surfel parameters: the displacement, and two intensity differences if the surfel has
// texture.
inline constexpr int kPlaneUnknowns = 1;
inline constexpr int kTexturedUnknowns = 3;

using PoseRow = Eigen::Matrix<double, kPoseTangentSize, 1>;
using CalibrationRow = Eigen::Matrix<double, kCalibrationSize, 1>;
template <int kUnknowns>
using SurfelRow = Eigen::Matrix<double, kUnknowns, 1>;

// Surfel parameters, which are eliminated from the joint problem.
struct SurfelParameters {
  double displacement = 0;                            // m, along its normal
  Eigen::Vector2d texture = Eigen::Vector2d::Zero();  // intensity differences, in sigmas
};

// The pose perturbation is (w, v) of ProductPoseManifold.
struct JointRow {
  double residual = 0;
  PoseRow by_pose;
  CalibrationRow by_calibration;
  double by_displacement = 0;
};

// Analytic version of PlaneInverseDepth for one observation. The displacement is d:
//   r(d) = (1/z_measured + c - N / (D + d)) / sigma,  N = n . R e,  D = n . (p - t).
// e and t: viewing ray and camera centre at the capture time of the pixel row. c: depth field, 1/m.
// sigma: 1 / inverse_sigma. Keeps no references. Results are not finite if the plane contains the
// camera centre.
class PlaneResidual {
 public:
  PlaneResidual(const PlaneObservation& observation, const SharedSurfel& surfel,
                const Eigen::Matrix3d& rotation, const Eigen::Vector3d& translation,
                const RowMotion& motion, const DepthCalibration& calibration)
      : motion_(motion),
        later_(calibration.readout_s - motion.readout_s),
        ray_(calibration.camera.Ray(observation.u, observation.v)),
        normal_in_camera_(rotation.transpose() * surfel.normal_in_world),
        normal_at_row_(normal_in_camera_ + later_ * normal_in_camera_.cross(motion.turn)),
        corrected_(observation.inverse_depth + calibration.field.At(ray_.x(), ray_.y())),
        inverse_sigma_(observation.inverse_sigma),
        along_ray_(normal_at_row_.dot(ray_)),
        from_camera_(surfel.normal_in_world.dot(surfel.point_in_world - translation) -
                     later_ * normal_in_camera_.dot(motion.way)) {}

  // Residual r(d), and its derivative by d (1/m).
  double Residual(double displacement) const {
    return (corrected_ - PlaneInverse(displacement)) * inverse_sigma_;
  }
  double ByDisplacement(double displacement) const {
    return PlaneInverse(displacement) / (from_camera_ + displacement) * inverse_sigma_;
  }
  // Distance of the measured point from the plane along its normal, m. Positive: the point is in
  // front.
  double Distance(double displacement) const {
    return (along_ray_ / corrected_) - (from_camera_ + displacement);
  }

  // Derivatives, with D for D + d, and with m = n + dT n x turn because n . e = m . ray:
  //   dr/dw = -(R (ray + dT flow) x n) / D,  dr/dv = -1/z_plane n / D,
  //   dr/dx = dc/dx - m_x / D, dx/dfx = -x / fx, dx/dcx = -1 / fx,
  //   dr/dT = -(n . flow) / D, flow = turn x ray + way / z_plane.
  // n is in the camera frame in the last two lines.
  JointRow Row(double displacement, const Eigen::Vector3d& normal_in_world,
               const Eigen::Matrix3d& rotation, const DepthCalibration& calibration) const {
    const double inverse_distance = 1 / (from_camera_ + displacement);
    const double x = ray_.x(), y = ray_.y();
    const auto& c = calibration.field.coefficients;
    const double by_x = c[1] + 2 * c[3] * x + c[4] * y - normal_at_row_.x() * inverse_distance;
    const double by_y = c[2] + c[4] * x + 2 * c[5] * y - normal_at_row_.y() * inverse_distance;
    const Eigen::Vector3d flow =
        motion_.turn.cross(ray_) + PlaneInverse(displacement) * motion_.way;
    const PinholeCamera& camera = calibration.camera;
    JointRow row;
    row.residual = Residual(displacement);
    row.by_pose << (rotation * (ray_ + later_ * flow)).cross(normal_in_world),
        PlaneInverse(displacement) * normal_in_world;
    row.by_pose *= -inverse_distance * inverse_sigma_;
    row.by_calibration << -by_x * x / camera.fx, -by_y * y / camera.fy, -by_x / camera.fx,
        -by_y / camera.fy, 1, x, y, x * x, x * y, y * y,
        -normal_in_camera_.dot(flow) * inverse_distance;
    row.by_calibration *= inverse_sigma_;
    row.by_displacement = ByDisplacement(displacement);
    return row;
  }

 private:
  double PlaneInverse(double displacement) const {
    return along_ray_ / (from_camera_ + displacement);
  }

  RowMotion motion_;
  double later_;  // dT, s
  Eigen::Vector3d ray_, normal_in_camera_, normal_at_row_;
  double corrected_, inverse_sigma_;
  double along_ray_, from_camera_;  // N, D
};

// Camera motion at the row of an observation, see RowMotion. `rows`: image height.
inline RowMotion MotionOf(const PlaneObservation& observation, const KeyframeReadout& readout,
                          int rows) {
  const double share = (observation.v + 0.5) / rows - 0.5;
  return {share * readout.motion.angular_velocity_rad_per_s,
          share * readout.motion.velocity_m_per_s, readout.readout_s};
}

// Analytic version of SurfelTexture for one observation. Keeps references to the taps and to the
// camera.
class TextureResidual {
 public:
  TextureResidual(const TextureObservation& observation, const SharedSurfel& surfel,
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

  // Measured intensity differences between the points beside the surfel and its centre, in standard
  // deviations. Intensities are linear around the taps.
  Eigen::Vector2d Differences(double displacement) const {
    const double center = Intensity(0, displacement);
    return inverse_sigma_ * Eigen::Vector2d(Intensity(1, displacement) - center,
                                            Intensity(2, displacement) - center);
  }
  Eigen::Vector2d Residuals(const SurfelParameters& surfel) const {
    return Differences(surfel.displacement) - surfel.texture;
  }
  double inverse_sigma() const { return inverse_sigma_; }

  // Residuals with derivatives. With the gradient g of the intensity by the point in the camera
  // frame (IntensityGradient()):
  //   dI/dw = R g x (p + d n - t),  dI/dv = -R g,  dI/dd = g . R^T n,
  //   dI/dfx = I_u x / z,  dI/dcx = I_u.
  std::array<JointRow, 2> Rows(const SurfelParameters& surfel,
                               const Eigen::Vector3d& normal_in_world,
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
  // Derivatives of Differences() by the displacement, 1/m.
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
        tap.slope_v, 0, 0, 0, 0, 0, 0, 0;
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
