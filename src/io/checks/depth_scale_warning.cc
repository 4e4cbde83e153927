#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <vector>

#include "io/checks/recording_warnings.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

// Depth cameras measure from 0.4 m to about 5 m. Indoors, the median depth is usually 1 to 3 m. A
// median depth beyond kNearest_m or kFarthest_m causes a warning if another scale fits better. A
// median depth beyond kAbsurdlyNear_m or kAbsurdlyFar_m always causes a warning.
constexpr double kNearest_m = 0.4, kFarthest_m = 5;
constexpr double kAbsurdlyNear_m = 0.2, kAbsurdlyFar_m = 20;
constexpr double kUsual_m = 1.8;
// The scale is also implausible if almost all depth is below kAllNear_m, and some of it is closer
// than sensors measure (kTooNear_m).
constexpr double kAllNear_m = 1.2, kTooNear_m = 0.3;
constexpr double kFew = 0.02;  // ratio of pixels that are ignored as outliers
// Depth counts per metre. Common scales: 1 mm and TUM. Rare scales: Replica and 0.1 mm. Rare scales
// are similar to the scale of TUM. So they are only considered for counts beyond the range of TUM.
constexpr std::array<double, 2> kCommonScales = {1000, 5000};
constexpr std::array<double, 2> kRareScales = {6553.5, 10000};

std::vector<std::uint16_t> ValidCounts(const Image<std::uint16_t>& depth) {
  std::vector<std::uint16_t> valid;
  std::copy_if(depth.begin(), depth.end(), std::back_inserter(valid),
               [](std::uint16_t d) { return d != 0 && d != 65535; });
  return valid;
}

// `counts` must not be empty.
double Quantile(std::vector<std::uint16_t> counts, double share) {
  const auto at =
      counts.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(counts.size()));
  std::nth_element(counts.begin(), at, counts.end());
  return *at;
}

// Scale with the median depth closest to kUsual_m, compared by ratio.
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
                                             const std::string& path, bool is_given) {
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
  const std::string observed = Concat("the median depth of ", path, " is ", median_m, " m at ",
                                      depth_units_per_metre, " units per metre: ");
  if (is_given && likely == depth_units_per_metre) return observed + "check depth_scale";
  if (is_given) {
    return Concat(observed, "check depth_scale, the median is ", median_count / likely, " m at ",
                  likely);
  }
  return Concat(observed, "depth_scale is more likely ", likely, ", with a median of ",
                median_count / likely, " m");
}

}  // namespace surfit
