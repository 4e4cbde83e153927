#include <cmath>

#include "simulation/random.h"
#include "surfit/core/error.h"
#include "surfit/simulation/camera_path.h"

namespace surfit {
namespace {

// Exact measurement at a time of the path.
ImuSample MeasureImu(const SmoothPath& path, const Rigid3d& camera_from_imu, double stamp_s) {
  const Eigen::Vector3d gravity(0, 0, -kGravity_m_per_s2);
  const PathMotion motion = path.MotionAt(stamp_s);
  const Eigen::Quaterniond camera_from_world = path.At(stamp_s).rotation.conjugate();
  const Eigen::Quaterniond imu_from_camera = camera_from_imu.rotation.conjugate();
  const Eigen::Vector3d &rate = motion.rate_rad_per_s, &arm = camera_from_imu.translation;
  // Acceleration of the sensor minus gravity, in the camera frame.
  const Eigen::Vector3d force =
      camera_from_world * Eigen::Vector3d(motion.acceleration_m_per_s2 - gravity) +
      motion.rate_change_rad_per_s2.cross(arm) + rate.cross(rate.cross(arm));
  return {stamp_s, imu_from_camera * rate, imu_from_camera * force};
}

}  // namespace

std::vector<ImuSample> SimulateImu(const SmoothPath& path, const ImuSimulation& simulation) {
  const double rate_hz = simulation.rate_hz;
  ThrowIf(!(rate_hz >= 1 && rate_hz <= 10000), "rate of the inertial sensor is ", rate_hz,
          ", must be from 1 to 10000 (Hz)");
  const ImuCalibration& calibration = simulation.calibration;
  const ImuNoise& noise = calibration.noise;
  noise.Validate("inertial sensor");
  Random numbers(simulation.seed);
  const auto random = [&]() -> Eigen::Vector3d {
    const double x = numbers.Normal(), y = numbers.Normal(), z = numbers.Normal();
    return {x, y, z};
  };
  const double scale = simulation.has_errors ? 1 : 0;
  ImuBias bias;
  bias.gyro_rad_per_s = scale * noise.gyro_bias_sigma * random();
  bias.accel_m_per_s2 = scale * noise.accel_bias_sigma * random();
  const double begin_s = path.poses().front().stamp_s;
  const double duration_s = path.poses().back().stamp_s - begin_s;
  const double root_rate = std::sqrt(rate_hz);
  std::vector<ImuSample> samples;
  for (int i = 0; i <= duration_s * rate_hz; ++i) {
    ImuSample sample = MeasureImu(path, calibration.camera_from_imu, begin_s + i / rate_hz);
    sample.stamp_s += calibration.time_offset_s;
    sample.gyro_rad_per_s +=
        bias.gyro_rad_per_s + scale * noise.gyro_density * root_rate * random();
    sample.accel_m_per_s2 +=
        bias.accel_m_per_s2 + scale * noise.accel_density * root_rate * random();
    samples.push_back(sample);
    bias.gyro_rad_per_s += scale * noise.gyro_bias_density / root_rate * random();
    bias.accel_m_per_s2 += scale * noise.accel_bias_density / root_rate * random();
  }
  return samples;
}

}  // namespace surfit
