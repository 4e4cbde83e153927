#include <glog/logging.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <vector>

#include "io/image_sequence.h"
#include "surfit/core/error.h"
#include "surfit/geometry/sensor.h"

namespace surfit {
namespace {

// Depth cameras see from 0.4 m to some 5 m; 1 to 3 m are usual medians indoors. Outside the first
// range a scale that fits better is named; outside the second the scale is wrong in any case.
constexpr double kNearest_m = 0.4, kFarthest_m = 5;
constexpr double kAbsurdlyNear_m = 0.2, kAbsurdlyFar_m = 20;
constexpr double kUsual_m = 1.8;
// Millimetres and TUM's. Replica's scale and tenths of millimetres are close to TUM's and much
// rarer: they are considered only for counts beyond TUM's range.
constexpr std::array<double, 2> kCommonScales = {1000, 5000};
constexpr std::array<double, 2> kRareScales = {6553.5, 10000};

// The median of the valid counts; 0 if there are none.
double MedianCount(const Image<std::uint16_t>& depth) {
  std::vector<std::uint16_t> valid;
  std::copy_if(depth.begin(), depth.end(), std::back_inserter(valid),
               [](std::uint16_t d) { return d != 0 && d != 65535; });
  if (valid.empty()) return 0;
  const auto middle = valid.begin() + static_cast<std::ptrdiff_t>(valid.size() / 2);
  std::nth_element(valid.begin(), middle, valid.end());
  return *middle;
}

// The scale that brings the median nearest to the usual one, as a ratio.
double LikelyScale(double median_count) {
  const auto distance = [&](double scale) {
    return std::abs(std::log(median_count / scale / kUsual_m));
  };
  const auto& scales =
      median_count > kFarthest_m * kCommonScales.back() ? kRareScales : kCommonScales;
  return *std::min_element(scales.begin(), scales.end(),
                           [&](double a, double b) { return distance(a) < distance(b); });
}

template <typename T>
void TakeSizeIfUnknown(const Image<T>& image, PinholeCamera* camera) {
  if (camera->width != 0) return;
  camera->width = image.width();
  camera->height = image.height();
}

void CompleteCamera(const FrameImages& first, RgbdCamera* camera) {
  std::visit([&](const auto& depth) { TakeSizeIfUnknown(depth, &camera->depth); }, first.depth);
  if (!camera->color_is_registered) {
    if (first.color.empty()) camera->color_is_registered = true;
    TakeSizeIfUnknown(first.color, &camera->color);
  }
  RequireSizeOf(*camera, first);
}

void Mirror(Trajectory* trajectory) {
  for (StampedPose& pose : *trajectory) pose.world_from_camera = Mirrored(pose.world_from_camera);
}

}  // namespace

std::optional<std::string> DepthScaleWarning(const RawDepth& depth, double depth_units_per_metre,
                                             const std::string& path) {
  const auto* const counts = std::get_if<Image<std::uint16_t>>(&depth);
  const double median_count = counts == nullptr ? 0 : MedianCount(*counts);
  if (median_count == 0) return std::nullopt;
  const double median_m = median_count / depth_units_per_metre;
  const double likely = LikelyScale(median_count);
  const bool plausible = median_m >= kNearest_m && median_m <= kFarthest_m;
  const bool absurd = median_m < kAbsurdlyNear_m || median_m > kAbsurdlyFar_m;
  if (plausible || (likely == depth_units_per_metre && !absurd)) return std::nullopt;
  return Concat("the median depth of ", path, " is ", median_m, " m at ", depth_units_per_metre,
                " units per metre; the scale is more likely ", likely, ", which makes it ",
                median_count / likely, " m");
}

FramePreparer CompleteInfo(const FrameImages& first, const PrepareOptions& options,
                           SequenceInfo* info) {
  CompleteCamera(first, &info->camera);
  if (auto warning =
          DepthScaleWarning(first.depth, info->camera.depth_units_per_metre, first.depth_name))
    info->warnings.push_back(*warning);
  info->mirrored = info->camera.depth.fy < 0;
  if (info->mirrored) Mirror(&info->ground_truth);
  FramePreparer preparer(info->mirrored ? Mirrored(info->camera) : info->camera, options);
  info->pinhole = preparer.pinhole();
  for (const std::string& warning : info->warnings) LOG(WARNING) << warning;
  return preparer;
}

}  // namespace surfit
