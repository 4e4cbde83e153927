#include "surfit/geometry/sensor.h"

#include <cmath>

#include "core/shared_options.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"

namespace surfit {

void DepthNoise::Visit(OptionVisitor& v) {
  v.Add(inverse_depth_sigma, SharedOption("inverse_depth_sigma"));
}

// Thresholds are multiples of inverse_depth_sigma, so its value must not be 0.
void DepthNoise::Validate(const std::string& what) const {
  ThrowIf(!(inverse_depth_sigma > 0 && inverse_depth_sigma < 1), what, ": inverse_depth_sigma is ",
          inverse_depth_sigma, ", must be positive and below 1 (1/m)");
}

void CalibrationPrior::Visit(OptionVisitor& v) {
  v.Add(focal_relative_sigma, "focal_relative_sigma",
        "standard deviation of fx and fy, relative to the input value", ZeroIs("unknown"));
  v.Add(aspect_relative_sigma, "aspect_relative_sigma",
        "standard deviation of fx / fy, relative to the input value", ZeroIs("unknown"));
  v.Add(center_px, "center_px", "standard deviation of cx and cy", ZeroIs("unknown"), InUnit("px"));
  v.Add(inverse_depth_sigma, "inverse_depth_sigma",
        "standard deviation of the correction of inverse depth", ZeroIs("unknown"), InUnit("1/m"));
  v.Add(latency_s, "latency_s", "standard deviation of the latency of depth, s", ZeroIs("unknown"));
  v.Add(color_latency_s, "color_latency_s",
        "standard deviation of the additional latency of colour, s", ZeroIs("unknown"));
  v.Add(readout_s, "readout_s", "standard deviation of the readout time of a rolling shutter, s",
        ZeroIs("unknown"));
  v.Add(color_translation_m, "color_translation_m",
        "standard deviation of the translation between colour and depth camera, m",
        ZeroIs("unknown"));
  v.Add(color_rotation_rad, "color_rotation_rad",
        "standard deviation of the rotation between colour and depth camera, rad",
        ZeroIs("unknown"));
}

void CalibrationPrior::Validate(const std::string& what) const {
  WithContext(what, [&] { surfit::Validate(*this); });
}

void DepthSensor::Validate() const {
  camera.Validate("camera");
  ThrowIf(!(camera.fy > 0), "sensor: fy is ", camera.fy,
          ", must be positive: mirror the images (see SequenceInfo::mirrored)");
  noise.Validate("sensor");
  ThrowIf(!(readout_s >= 0 && readout_s <= 1), "sensor: readout_s is ", readout_s,
          ", must be from 0 to 1 (s)");
  prior.Validate("sensor: prior");
}

void Disparity::Validate(const std::string& what) const {
  const auto require = [&](bool holds, const char* field, double value, const char* must) {
    ThrowIf(!holds || !std::isfinite(value), what, ": ", field, " is ", value, ", must be finite",
            must);
  };
  require(focal_px > 0, "focal_px", focal_px, " and positive");
  require(baseline_m > 0, "baseline_m", baseline_m, " and positive");
  require(counts_per_px != 0, "counts_per_px", counts_per_px, " and not 0");
  require(true, "count_at_infinity", count_at_infinity, "");
}

void RgbdCamera::Validate(const std::string& what) const {
  depth.Validate(what + ": depth camera");
  if (!color_is_registered) color.Validate(what + ": color camera");
  const auto positive = [&](const char* field, double value) {
    ThrowIf(!(std::isfinite(value) && value > 0), what, ": ", field, " is ", value,
            ", must be finite and positive");
  };
  positive("depth_units_per_metre", depth_units_per_metre);
  if (disparity.IsGiven()) disparity.Validate(what + ": disparity");
  noise.Validate(what);
  positive("frames_per_second", frames_per_second);
  const auto within_a_second = [&](const char* field, double value) {
    ThrowIf(!(std::abs(value) <= 1), what, ": ", field, " is ", value,
            ", must be from -1 to 1 (s)");
  };
  within_a_second("latency_s", latency_s);
  within_a_second("color_latency_s", color_latency_s);
  ThrowIf(!(readout_s >= 0 && readout_s <= 1), what, ": readout_s is ", readout_s,
          ", must be from 0 to 1 (s)");
  prior.Validate(what + ": prior");
  ThrowIf(
      !color_from_depth.translation.allFinite() || !color_from_depth.rotation.coeffs().allFinite(),
      what, ": color_from_depth must be finite");
}

}  // namespace surfit
