#include "io/depth/depth_encoding.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <map>

#include "surfit/core/error.h"

namespace surfit {
namespace {

constexpr int kSamplesPerImage = 20000;
constexpr int kRotation = 3;  // bits

std::uint16_t Swapped(std::uint16_t count) {
  return static_cast<std::uint16_t>(count << 8 | count >> 8);
}

std::uint16_t Unrotated(std::uint16_t count) {
  return static_cast<std::uint16_t>(count >> kRotation | count << (16 - kRotation));
}

// Value of a pixel; 0 without a measurement.
double ValueOf(std::uint16_t count) { return count == 65535 ? 0 : count; }
double ValueOf(float depth) { return std::isfinite(depth) && depth > 0 ? depth : 0; }

// Values of about kSamplesPerImage pixels of each image, at the same pixels.
using Samples = std::vector<std::vector<double>>;
Samples SamplesOf(const std::vector<FrameImages>& images) {
  Samples samples;
  for (const FrameImages& image : images) {
    std::visit(
        [&](const auto& depth) {
          const std::size_t step = std::max<std::size_t>(1, depth.size() / kSamplesPerImage);
          samples.emplace_back();
          for (std::size_t i = 0; i < depth.size(); i += step)
            samples.back().push_back(ValueOf(depth[i]));
        },
        image.depth);
  }
  return samples;
}

// Ignores the value 0.
std::map<double, std::size_t> CountValues(const Samples& samples) {
  std::map<double, std::size_t> counts;
  for (const auto& image : samples) {
    for (const double value : image)
      if (value > 0) ++counts[value];
  }
  return counts;
}

std::size_t Total(const std::map<double, std::size_t>& counts) {
  std::size_t total = 0;
  for (const auto& [value, count] : counts) total += count;
  return total;
}

// `counts` must not be empty.
double MedianValue(const std::map<double, std::size_t>& counts) {
  std::size_t left = Total(counts) / 2;
  for (const auto& [value, count] : counts) {
    if (left < count) return value;
    left -= count;
  }
  return counts.rbegin()->first;
}

bool AreCounts(const std::vector<FrameImages>& images) {
  return std::holds_alternative<Image<std::uint16_t>>(images[0].depth);
}

// Compares the mean logarithm of the differences between unequal neighbouring pixels. Small
// differences of depth are multiples of 256 with swapped bytes. In recordings and simulated rooms,
// the means differ by 6 to 9 bits, in either direction. If all low bytes are 0, the images have 8
// bits in the high byte.
bool HasSwappedBytes(const std::vector<FrameImages>& images) {
  constexpr double kMinMargin_bits = 4;
  constexpr std::size_t kMinPairs = 50;
  double plain = 0, swapped = 0;
  std::size_t pairs = 0;
  bool has_low_byte = false;
  for (const FrameImages& image : images) {
    const auto* const depth = std::get_if<Image<std::uint16_t>>(&image.depth);
    if (depth == nullptr) return false;
    const std::size_t step = std::max<std::size_t>(1, depth->size() / kSamplesPerImage);
    for (std::size_t i = 1; i < depth->size(); i += step) {
      const std::uint16_t a = (*depth)[i - 1], b = (*depth)[i];
      if (ValueOf(a) == 0 || ValueOf(b) == 0 || a == b) continue;
      plain += std::log2(1. + std::abs(a - b));
      swapped += std::log2(1. + std::abs(Swapped(a) - Swapped(b)));
      has_low_byte |= ((a | b) & 255) != 0;
      ++pairs;
    }
  }
  return has_low_byte && pairs >= kMinPairs &&
         plain > swapped + kMinMargin_bits * static_cast<double>(pairs);
}

// SUN3D stores millimetres rotated by 3 bits. Below 8.192 m, these counts are multiples of 8.
bool IsRotated(const std::map<double, std::size_t>& counts, double units_per_metre) {
  constexpr double kMinRatio = 0.98, kMinOdd = 0.1;
  constexpr std::size_t kMinDistinct = 50;
  constexpr double kNearest_m = 0.2, kFarthest_m = 5;  // median depth of a room
  const auto total = static_cast<double>(Total(counts));
  if (counts.size() < kMinDistinct) return false;
  double multiples = 0, odd = 0;
  for (const auto& [value, count] : counts) {
    const int bits = static_cast<int>(value);
    if ((bits & 7) == 0) multiples += static_cast<double>(count);
    if ((bits & 8) != 0) odd += static_cast<double>(count);
  }
  const double median_m = MedianValue(counts) / units_per_metre, unrotated_m = median_m / 8;
  return multiples >= kMinRatio * total && odd >= kMinOdd * total && median_m > kFarthest_m &&
         unrotated_m >= kNearest_m && unrotated_m <= kFarthest_m;
}

// True if the depth of most pixels changes between the images, except at the fill value.
bool Changes(const Samples& samples, double fill) {
  constexpr std::size_t kMinPairs = 100;
  std::size_t pairs = 0, equal = 0;
  for (std::size_t k = 1; k < samples.size(); ++k) {
    const std::size_t size = std::min(samples[k].size(), samples[k - 1].size());
    for (std::size_t i = 0; i < size; ++i) {
      const double a = samples[k - 1][i], b = samples[k][i];
      if (a == 0 || b == 0 || a == fill || b == fill) continue;
      ++pairs;
      equal += a == b;
    }
  }
  return pairs >= kMinPairs && 2 * equal < pairs;
}

// Number of images in which the value covers at least `min_ratio` of the pixels with depth.
std::size_t ImagesWith(const Samples& samples, double fill, double min_ratio) {
  std::size_t images = 0;
  for (const auto& image : samples) {
    const auto is_valid = [](double value) { return value > 0; };
    const auto valid = std::count_if(image.begin(), image.end(), is_valid);
    const auto filled = std::count(image.begin(), image.end(), fill);
    images += filled > 0 && static_cast<double>(filled) >= min_ratio * static_cast<double>(valid);
  }
  return images;
}

struct EndValue {
  double value = 0;
  double excess = 0;  // ratio of its count to the mean count of the next values
};

// First of the sorted values [begin, ...). A surface at the limit of the range has similar counts
// of neighbouring values. std::nullopt with too few values.
template <typename Iterator>
std::optional<EndValue> EndOf(Iterator begin, Iterator end) {
  constexpr std::size_t kNext = 10;
  if (begin == end) return std::nullopt;
  std::size_t next = 0, sum = 0;
  for (Iterator it = std::next(begin); it != end && next < kNext; ++it, ++next) sum += it->second;
  if (next < kNext) return std::nullopt;
  return EndValue{begin->first, static_cast<double>(begin->second) * kNext / sum};
}

// The value must be frequent in most images. A value of great excess may be absent from most
// images, because the camera sees far surfaces only at times.
bool IsFill(const Samples& samples, const EndValue& end) {
  constexpr double kMinExcess = 20, kGreatExcess = 100;
  if (end.excess < kMinExcess) return false;
  const std::size_t frequent = ImagesWith(samples, end.value, 0.01);
  const bool in_most = frequent >= 3 && 2 * frequent >= samples.size();
  const bool in_some =
      end.excess >= kGreatExcess && frequent >= 1 && ImagesWith(samples, end.value, 0.002) >= 2;
  return (in_most || in_some) && Changes(samples, end.value);
}

std::optional<double> FindFillValue(const Samples& samples) {
  const std::map<double, std::size_t> counts = CountValues(samples);
  for (const auto& end :
       {EndOf(counts.rbegin(), counts.rend()), EndOf(counts.begin(), counts.end())}) {
    if (end && IsFill(samples, *end)) return end->value;
  }
  return std::nullopt;
}

// Percentage of the pixels with depth that have the value.
double PercentWith(const std::vector<FrameImages>& images, double value) {
  const std::map<double, std::size_t> counts = CountValues(SamplesOf(images));
  const double ratio = static_cast<double>(counts.at(value)) / static_cast<double>(Total(counts));
  return 0.1 * std::round(1000 * ratio);
}

std::vector<FrameImages> Decoded(std::vector<FrameImages> images, const DepthEncoding& encoding) {
  for (FrameImages& image : images) DecodeDepth(encoding, &image.depth);
  return images;
}

}  // namespace

DepthEncoding DetectDepthEncoding(const std::vector<FrameImages>& images, const RgbdCamera& camera,
                                  std::vector<std::string>* warnings) {
  constexpr double kMaxMetres = 100;
  DepthEncoding encoding;
  if (images.empty() || camera.disparity.IsGiven()) return encoding;
  const std::string& first = images[0].depth_name;
  const bool are_counts = AreCounts(images);
  const double units = are_counts ? camera.depth_units_per_metre : 1;
  if (HasSwappedBytes(images)) {
    encoding.has_swapped_bytes = true;
    warnings->push_back(Concat(first,
                               ": the two bytes of each depth value are swapped, which is "
                               "corrected in all depth images"));
  }
  std::map<double, std::size_t> counts = CountValues(SamplesOf(Decoded(images, encoding)));
  if (counts.empty()) return encoding;
  if (are_counts && IsRotated(counts, units)) {
    encoding.is_rotated = true;
    warnings->push_back(Concat(first,
                               ": the depth values are rotated by 3 bits as in SUN3D, which "
                               "is corrected in all depth images"));
  }
  const double median = MedianValue(counts);
  if (!are_counts && median > kMaxMetres) {
    encoding.float_unit_m = 0.001;
    warnings->push_back(Concat(first, ": the depth values have the unit mm by their median of ",
                               median, ", they are converted to m"));
  }
  const std::vector<FrameImages> decoded = Decoded(images, encoding);
  encoding.fill_value = FindFillValue(SamplesOf(decoded));
  if (encoding.fill_value) {
    const double fill = *encoding.fill_value;
    warnings->push_back(Concat(first, ": the depth value ", fill, " (", fill / units, " m) fills ",
                               PercentWith(decoded, fill),
                               " % of the depth in the first images, and stays constant while the "
                               "camera moves: it is read as missing"));
  }
  return encoding;
}

void DecodeDepth(const DepthEncoding& encoding, RawDepth* depth) {
  if (auto* const counts = std::get_if<Image<std::uint16_t>>(depth)) {
    for (std::uint16_t& count : *counts) {
      if (count == 65535) continue;
      if (encoding.has_swapped_bytes) count = Swapped(count);
      if (encoding.is_rotated) count = Unrotated(count);
      if (encoding.fill_value && count == *encoding.fill_value) count = 0;
    }
  } else {
    const auto unit = static_cast<float>(encoding.float_unit_m);
    for (float& value : std::get<Image<float>>(*depth)) {
      if (encoding.float_unit_m != 1) value *= unit;
      if (encoding.fill_value && value == *encoding.fill_value) value = 0;
    }
  }
}

std::optional<std::string> FarDepthWarning(const std::vector<FrameImages>& images,
                                           const RgbdCamera& camera, double max_depth_m) {
  constexpr double kMaxRatio = 0.2;
  if (images.empty() || camera.disparity.IsGiven()) return std::nullopt;
  const double units = AreCounts(images) ? camera.depth_units_per_metre : 1;
  std::size_t far = 0, all = 0;
  for (const auto& [value, count] : CountValues(SamplesOf(images))) {
    all += count;
    if (value / units > max_depth_m) far += count;
  }
  if (all == 0 || static_cast<double>(far) <= kMaxRatio * static_cast<double>(all))
    return std::nullopt;
  return Concat(std::lround(100. * static_cast<double>(far) / static_cast<double>(all)),
                " % of the depth in the first images is beyond max_depth_m, ", max_depth_m,
                " m, and is not used: increase max_depth_m if the sensor measures farther");
}

}  // namespace surfit
