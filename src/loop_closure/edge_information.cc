#include "loop_closure/edge_information.h"

#include <Eigen/Cholesky>

#include "surfit/registration/normal_system.h"

namespace surfit {
namespace {

// prior standard deviations of unobservable directions
constexpr double kLooseM = 0.1, kLooseRad = 0.1;

Matrix6d InverseOf(const Matrix6d& symmetric) {
  const Matrix6d inverse = symmetric.llt().solve(Matrix6d::Identity());
  return 0.5 * (inverse + inverse.transpose());
}

Matrix6d CovarianceOf(const Matrix6d& information) {
  return InverseOf(information + InverseOf(Variances(kLooseRad, kLooseM)));
}

Matrix6d InformationOf(const IcpResult& icp) {
  return icp.covariance ? InverseOf(*icp.covariance) : icp.information;
}

}  // namespace

// Information of the odometry edge between keyframes a and b. The map was rendered near pose b,
// so the registration covariance is in the frame of b. `icp`: last registration, which represents
// all registrations between the keyframes.
Matrix6d OdometryInformation(const IcpResult& icp, int frames, const Rigid3d& a_from_b,
                             const EdgeNoise& noise) {
  const Matrix6d transform = IncrementTransform(a_from_b);
  const double turn_rad = RotationAngle(a_from_b.rotation), way_m = a_from_b.translation.norm();
  const Matrix6d of_registrations =
      CovarianceOf(InformationOf(icp) / (noise.shared_points * frames));
  return InverseOf(transform * of_registrations * transform.transpose() +
                   Variances(noise.odometry_rad + noise.odometry_ratio * turn_rad,
                             noise.odometry_m + noise.odometry_ratio * way_m));
}

// The map was rendered near pose b, so the registration covariance is in the frame of b.
Matrix6d RelocalizationInformation(const IcpResult& icp, const Rigid3d& a_from_b,
                                   const EdgeNoise& noise) {
  const Matrix6d transform = IncrementTransform(a_from_b);
  const Matrix6d of_registration = CovarianceOf(InformationOf(icp) / noise.shared_points);
  return InverseOf(transform * of_registration * transform.transpose() +
                   Variances(noise.loop_rad, noise.loop_m));
}

Matrix6d LoopInformation(const Matrix6d& registration_information, const EdgeNoise& noise) {
  return InverseOf(CovarianceOf(registration_information) +
                   Variances(noise.loop_rad, noise.loop_m));
}

}  // namespace surfit
