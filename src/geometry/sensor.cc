#include "surfit/geometry/sensor.h"

#include <cmath>

#include "surfit/core/error.h"
#include "surfit/core/options.h"

namespace surfit {

void DepthNoise::Visit(OptionVisitor& v) {
  v.Add(inverse_depth_sigma, "inverse_depth_sigma",
        "noise of the depth sensor: standard deviation of inverse depth", AtLeast(0), Below(1),
        InUnit("1/m"), AsFlag());
}

// Filters and depth edges are measured in sigmas: none is too few.
void DepthNoise::Validate(const std::string& what) const {
  if (!(inverse_depth_sigma > 0 && inverse_depth_sigma < 1)) {
    throw InputError(Concat(what, ": inverse_depth_sigma is ", inverse_depth_sigma,
                            ", must be positive and below 1 (1/m)"));
  }
}

void DepthSensor::Validate() const {
  camera.Validate("camera");
  noise.Validate("sensor");
  if (!(readout_s >= 0 && readout_s <= 1)) {
    throw InputError(Concat("sensor: readout_s is ", readout_s, ", must be from 0 to 1 (s)"));
  }
}

void RgbdCamera::Validate(const std::string& what) const {
  depth.Validate(what + ": depth camera");
  if (!color_is_registered) color.Validate(what + ": color camera");
  const auto positive = [&](const char* field, double value) {
    if (!(std::isfinite(value) && value > 0)) {
      throw InputError(Concat(what, ": ", field, " is ", value, ", must be finite and positive"));
    }
  };
  positive("depth_units_per_metre", depth_units_per_metre);
  noise.Validate(what);
  positive("frames_per_second", frames_per_second);
  if (!(std::abs(latency_s) <= 1)) {
    throw InputError(Concat(what, ": latency_s is ", latency_s, ", must be from -1 to 1 (s)"));
  }
  if (!(readout_s >= 0 && readout_s <= 1)) {
    throw InputError(Concat(what, ": readout_s is ", readout_s, ", must be from 0 to 1 (s)"));
  }
  if (!color_from_depth.translation.allFinite() ||
      !color_from_depth.rotation.coeffs().allFinite()) {
    throw InputError(Concat(what, ": color_from_depth must be finite"));
  }
}

}  // namespace surfit
