#include "io/sequences/depth_scale.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <vector>

#include "surfit/core/error.h"

namespace surfit {
namespace {

// Depth cameras see from 0.4 m to some 5 m; 1 to 3 m are usual medians indoors. Outside the first
// range a scale that fits better is named; outside the second the scale is wrong in any case.
constexpr double kNearest_m = 0.4, kFarthest_m = 5;
constexpr double kAbsurdlyNear_m = 0.2, kAbsurdlyFar_m = 20;
constexpr double kUsual_m = 1.8;
// Nor is nearly all that they see so near: the nearest of it nearer than they measure.
constexpr double kAllNear_m = 1.2, kTooNear_m = 0.3;
constexpr double kFew = 0.02;  // share of the pixels that may be off
// Millimetres and TUM's. Replica's scale and tenths of millimetres are close to TUM's and much
// rarer: they are considered only for counts beyond TUM's range.
constexpr std::array<double, 2> kCommonScales = {1000, 5000};
constexpr std::array<double, 2> kRareScales = {6553.5, 10000};

// The valid counts.
std::vector<std::uint16_t> ValidCounts(const Image<std::uint16_t>& depth) {
  std::vector<std::uint16_t> valid;
  std::copy_if(depth.begin(), depth.end(), std::back_inserter(valid),
               [](std::uint16_t d) { return d != 0 && d != 65535; });
  return valid;
}

// What a share of the counts is below; there must be some.
double Quantile(std::vector<std::uint16_t> counts, double share) {
  const auto at =
      counts.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(counts.size()));
  std::nth_element(counts.begin(), at, counts.end());
  return *at;
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

}  // namespace

std::optional<std::string> DepthScaleWarning(const RawDepth& depth, double depth_units_per_metre,
                                             const std::string& path) {
  const auto* const counts = std::get_if<Image<std::uint16_t>>(&depth);
  if (counts == nullptr) return std::nullopt;
  const std::vector<std::uint16_t> valid = ValidCounts(*counts);
  if (valid.empty()) return std::nullopt;
  const auto depth_m = [&](double share) { return Quantile(valid, share) / depth_units_per_metre; };
  const double median_count = Quantile(valid, 0.5), median_m = depth_m(0.5);
  const double likely = LikelyScale(median_count);
  const bool all_near = depth_m(1 - kFew) < kAllNear_m && depth_m(kFew) < kTooNear_m;
  const bool plausible = median_m >= kNearest_m && median_m <= kFarthest_m && !all_near;
  const bool absurd = median_m < kAbsurdlyNear_m || median_m > kAbsurdlyFar_m;
  if (plausible || (likely == depth_units_per_metre && !absurd)) return std::nullopt;
  return Concat("the median depth of ", path, " is ", median_m, " m at ", depth_units_per_metre,
                " units per metre; the scale is more likely ", likely, ", which makes it ",
                median_count / likely, " m");
}

}  // namespace surfit
