#include <algorithm>
#include <array>
#include <cmath>

#include "apps/doctor/recording_checks.h"
#include "surfit/core/error.h"
#include "surfit/evaluation/error_statistics.h"

namespace surfit {
namespace {

// Inverse depth step of Kinect v1, Xtion and Carmine: 1/8 px of disparity, focal length 580 px,
// baseline 0.075 m.
constexpr double kStepOfKinect = 1 / (8 * 580 * 0.075);  // 1/m
constexpr double kStepTolerance = 0.05;
constexpr std::array<double, 6> kScales = {1000, 2000, 4000, 5000, 6553.5, 10000};
constexpr double kMostLatency_s = 0.01;
constexpr double kMaxLate_s = 0.02;
constexpr double kMaxLost = 0.1;

RecordingCheck DepthScale(const RecordingEvidence& evidence) {
  std::vector<double> depths_m;
  for (const FrameStatistics& frame : evidence.frames)
    if (frame.median_depth_m > 0) depths_m.push_back(frame.median_depth_m);
  RecordingCheck check = {"median_depth", {}, "m", "0.4 to 5", "", ""};
  if (depths_m.empty()) return check;
  check.value = Quantile(depths_m, 0.5);
  const auto doubted = static_cast<int>(evidence.doubted_scales.size());
  if (2 * doubted <= evidence.sampled_depths) return check;
  check.fault =
      Concat(evidence.doubted_scales.front(), " (in ", doubted, " of ", evidence.sampled_depths,
             " sampled frames; must be ", check.constraint, " m)");
  check.advice = "set the depth scale: --depth_scale, or depth_units_per_metre in camera.yaml";
  return check;
}

// Returns the common depth scale that makes the measured step equal to the step of a Kinect.
// `step`: measured with the configured `scale`. std::nullopt if `scale` is correct, or if no common
// scale matches.
std::optional<double> ScaleOfKinect(double step, double scale) {
  if (std::abs(step / kStepOfKinect - 1) < kStepTolerance) return std::nullopt;
  for (const double other : kScales) {
    if (std::abs(step * other / scale / kStepOfKinect - 1) < kStepTolerance) return other;
  }
  return std::nullopt;
}

RecordingCheck DepthSteps(const RecordingEvidence& evidence) {
  RecordingCheck check = {
      "inverse_depth_step", evidence.inverse_depth_step, "1/m", "step of the sensor", "", ""};
  const RgbdCamera& camera = evidence.info.camera;
  if (!check.value) return check;
  const auto scale = ScaleOfKinect(*check.value, camera.depth_units_per_metre);
  if (!scale) return check;
  check.fault =
      Concat("the inverse depth step is ", Rounded(*check.value), " 1/m with ",
             camera.depth_units_per_metre, " units per metre; a Kinect or Xtion has steps of ",
             Rounded(kStepOfKinect), " 1/m, which correspond to a depth scale of ", *scale);
  check.advice = Concat("for a Kinect or Xtion, set --depth_scale=", *scale,
                        ", or depth_units_per_metre in camera.yaml");
  return check;
}

// Noise of the first frames. It differs between scenes, so only a large difference is a fault.
RecordingCheck Noise(const RecordingEvidence& evidence) {
  const DepthNoise& start = evidence.info.camera.noise;
  const double sigma = start.inverse_depth_sigma;
  RecordingCheck check = {
      "depth_noise",
      {},
      "1/m",
      Concat("noise of the camera, ", sigma, ", within a factor of ", MeasuredNoise::kMaxRatio),
      "",
      ""};
  if (!evidence.noise) return check;
  check.value = evidence.noise->inverse_depth_sigma;
  if (!evidence.noise->Contradicts(start)) return check;
  check.fault = Concat("the depth noise of the first frames is ", Rounded(*check.value), " 1/m (",
                       evidence.noise->pairs, " pairs of frames, ", evidence.noise->samples,
                       " pixels), the camera has ", sigma, " 1/m");
  check.advice = Concat("set inverse_depth_sigma: ", evidence.noise->Noise().inverse_depth_sigma,
                        " in camera.yaml");
  return check;
}

RecordingCheck Registration(const RecordingEvidence& evidence) {
  RecordingCheck check = {
      "color_offset", {}, "px", "consistent with the configured camera", "", ""};
  if (!evidence.registration) return check;
  const RegistrationFit& fit = *evidence.registration;
  // Alignments that are not clearly better are noise.
  check.value = fit.is_doubtful ? std::hypot(fit.right_px, fit.down_px) : 0;
  if (!fit.is_doubtful) return check;
  check.fault =
      evidence.info.camera.color_is_registered
          ? *RegistrationWarning(fit, evidence.info.camera.depth)
          : Concat(
                "edges of registered colour do not lie on edges of depth: the best match has "
                "colour at ",
                std::lround(100 * fit.scale), " % of the size of depth, ", fit.right_px,
                " px to the right and ", fit.down_px, " px down");
  check.advice = evidence.info.camera.color_is_registered
                     ? "register depth to colour in the camera, or set color_camera and "
                       "color_from_depth in camera.yaml"
                     : "calibrate the colour camera: color_camera and color_from_depth in "
                       "camera.yaml are wrong";
  return check;
}

// `latency_s`: correction of the configured latency `given_s`.
RecordingCheck Latency(const char* name, const char* what, const std::optional<double>& latency_s,
                       const char* advice, double given_s, double most_s) {
  RecordingCheck check = {name, {}, "ms", Concat("-", 1000 * most_s, " to ", 1000 * most_s),
                          "",   ""};
  if (!latency_s) return check;
  check.value = 1000 * *latency_s;
  if (std::abs(*latency_s) <= most_s) return check;
  check.fault = Concat(
      what, " ", Rounded(std::abs(*check.value)), " ms ", *latency_s > 0 ? "earlier" : "later",
      " than its timestamp minus the configured latency, must be within ", 1000 * most_s, " ms");
  check.advice = Concat(advice, Rounded(given_s + *latency_s));
  return check;
}

RecordingCheck Calibration(const RecordingEvidence& evidence) {
  RecordingCheck check = {"focal_error", {}, "%", "prior of the sensor", "", ""};
  const TrackedRecording& tracked = *evidence.tracked;
  const PinholeCamera& given = evidence.info.pinhole;
  if (tracked.calibration) check.value = 100 * (given.fx / tracked.calibration->camera.fx - 1);
  if (!tracked.calibration_warning.empty()) {
    check.fault = tracked.calibration_warning;
    check.advice =
        "set the intrinsics of the sensor for this image size: camera.yaml, --intrinsics or "
        "--camera";
  }
  return check;
}

RecordingCheck Guess(const RecordingEvidence& evidence) {
  RecordingCheck check = {
      "camera_guessed", evidence.info.camera_is_guessed ? 1. : 0., "", "0", "", ""};
  if (!evidence.info.camera_is_guessed) return check;
  check.fault =
      "the recording does not contain its camera: default intrinsics are used and may be wrong";
  check.advice =
      "set the intrinsics of the sensor: surfit_convert --to=camera_yaml writes a template";
  return check;
}

RecordingCheck Lost(const TrackedRecording& tracked) {
  RecordingCheck check = {"lost_frames",
                          100. * tracked.lost / std::max(1, tracked.frames),
                          "%",
                          Concat("at most ", 100 * kMaxLost),
                          "",
                          ""};
  if (*check.value <= 100 * kMaxLost) return check;
  check.fault = Concat("tracking lost ", tracked.lost, " of ", tracked.frames, " frames (",
                       Rounded(*check.value), " %, must be ", check.constraint, " %)");
  check.advice = "fix the other faults first, then move more slowly, with more structure in view";
  return check;
}

// Sign, unit and axes of the inertial sensor. A small motion does not show them.
RecordingCheck InertialSensor(const ImuReport& imu) {
  RecordingCheck check = {"imu", {}, "deg", "unknown: the motion is too small", "", ""};
  if (imu.has_enough_motion || !imu.off_reason.empty()) check.constraint = "agrees with the motion";
  if (imu.rotation_is_known && imu.has_enough_motion)
    check.value = imu.calibration.rotation_sigma_rad / kRadPerDeg;
  if (imu.off_reason.empty()) return check;
  check.fault = imu.read_from + ": " + imu.off_reason;
  check.advice =
      "correct signs, units and axes of the inertial sensor, or imu: camera_from_imu in "
      "camera.yaml; "
      "--noimu does not use the sensor";
  return check;
}

}  // namespace

std::vector<RecordingCheck> ChecksOfSensor(const RecordingEvidence& evidence) {
  std::vector<RecordingCheck> checks = {DepthScale(evidence), DepthSteps(evidence), Noise(evidence),
                                        Registration(evidence), Guess(evidence)};
  if (!evidence.tracked) return checks;
  const TrackedRecording& tracked = *evidence.tracked;
  checks.push_back(Calibration(evidence));
  const RgbdCamera& camera = evidence.info.camera;
  checks.push_back(
      Latency("color_latency", "colour was captured", tracked.color_latency_s,
              "set the colour latency relative to depth in camera.yaml: color_latency_s: ",
              camera.color_latency_s, kMostLatency_s));
  checks.push_back(Latency("stamps_late", "by ground truth, depth was captured", tracked.late_s,
                           "set the depth latency in camera.yaml: latency_s: ", camera.latency_s,
                           kMaxLate_s));
  if (tracked.imu) checks.push_back(InertialSensor(*tracked.imu));
  checks.push_back(Lost(tracked));
  return checks;
}

}  // namespace surfit
