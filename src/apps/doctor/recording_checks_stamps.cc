#include <algorithm>
#include <cmath>

#include "apps/doctor/recording_checks.h"
#include "surfit/core/error.h"
#include "surfit/evaluation/error_statistics.h"

namespace surfit {
namespace {

constexpr double kMaxMissing = 0.05, kMaxRepeated = 0.05, kMaxUnpaired = 0.1;
constexpr double kGap = 1.5;           // minimum interval with missing frames / median interval
constexpr double kMaxApart_s = 0.015;  // maximum offset between depth and colour timestamps

double Percent(double part, std::size_t whole) {
  return whole == 0 ? 0 : 100 * part / static_cast<double>(whole);
}

std::vector<double> IntervalsOf(const std::vector<FrameStatistics>& frames) {
  std::vector<double> intervals_s;
  for (std::size_t i = 1; i < frames.size(); ++i)
    intervals_s.push_back(frames[i].stamps.depth_s - frames[i - 1].stamps.depth_s);
  return intervals_s;
}

RecordingCheck MissingFrames(const RecordingEvidence& evidence) {
  RecordingCheck check = {"missing_frames", {}, "%", Concat("at most ", 100 * kMaxMissing), "", ""};
  const std::vector<double> intervals_s = IntervalsOf(evidence.frames);
  const double usual_s = Quantile(intervals_s, 0.5);
  if (!(usual_s > 0)) return check;
  double missing = 0, longest_s = 0;
  for (const double interval_s : intervals_s) {
    if (interval_s > kGap * usual_s) missing += std::round(interval_s / usual_s) - 1;
    longest_s = std::max(longest_s, interval_s);
  }
  check.value = Percent(missing, evidence.frames.size() + static_cast<std::size_t>(missing));
  if (*check.value <= 100 * kMaxMissing) return check;
  check.fault = Concat(missing, " frames are missing (", Rounded(*check.value), " %, must be ",
                       check.constraint, "): the longest interval between timestamps is ",
                       Rounded(longest_s), " s, the median is ", Rounded(usual_s), " s");
  check.advice =
      "use a faster disk, no compression and a separate USB port, and stop other programs";
  return check;
}

RecordingCheck StampOrder(const RecordingEvidence& evidence) {
  RecordingCheck check = {"stamps_not_ascending", 0., "", "0", "", ""};
  for (const double interval_s : IntervalsOf(evidence.frames)) *check.value += !(interval_s > 0);
  if (*check.value == 0) return check;
  check.fault =
      Concat(*check.value, " timestamps are not later than the previous timestamp, must be 0");
  check.advice = "sort the frames by timestamp, and remove duplicates";
  return check;
}

RecordingCheck Unpaired(const RecordingEvidence& evidence) {
  RecordingCheck check = {"unpaired_images",
                          100 * evidence.info.unpaired_ratio,
                          "%",
                          Concat("at most ", 100 * kMaxUnpaired),
                          "",
                          ""};
  if (*check.value <= 100 * kMaxUnpaired) return check;
  check.fault = Concat(Rounded(*check.value), " % of the depth and colour images, must be ",
                       check.constraint, " %, have no colour or depth image within ",
                       1000 * kMaxBetweenImages_s, " ms, and are skipped");
  check.advice =
      "synchronise depth and colour at one frame rate in the camera, and check for dropped images";
  return check;
}

RecordingCheck Repeated(const std::string& name, const char* what, std::size_t repeated,
                        const RecordingEvidence& evidence) {
  RecordingCheck check = {name, Percent(static_cast<double>(repeated), evidence.frames.size()),
                          "%",  Concat("at most ", 100 * kMaxRepeated),
                          "",   ""};
  if (*check.value <= 100 * kMaxRepeated) return check;
  check.fault = Concat(repeated, " ", what, " images (", Rounded(*check.value), " %, must be ",
                       check.constraint, ") are bitwise identical to the previous image");
  check.advice =
      "the camera or its driver repeats an image after a drop: lower the frame rate or the "
      "resolution, or use a separate USB port";
  return check;
}

RecordingCheck ColorStamps(const RecordingEvidence& evidence) {
  RecordingCheck check = {"color_stamp_after_depth",
                          {},
                          "ms",
                          Concat("-", 1000 * kMaxApart_s, " to ", 1000 * kMaxApart_s),
                          "",
                          ""};
  std::vector<double> after_ms;
  for (const FrameStatistics& frame : evidence.frames)
    if (frame.color) after_ms.push_back(1000 * (frame.stamps.color_s - frame.stamps.depth_s));
  if (after_ms.empty()) return check;
  check.value = Quantile(after_ms, 0.5);
  if (std::abs(*check.value) <= 1000 * kMaxApart_s) return check;
  check.fault = Concat("colour timestamps are ", Rounded(std::abs(*check.value)), " ms ",
                       *check.value > 0 ? "later" : "earlier",
                       " than depth timestamps (median, must be ", check.constraint, " ms)");
  check.advice = "synchronise depth and colour in the camera, or use one clock for both";
  return check;
}

}  // namespace

std::vector<RecordingCheck> ChecksOfStamps(const RecordingEvidence& evidence) {
  std::size_t depths = 0, colors = 0;
  for (const FrameStatistics& frame : evidence.frames) {
    depths += frame.repeats_depth;
    colors += frame.repeats_color;
  }
  return {MissingFrames(evidence),
          StampOrder(evidence),
          Unpaired(evidence),
          Repeated("repeated_depth", "depth", depths, evidence),
          Repeated("repeated_color", "colour", colors, evidence),
          ColorStamps(evidence)};
}

}  // namespace surfit
