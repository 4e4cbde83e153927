#include <algorithm>
#include <functional>

#include "apps/doctor/recording_checks.h"
#include "surfit/core/error.h"
#include "surfit/evaluation/error_statistics.h"

namespace surfit {
namespace {

constexpr double kMinValid = 0.4;  // minimum median ratio of pixels with depth
// Limits of the median depth of a frame, and maximum ratio of frames beyond each limit.
constexpr double kNear_m = 0.5, kFar_m = 4, kMaxOff = 0.2;
// Minimum brightness, and maximum ratio of saturated pixels per frame.
constexpr double kDark = 0.12, kMaxSaturated = 0.25;
// Relative brightness change that counts as a jump, and maximum ratio of jumps.
constexpr double kJump = 0.1, kMaxJumps = 0.05;
// Minimum edge width of a blurred frame, relative to the image width (7 px of 640 px). Maximum
// ratio of blurred frames. Edges of a static Kinect are 4 px wide.
constexpr double kBlurred = 0.011, kMaxBlurred = 0.25;
constexpr int kMinWidth_px = 300, kMinHeight_px = 220;

using FigureOf = std::function<std::optional<double>(const FrameStatistics&)>;

std::vector<double> All(const RecordingEvidence& evidence, const FigureOf& figure) {
  std::vector<double> values;
  for (const FrameStatistics& frame : evidence.frames) {
    if (!frame.error.empty()) continue;
    if (const auto value = figure(frame)) values.push_back(*value);
  }
  return values;
}

std::optional<double> MedianOf(const std::vector<double>& values) {
  if (values.empty()) return std::nullopt;
  return Quantile(values, 0.5);
}

std::optional<double> PercentOf(const std::vector<double>& values,
                                const std::function<bool(double)>& holds) {
  if (values.empty()) return std::nullopt;
  const auto count = std::count_if(values.begin(), values.end(), holds);
  return 100. * static_cast<double>(count) / static_cast<double>(values.size());
}

RecordingCheck AtMost(const char* name, std::optional<double> percent, double most,
                      const std::string& of_what, const char* advice) {
  RecordingCheck check = {name, percent, "%", Concat("at most ", 100 * most), "", ""};
  if (!percent || *percent <= 100 * most) return check;
  check.fault = Concat(Rounded(*percent), " % of ", of_what, ", must be ", check.constraint, " %");
  check.advice = advice;
  return check;
}

RecordingCheck Unreadable(const RecordingEvidence& evidence) {
  RecordingCheck check = {"unreadable_frames", 0., "", "0", "", ""};
  std::string first;
  for (const FrameStatistics& frame : evidence.frames) {
    if (frame.error.empty()) continue;
    if (first.empty()) first = frame.error;
    ++*check.value;
  }
  if (first.empty()) return check;
  check.fault = Concat(*check.value, " unreadable frames, must be 0; first error: ", first);
  check.advice = "copy the files again, or remove these frames";
  return check;
}

RecordingCheck Resolution(const RecordingEvidence& evidence) {
  const PinholeCamera& depth = evidence.info.camera.depth;
  RecordingCheck check = {"depth_width",
                          static_cast<double>(depth.width),
                          "px",
                          Concat("at least ", kMinWidth_px),
                          "",
                          ""};
  if (depth.width >= kMinWidth_px && depth.height >= kMinHeight_px) return check;
  check.fault = Concat("depth images are ", depth.width, " x ", depth.height,
                       " pixels, must be at least ", kMinWidth_px, " x ", kMinHeight_px);
  check.advice = "choose a camera mode with a higher resolution";
  return check;
}

RecordingCheck ValidDepth(const RecordingEvidence& evidence) {
  const auto valid = MedianOf(All(evidence, [](const auto& f) { return f.valid_ratio; }));
  RecordingCheck check = {"valid_depth", {}, "%", Concat("at least ", 100 * kMinValid), "", ""};
  if (!valid) return check;
  check.value = 100 * *valid;
  if (*valid >= kMinValid) return check;
  check.fault = Concat("the median ratio of pixels with depth is ", Rounded(*check.value),
                       " %, must be ", check.constraint, " %");
  check.advice =
      "respect the minimum distance of the sensor, and avoid glass, black or reflective surfaces, "
      "sunlight and other depth cameras";
  return check;
}

std::vector<RecordingCheck> Distances(const RecordingEvidence& evidence) {
  const auto depths_m = All(evidence, [](const FrameStatistics& f) {
    return f.median_depth_m > 0 ? std::optional<double>(f.median_depth_m) : std::nullopt;
  });
  return {
      AtMost("too_close", PercentOf(depths_m, [](double z) { return z < kNear_m; }), kMaxOff,
             Concat("the frames have a median depth below ", kNear_m, " m"),
             "increase the distance: near surfaces have depth holes and fill the field of view"),
      AtMost("too_far", PercentOf(depths_m, [](double z) { return z > kFar_m; }), kMaxOff,
             Concat("the frames have a median depth above ", kFar_m, " m"),
             "reduce the distance: depth noise grows with the square of the distance")};
}

RecordingCheck Darkness(const RecordingEvidence& evidence) {
  const auto bright = MedianOf(All(evidence, [](const FrameStatistics& f) {
    return f.color ? std::optional<double>(f.color->brightness) : std::nullopt;
  }));
  RecordingCheck check = {"brightness", {}, "%", Concat("at least ", 100 * kDark), "", ""};
  if (!bright) return check;
  check.value = 100 * *bright;
  if (*bright >= kDark) return check;
  check.fault = Concat("colour images are dark: median brightness ", Rounded(*check.value),
                       " %, must be ", check.constraint, " %");
  check.advice = "add light, or use a longer exposure and move the camera more slowly";
  return check;
}

RecordingCheck Saturation(const RecordingEvidence& evidence) {
  const auto shares = All(evidence, [](const FrameStatistics& f) {
    return f.color ? std::optional<double>(f.color->saturated_ratio) : std::nullopt;
  });
  return AtMost("saturated", PercentOf(shares, [](double s) { return s > kMaxSaturated; }), kMaxOff,
                Concat("the frames have more than ", 100 * kMaxSaturated, " % saturated pixels"),
                "use a shorter exposure, or keep windows and lamps out of view");
}

// Consecutive views are similar, so brightness changes are exposure changes.
RecordingCheck ExposureChanges(const RecordingEvidence& evidence) {
  std::vector<double> changes;
  for (std::size_t i = 1; i < evidence.frames.size(); ++i) {
    const auto &a = evidence.frames[i - 1].color, &b = evidence.frames[i].color;
    if (!a || !b || !(std::min(a->brightness, b->brightness) > 0)) continue;
    changes.push_back(
        std::max(a->brightness, b->brightness) / std::min(a->brightness, b->brightness) - 1);
  }
  return AtMost(
      "exposure_changes", PercentOf(changes, [](double c) { return c > kJump; }), kMaxJumps,
      Concat("the frames differ in brightness from the previous frame by more than ", 100 * kJump,
             " %"),
      "lock exposure and white balance (--device=640x480@30,lock_exposure of surfit_record)");
}

RecordingCheck Blur(const RecordingEvidence& evidence) {
  const auto widths = All(evidence, [](const FrameStatistics& f) {
    return f.color ? f.color->edge_width : std::nullopt;
  });
  return AtMost(
      "blurred", PercentOf(widths, [](double w) { return w > kBlurred; }), kMaxBlurred,
      Concat("the frames have colour edges wider than ", 100 * kBlurred, " % of the image width"),
      "move the camera more slowly, use more light and a shorter exposure, and check the focus of "
      "the lens");
}

}  // namespace

std::vector<RecordingCheck> ChecksOfFrames(const RecordingEvidence& evidence) {
  std::vector<RecordingCheck> checks = {Unreadable(evidence), Resolution(evidence),
                                        ValidDepth(evidence)};
  for (RecordingCheck& check : Distances(evidence)) checks.push_back(std::move(check));
  for (RecordingCheck (*const look)(const RecordingEvidence&) :
       {Darkness, Saturation, ExposureChanges, Blur}) {
    checks.push_back(look(evidence));
  }
  return checks;
}

}  // namespace surfit
