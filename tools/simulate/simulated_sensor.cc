#include "simulate/simulated_sensor.h"

#include <algorithm>
#include <cmath>

#include "surfit/core/error.h"

namespace surfit::tools {

// In the order of SimulatedSensor::Model.
std::vector<std::string> SensorNames() { return {"ideal", "kinect", "lidar", "stereo", "tof"}; }

SimulatedSensor::SimulatedSensor(const std::string& name) {
  const std::vector<std::string> names = SensorNames();
  const auto found = std::find(names.begin(), names.end(), name);
  ThrowIf(found == names.end(), "sensor is '", name,
          "', must be ideal, kinect, lidar, stereo or tof");
  model_ = static_cast<Model>(found - names.begin());
}

PinholeCamera SimulatedSensor::camera() const {
  if (model_ == Model::kLidar) return {256, 192, 180.3, 180.3, 127.5, 95.5, {}};
  return {640, 480, 525, 525, 319.5, 239.5, {}};
}

SensorImage SimulatedSensor::Measure(const Rendering& exact, const PinholeCamera& camera,
                                     std::uint64_t seed) const {
  switch (model_) {
    case Model::kKinect:
      return {KinectDepth(exact.depth_m, camera, seed), {}, {}};
    case Model::kLidar:
      return LidarDepth(exact, camera, seed);
    case Model::kStereo:
      return StereoDepth(exact, camera, seed);
    case Model::kTof:
      return TofDepth(exact, camera, seed);
    case Model::kIdeal:
      break;
  }
  return {exact.depth_m, {}, {}};
}

void MeanNoise::Add(const SensorImage& image) {
  for (const float sigma : image.inverse_depth_sigma) {
    squares_ += static_cast<double>(sigma) * sigma;
    if (sigma > 0) ++count_;
  }
}

double MeanNoise::Sigma() const {
  if (squares_ == 0) return 0;
  const double sigma = std::sqrt(squares_ / count_);
  const double digit = std::pow(10., std::floor(std::log10(sigma)) - 3);
  return std::round(sigma / digit) * digit;
}

}  // namespace surfit::tools
