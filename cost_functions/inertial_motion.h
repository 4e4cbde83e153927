#pragma once

#include <ceres/sized_cost_function.h>

#include <Eigen/Cholesky>

#include "cost_functions/analytic_relative_pose.h"
#include "surfit/geometry/inertial.h"

namespace surfit {

// Parameter block of a motion: velocity of the inertial sensor in the world frame [m/s], gyroscope
// bias [rad/s], accelerometer bias [m/s^2].
inline constexpr int kMotionSize = 9;
inline constexpr int kInertialResiduals = 15;

// Preintegrated motion of an inertial sensor between the times i and j, 15 residuals (Forster,
// Carlone, Dellaert and Scaramuzza 2017, eq. 45 and 48). The parameter blocks are
//   pose i (pose.h), motion i (kMotionSize), pose j, motion j, gravity [m/s^2, world frame].
// The length of gravity can be fixed by ceres::SphereManifold<3>. With the pose Q of the body, the
// constant P = body_from_imu, and (R, p) = Q P, the velocity v, the biases b, and T = duration_s:
//   r_R = log(D_R^T R_i^T R_j)                                D_R = rotation exp(J_R db)
//   r_p = R_i^T (p_j - p_i - v_i T - g T^2 / 2) - D_p         D_p = position + J_p db
//   r_v = R_i^T (v_j - v_i - g T) - D_v                       D_v = velocity + J_v db
//   r_b = b_j - b_i                                           db = b_i - bias of the integration
// J is PreintegratedImu::bias_jacobian. The residuals are U (r_R, r_p, r_v, r_b) in standard
// deviations, with U^T U = covariance^-1. The order and the frame of the errors are those of
// PreintegratedImu.
class InertialMotion {
 public:
  using Root = Eigen::Matrix<double, kInertialResiduals, kInertialResiduals>;

  // Requires a positive duration.
  explicit InertialMotion(const PreintegratedImu& motion, const Rigid3d& body_from_imu = {})
      : motion_(motion), body_from_imu_(body_from_imu), root_(RootOf(motion.covariance)) {}

  template <typename T>
  bool operator()(const T* pose_i, const T* motion_i, const T* pose_j, const T* motion_j,
                  const T* gravity, T* residuals) const {
    using Vector3 = Eigen::Matrix<T, 3, 1>;
    using Map3 = Eigen::Map<const Vector3>;
    const Rigid3<T> i = PoseFromBlock(pose_i) * body_from_imu_.cast<T>();
    const Rigid3<T> j = PoseFromBlock(pose_j) * body_from_imu_.cast<T>();
    const Map3 v_i(motion_i), v_j(motion_j), g(gravity);
    Eigen::Matrix<T, 6, 1> bias;
    for (int k = 0; k < 6; ++k) bias[k] = motion_i[3 + k] - bias_of_integration()[k];
    const Eigen::Matrix<T, 9, 1> correction = motion_.bias_jacobian.cast<T>() * bias;
    const Eigen::Quaternion<T> rotation =
        motion_.rotation.cast<T>() * QuaternionExp<T>(Vector3(correction.template head<3>()));
    const Eigen::Quaternion<T> world_to_i = i.rotation.conjugate();
    const T seconds(motion_.duration_s);
    Eigen::Matrix<T, kInertialResiduals, 1> r;
    r.template segment<3>(0) = QuaternionLog<T>(rotation.conjugate() * (world_to_i * j.rotation));
    r.template segment<3>(3) = world_to_i * Vector3(j.translation - i.translation - v_i * seconds -
                                                    g * (seconds * seconds / T(2))) -
                               motion_.position_m.cast<T>() - correction.template segment<3>(3);
    r.template segment<3>(6) = world_to_i * Vector3(v_j - v_i - g * seconds) -
                               motion_.velocity_m_per_s.cast<T>() -
                               correction.template segment<3>(6);
    for (int k = 0; k < 6; ++k) r[9 + k] = motion_j[3 + k] - motion_i[3 + k];
    Eigen::Map<Eigen::Matrix<T, kInertialResiduals, 1>> whitened(residuals);
    whitened = root_.cast<T>() * r;
    return true;
  }

  const PreintegratedImu& motion() const { return motion_; }
  const Rigid3d& body_from_imu() const { return body_from_imu_; }
  const Root& root() const { return root_; }

 private:
  // U = L^-1 of the Cholesky factor covariance = L L^T.
  static Root RootOf(const Root& covariance) {
    return Eigen::LLT<Root>(covariance).matrixL().solve(Root::Identity());
  }
  Eigen::Matrix<double, 6, 1> bias_of_integration() const {
    Eigen::Matrix<double, 6, 1> bias;
    bias << motion_.bias.gyro_rad_per_s, motion_.bias.accel_m_per_s2;
    return bias;
  }

  PreintegratedImu motion_;
  Rigid3d body_from_imu_;
  Root root_;
};

// InertialMotion with analytic derivatives. With the perturbations Q_R -> exp(w) Q_R, Q_t -> Q_t +
// t of ProductPoseManifold, the arm a = Q_R P_t, x = p_j - p_i - v_i T - g T^2 / 2 and y = v_j -
// v_i - g T:
//   dr_R/dw_j = K R_j^T = -dr_R/dw_i,              K = InverseLeftJacobian(-r_R)
//   dr_R/db_i = -L Jr J_R,                         L = InverseLeftJacobian(r_R)
//   dr_p/dw_i = R_i^T [x + a_i]x,   dr_p/dw_j = -R_i^T [a_j]x,   dr_p/dt_j = R_i^T = -dr_p/dt_i
//   dr_p/dv_i = -R_i^T T,           dr_p/dg = -R_i^T T^2 / 2,    dr_p/db_i = -J_p
//   dr_v/dw_i = R_i^T [y]x,         dr_v/dv_j = R_i^T = -dr_v/dv_i
//   dr_v/dg = -R_i^T T,             dr_v/db_i = -J_v
//   dr_b/db_j = I = -dr_b/db_i
// Jr is the right Jacobian of SO(3) at J_R db: exp(J_R db + d) = exp(J_R db) exp(Jr d).
class AnalyticInertialMotion final
    : public ceres::SizedCostFunction<kInertialResiduals, kPoseSize, kMotionSize, kPoseSize,
                                      kMotionSize, 3> {
 public:
  explicit AnalyticInertialMotion(const PreintegratedImu& motion, const Rigid3d& body_from_imu = {})
      : residual_(motion, body_from_imu) {}

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    residual_(blocks[0], blocks[1], blocks[2], blocks[3], blocks[4], residuals);
    if (jacobians == nullptr) return true;
    const At at(residual_, blocks);
    if (jacobians[0] != nullptr) FillPose(at.ByPoseI(), blocks[0], jacobians[0]);
    if (jacobians[1] != nullptr) Fill<kMotionSize>(at.ByMotionI(), jacobians[1]);
    if (jacobians[2] != nullptr) FillPose(at.ByPoseJ(), blocks[2], jacobians[2]);
    if (jacobians[3] != nullptr) Fill<kMotionSize>(at.ByMotionJ(), jacobians[3]);
    if (jacobians[4] != nullptr) Fill<3>(at.ByGravity(), jacobians[4]);
    return true;
  }

 private:
  template <int kColumns>
  using Columns = Eigen::Matrix<double, kInertialResiduals, kColumns>;
  using Vector3d = Eigen::Vector3d;
  using Matrix3d = Eigen::Matrix3d;

  // Values at the linearisation point, and the derivatives before whitening.
  struct At {
    At(const InertialMotion& residual, double const* const* blocks) : motion(residual.motion()) {
      const Rigid3d body_i = PoseFromBlock(blocks[0]), body_j = PoseFromBlock(blocks[2]);
      const Rigid3d i = body_i * residual.body_from_imu(), j = body_j * residual.body_from_imu();
      const Eigen::Map<const Vector3d> v_i(blocks[1]), v_j(blocks[3]), gravity(blocks[4]);
      const Eigen::Map<const Vector3d> gyro_bias(blocks[1] + 3);
      seconds = motion.duration_s;
      i_from_world = i.rotation.conjugate().toRotationMatrix();
      j_from_world = j.rotation.conjugate().toRotationMatrix();
      arm_i = body_i.rotation * residual.body_from_imu().translation;
      arm_j = body_j.rotation * residual.body_from_imu().translation;
      x = j.translation - i.translation - v_i * seconds - gravity * (seconds * seconds / 2);
      y = v_j - v_i - gravity * seconds;
      bias_turn =
          motion.bias_jacobian.topLeftCorner<3, 3>() * (gyro_bias - motion.bias.gyro_rad_per_s);
      error =
          QuaternionLog<double>((motion.rotation * QuaternionExp<double>(bias_turn)).conjugate() *
                                (i.rotation.conjugate() * j.rotation));
    }

    Columns<6> ByPoseI() const {
      Columns<6> d = Columns<6>::Zero();
      d.block<3, 3>(0, 0) = -InverseLeftJacobian(-error) * j_from_world;
      d.block<3, 3>(3, 0) = i_from_world * CrossMatrix<double>(x + arm_i);
      d.block<3, 3>(3, 3) = -i_from_world;
      d.block<3, 3>(6, 0) = i_from_world * CrossMatrix<double>(y);
      return d;
    }
    Columns<6> ByPoseJ() const {
      Columns<6> d = Columns<6>::Zero();
      d.block<3, 3>(0, 0) = InverseLeftJacobian(-error) * j_from_world;
      d.block<3, 3>(3, 0) = -i_from_world * CrossMatrix<double>(arm_j);
      d.block<3, 3>(3, 3) = i_from_world;
      return d;
    }
    Columns<kMotionSize> ByMotionI() const {
      Columns<kMotionSize> d = Columns<kMotionSize>::Zero();
      d.block<3, 3>(3, 0) = -seconds * i_from_world;
      d.block<3, 3>(6, 0) = -i_from_world;
      // The right Jacobian at w is the inverse of InverseLeftJacobian(-w).
      d.block<3, 3>(0, 3) = -InverseLeftJacobian(error) *
                            InverseLeftJacobian(-bias_turn).inverse() *
                            motion.bias_jacobian.topLeftCorner<3, 3>();
      d.block<6, 6>(3, 3) = -motion.bias_jacobian.bottomRows<6>();
      d.block<6, 6>(9, 3) = -Eigen::Matrix<double, 6, 6>::Identity();
      return d;
    }
    Columns<kMotionSize> ByMotionJ() const {
      Columns<kMotionSize> d = Columns<kMotionSize>::Zero();
      d.block<3, 3>(6, 0) = i_from_world;
      d.block<6, 6>(9, 3).setIdentity();
      return d;
    }
    Columns<3> ByGravity() const {
      Columns<3> d = Columns<3>::Zero();
      d.block<3, 3>(3, 0) = -seconds * seconds / 2 * i_from_world;
      d.block<3, 3>(6, 0) = -seconds * i_from_world;
      return d;
    }

    const PreintegratedImu& motion;
    double seconds = 0;
    Matrix3d i_from_world, j_from_world;
    Vector3d arm_i, arm_j, x, y, bias_turn, error;
  };

  template <int kColumns>
  void Fill(const Columns<kColumns>& derivative, double* jacobian) const {
    Eigen::Map<Eigen::Matrix<double, kInertialResiduals, kColumns, Eigen::RowMajor>> j(jacobian);
    j = residual_.root() * derivative;
  }

  // Converts derivatives by (w, t) to derivatives by the pose block. See AnalyticRelativePose.
  void FillPose(const Columns<6>& derivative, const double* pose, double* jacobian) const {
    const Columns<6> whitened = residual_.root() * derivative;
    const Vector3d u(pose[0], pose[1], pose[2]);
    Eigen::Map<Eigen::Matrix<double, kInertialResiduals, kPoseSize, Eigen::RowMajor>> j(jacobian);
    j.leftCols<3>() =
        2 * whitened.leftCols<3>() * (pose[3] * Matrix3d::Identity() + CrossMatrix<double>(u));
    j.col(3) = -2 * whitened.leftCols<3>() * u;
    j.rightCols<3>() = whitened.rightCols<3>();
  }

  InertialMotion residual_;
};

}  // namespace surfit
