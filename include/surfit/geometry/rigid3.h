#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace surfit {

inline constexpr double kRadPerDeg = 3.14159265358979323846 / 180;

// Skew-symmetric matrix [v]x with [v]x w = v x w.
template <typename Scalar>
Eigen::Matrix<Scalar, 3, 3> CrossMatrix(const Eigen::Matrix<Scalar, 3, 1>& v) {
  Eigen::Matrix<Scalar, 3, 3> m;
  m << Scalar(0), -v.z(), v.y(), v.z(), Scalar(0), -v.x(), -v.y(), v.x(), Scalar(0);
  return m;
}

// Unit quaternion exp(w) of a rotation vector w in rad: q = [cos(|w|/2), sin(|w|/2) w/|w|]. Values
// and derivatives (ceres::Jet) are also accurate near zero.
template <typename Scalar>
Eigen::Quaternion<Scalar> QuaternionExp(const Eigen::Matrix<Scalar, 3, 1>& w) {
  using std::cos;
  using std::sin;
  using std::sqrt;
  const Scalar angle2 = w.squaredNorm();
  Scalar real, scale;
  if (angle2 < Scalar(1e-8)) {
    real = Scalar(1) - angle2 / Scalar(8) + angle2 * angle2 / Scalar(384);
    scale = Scalar(0.5) - angle2 / Scalar(48) + angle2 * angle2 / Scalar(3840);
  } else {
    const Scalar angle = sqrt(angle2);
    real = cos(angle / Scalar(2));
    scale = sin(angle / Scalar(2)) / angle;
  }
  return Eigen::Quaternion<Scalar>(real, scale * w.x(), scale * w.y(), scale * w.z());
}

// Rotation vector w in rad, |w| <= pi, of a unit quaternion: exp(w) = q or -q, the same rotation.
// At |w| = pi, w or -w.
template <typename Scalar>
Eigen::Matrix<Scalar, 3, 1> QuaternionLog(const Eigen::Quaternion<Scalar>& q) {
  using std::atan2;
  using std::sqrt;
  const Scalar sign = q.w() < Scalar(0) ? Scalar(-1) : Scalar(1);
  const Eigen::Matrix<Scalar, 3, 1> v = sign * q.vec();
  const Scalar real = sign * q.w();
  const Scalar norm2 = v.squaredNorm();
  if (norm2 < Scalar(1e-10)) {
    return v * (Scalar(2) / real - Scalar(2) * norm2 / (Scalar(3) * real * real * real));
  }
  const Scalar norm = sqrt(norm2);
  return v * (Scalar(2) * atan2(norm, real) / norm);
}

// Rigid transform target_from_source: x_target = rotation * x_source + translation (m). The default
// is the identity. The quaternion must have unit length, which is not checked. Products normalise
// it.
template <typename Scalar>
struct Rigid3 {
  using Vector3 = Eigen::Matrix<Scalar, 3, 1>;
  using Vector6 = Eigen::Matrix<Scalar, 6, 1>;

  Eigen::Quaternion<Scalar> rotation = Eigen::Quaternion<Scalar>::Identity();
  Vector3 translation = Vector3::Zero();

  Rigid3() = default;
  Rigid3(const Eigen::Quaternion<Scalar>& r, const Vector3& t) : rotation(r), translation(t) {}
  // Requires a rotation matrix, which is not checked. Normalises its quaternion.
  Rigid3(const Eigen::Matrix<Scalar, 3, 3>& r, const Vector3& t)
      : rotation(Eigen::Quaternion<Scalar>(r).normalized()), translation(t) {}

  // source_from_target
  Rigid3 Inverse() const {
    const Eigen::Quaternion<Scalar> r = rotation.conjugate();
    return Rigid3(r, -(r * translation));
  }
  Vector3 operator*(const Vector3& x) const { return rotation * x + translation; }
  Rigid3 operator*(const Rigid3& other) const {
    return Rigid3((rotation * other.rotation).normalized(),
                  rotation * other.translation + translation);
  }
  // Homogeneous matrix [R t; 0 1].
  Eigen::Matrix<Scalar, 4, 4> Matrix() const {
    Eigen::Matrix<Scalar, 4, 4> m = Eigen::Matrix<Scalar, 4, 4>::Identity();
    m.template topLeftCorner<3, 3>() = rotation.toRotationMatrix();
    m.template topRightCorner<3, 1>() = translation;
    return m;
  }
  template <typename Other>
  Rigid3<Other> cast() const {
    return Rigid3<Other>(rotation.template cast<Other>(), translation.template cast<Other>());
  }
  // Compares coefficients: q and -q differ, although they are the same rotation.
  bool operator==(const Rigid3& other) const {
    return translation == other.translation && rotation.coeffs() == other.rotation.coeffs();
  }
};

using Rigid3d = Rigid3<double>;
using Rigid3f = Rigid3<float>;

// Applies the left perturbation (w [rad], v [m]): x -> exp(w) (R x + t) + v. The pose becomes
// (exp(w) R, exp(w) t + v). Normalises the rotation.
template <typename Scalar>
Rigid3<Scalar> LeftIncrement(const typename Rigid3<Scalar>::Vector6& increment,
                             const Rigid3<Scalar>& pose) {
  const Eigen::Matrix<Scalar, 3, 1> w = increment.template head<3>();
  const Rigid3<Scalar> delta(QuaternionExp<Scalar>(w), increment.template tail<3>());
  return delta * pose;
}

// Increment (w [rad], v [m]) with LeftIncrement(increment, from) = to, up to rounding. |w| <= pi. v
// is the translation of to from^-1, which equals the translation part of the SE(3) logarithm to
// first order.
template <typename Scalar>
typename Rigid3<Scalar>::Vector6 FirstOrderIncrement(const Rigid3<Scalar>& from,
                                                     const Rigid3<Scalar>& to) {
  const Rigid3<Scalar> moved = to * from.Inverse();
  typename Rigid3<Scalar>::Vector6 increment;
  increment << QuaternionLog<Scalar>(moved.rotation), moved.translation;
  return increment;
}

// Adjoint of a_from_b: maps left perturbations (w, v) of b_from_c to those of a_from_c to first
// order, w' = R w, v' = R v + t x R w.
template <typename Scalar>
Eigen::Matrix<Scalar, 6, 6> IncrementTransform(const Rigid3<Scalar>& a_from_b) {
  const Eigen::Matrix<Scalar, 3, 3> rotation = a_from_b.rotation.toRotationMatrix();
  Eigen::Matrix<Scalar, 6, 6> transform = Eigen::Matrix<Scalar, 6, 6>::Zero();
  transform.template topLeftCorner<3, 3>() = rotation;
  transform.template bottomRightCorner<3, 3>() = rotation;
  transform.template bottomLeftCorner<3, 3>() =
      CrossMatrix<Scalar>(a_from_b.translation) * rotation;
  return transform;
}

// Rotation angle in rad, in [0, pi], of a unit quaternion. Its derivative (ceres::Jet) is not
// finite at the identity.
template <typename Scalar>
Scalar RotationAngle(const Eigen::Quaternion<Scalar>& q) {
  return QuaternionLog<Scalar>(q).norm();
}

}  // namespace surfit
