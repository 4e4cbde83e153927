#include "apps/doctor/recording_statistics.h"

#include <algorithm>
#include <variant>

#include "surfit/evaluation/error_statistics.h"
#include "surfit/frame/frame_pyramid.h"

namespace surfit {
namespace {

constexpr int kBrightest = 250;  // minimum channel value of a saturated pixel
// A raw depth value is a sensor value if it has more than kFewestPixels pixels per frame on
// average. Rarer values are the result of depth averaging.
constexpr double kFewestPixels = 0.2;
// Minimum difference of raw depth values that is a step of the sensor. Smaller differences are the
// rounding unit of the file.
constexpr int kFewestCounts = 4;
constexpr std::size_t kFewestSteps = 30;

ColorStatistics FiguresOf(const Image<Rgb8>& color) {
  double brightness = 0, saturated = 0;
  for (const Rgb8& c : color) {
    brightness += GreyOf(c);
    saturated += c.r >= kBrightest && c.g >= kBrightest && c.b >= kBrightest;
  }
  const auto pixels = static_cast<double>(color.size());
  return {brightness / pixels, saturated / pixels, EdgeWidth(color)};
}

}  // namespace

void RecordingStatistics::Add(int index, const FrameStamps& stamps, const FrameImages& images,
                              const Image<float>& depth_m) {
  FrameStatistics frame;
  frame.index = index;
  frame.stamps = stamps;
  std::vector<double> valid_m;
  for (const float z : depth_m)
    if (z > 0) valid_m.push_back(z);
  frame.valid_ratio = static_cast<double>(valid_m.size()) / static_cast<double>(depth_m.size());
  frame.median_depth_m = Quantile(std::move(valid_m), 0.5);
  if (!images.color.empty()) frame.color = FiguresOf(images.color);
  frame.repeats_depth = !frames_.empty() && images.depth == last_.depth;
  frame.repeats_color = !images.color.empty() && images.color == last_.color;
  CountDepths(images.depth);
  last_ = images;
  frames_.push_back(std::move(frame));
}

void RecordingStatistics::AddUnreadable(int index, const FrameStamps& stamps,
                                        const std::string& error) {
  FrameStatistics frame;
  frame.index = index;
  frame.stamps = stamps;
  frame.error = error;
  frames_.push_back(std::move(frame));
}

void RecordingStatistics::CountDepths(const RawDepth& depth) {
  const auto* const counts = std::get_if<Image<std::uint16_t>>(&depth);
  if (counts == nullptr) return;
  pixels_of_count_.resize(65536);
  for (const std::uint16_t count : *counts) ++pixels_of_count_[count];
}

std::optional<double> RecordingStatistics::InverseDepthStep() const {
  std::vector<double> steps;
  const double fewest = kFewestPixels * static_cast<double>(frames_.size());
  int last = 0;
  for (int count = 1; count < static_cast<int>(pixels_of_count_.size()) - 1; ++count) {
    if (!(pixels_of_count_[count] > fewest)) continue;
    if (last > 0 && count - last >= kFewestCounts)
      steps.push_back(depth_units_per_metre_ * (1. / last - 1. / count));
    last = count;
  }
  if (steps.size() < kFewestSteps) return std::nullopt;
  return Quantile(std::move(steps), 0.5);
}

}  // namespace surfit
