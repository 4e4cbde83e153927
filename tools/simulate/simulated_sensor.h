#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "surfit/geometry/pinhole_camera.h"
#include "surfit/simulation/render.h"

namespace surfit::tools {

// Values of --sensor: ideal, kinect, lidar, stereo, tof.
std::vector<std::string> SensorNames();

// Sensor with the default options of its model.
class SimulatedSensor {
 public:
  // Throws InputError for an unknown name.
  explicit SimulatedSensor(const std::string& name);

  // Camera of the sensor. Lidar: 256 x 192 px with the focal length of an iPhone. Others: 640 x 480
  // px with the focal length of 525 px.
  PinholeCamera camera() const;
  bool HasConfidence() const { return model_ == Model::kLidar; }
  // False for ideal and kinect, which keep the default noise of camera.yaml.
  bool HasKnownNoise() const { return model_ != Model::kIdeal && model_ != Model::kKinect; }

  // Measures a rendering. `inverse_depth_sigma` is empty without known noise, `confidence` is empty
  // without confidence.
  SensorImage Measure(const Rendering& exact, const PinholeCamera& camera,
                      std::uint64_t seed) const;

 private:
  enum class Model { kIdeal, kKinect, kLidar, kStereo, kTof };

  Model model_;
};

// Root mean square of SensorImage::inverse_depth_sigma over the measured pixels, 1/m.
class MeanNoise {
 public:
  void Add(const SensorImage& image);
  // Rounded to four digits. 0 without a measured pixel.
  double Sigma() const;

 private:
  double squares_ = 0, count_ = 0;
};

}  // namespace surfit::tools
