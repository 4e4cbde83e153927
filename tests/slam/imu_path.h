#pragma once

#include <cmath>
#include <optional>
#include <random>
#include <vector>

#include "surfit/simulation/camera_path.h"
#include "tracking/inertial/imu_filter.h"

namespace surfit::testing {

// Hand-held camera path of `seconds` with rotations about all axes, at 30 poses per second. The
// world has z up.
inline SmoothPath SwungCamera(double seconds, double size = 1) {
  Trajectory poses;
  for (int i = 0; i <= seconds * 30; ++i) {
    const double t = i / 30.;
    const Eigen::Vector3d turn(0.35 * std::sin(2.3 * t), 0.4 * std::sin(1.7 * t + 1),
                               0.3 * std::sin(2.9 * t + 2));
    const Eigen::Vector3d place(0.3 * std::sin(1.9 * t), 0.25 * std::cos(1.3 * t),
                                0.2 * std::sin(2.4 * t + 1));
    // The camera looks along x, with z up, before it turns.
    const Eigen::Quaterniond level(0.5, -0.5, 0.5, -0.5);
    poses.push_back({t,
                     {level * QuaternionExp<double>(Eigen::Vector3d(size * turn)),
                      Eigen::Vector3d(size * place)}});
  }
  return SmoothPath(poses);
}

inline Rigid3d ImuMount() {
  return {QuaternionExp<double>(Eigen::Vector3d(0.3, -2, 1)), {0.03, -0.02, 0.04}};
}

// Pose with independent errors per axis.
inline RegisteredPose NoisyPose(const Rigid3d& exact, double stamp_s, double sigma_rad,
                                double sigma_m, std::mt19937_64* rng) {
  std::normal_distribution<double> normal;
  Vector6d error;
  for (int k = 0; k < 6; ++k) error[k] = (k < 3 ? sigma_rad : sigma_m) * normal(*rng);
  RegisteredPose pose;
  pose.stamp_s = stamp_s;
  pose.world_from_camera = exact * LeftIncrement<double>(error, Rigid3d());
  for (int k = 0; k < 6; ++k) pose.covariance(k, k) = std::pow(k < 3 ? sigma_rad : sigma_m, 2);
  return pose;
}

inline RegisteredPose NoisyPose(const SmoothPath& path, double stamp_s, double sigma_rad,
                                double sigma_m, std::mt19937_64* rng) {
  return NoisyPose(path.At(stamp_s), stamp_s, sigma_rad, sigma_m, rng);
}

// Map that drifts along a path as MapDrift() describes.
class DriftingMap {
 public:
  DriftingMap(const SmoothPath& path, std::mt19937_64* rng) : path_(path), rng_(rng) {}

  // Pose of the camera in the map. The times ascend.
  Rigid3d At(double stamp_s) {
    if (!last_s_) map_from_camera_ = path_.At(stamp_s);
    if (last_s_) {
      std::normal_distribution<double> normal;
      Vector6d drift = MapDrift(stamp_s - *last_s_).diagonal().cwiseSqrt();
      for (double& component : drift) component *= normal(*rng_);
      map_from_camera_ = map_from_camera_ * (path_.At(*last_s_).Inverse() * path_.At(stamp_s)) *
                         LeftIncrement<double>(drift, Rigid3d());
    }
    last_s_ = stamp_s;
    return map_from_camera_;
  }

 private:
  SmoothPath path_;
  std::mt19937_64* rng_;
  std::optional<double> last_s_;
  Rigid3d map_from_camera_;
};

}  // namespace surfit::testing
