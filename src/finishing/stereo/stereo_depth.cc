#include "finishing/stereo/stereo_depth.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "finishing/stereo/refine_labels.h"
#include "finishing/stereo/semi_global.h"
#include "surfit/core/lanes.h"

namespace surfit {
namespace {

constexpr int kMeasuredBorder = 2;  // matched pixels keep this border of measured depth, px
constexpr std::uint8_t kMismatch = 255;
constexpr int kBitCost = 4, kMaxBrightnessCost = 30;
constexpr RefinedSteps kCoarseSteps = {1.5f, 13}, kFineSteps = {0.6f, 13};
constexpr float kLabelCost = 60;  // of a measured depth, per label

// Pixels of a neighbour along the epipolar line of a pixel, by label. -1: outside of the image.
using LinePixels = std::array<std::int32_t, CostVolume::kLabels>;

inline void FindPixels(const EpipolarLines& lines, const Eigen::Vector3f& ray,
                       const LabelRange& labels, int width, int height, LinePixels* pixels) {
  const Eigen::Vector3f start = lines.rotation * ray;
  const float x = start.x(), y = start.y(), z = start.z();
  const float tx = lines.shift.x(), ty = lines.shift.y(), tz = lines.shift.z();
  const auto right = static_cast<float>(width), bottom = static_cast<float>(height);
  for (int d = 0; d < CostVolume::kLabels; ++d) {
    const float r = labels.least + static_cast<float>(d) * labels.step;
    const float depth = z + r * tz;
    const float inverse = 1.f / (depth > 0.05f ? depth : 0.05f);
    const float u = (x + r * tx) * inverse + 0.5f, v = (y + r * ty) * inverse + 0.5f;
    const bool is_in = (depth > 0.05f) & (u >= 0) & (v >= 0) & (u < right) & (v < bottom);
    const int at_u = static_cast<int>(is_in ? u : 0.f), at_v = static_cast<int>(is_in ? v : 0.f);
    (*pixels)[d] = is_in ? at_v * width + at_u : -1;
  }
}

// The least three costs of each label, in ascending order.
struct LeastCosts {
  alignas(32) std::array<std::uint8_t, CostVolume::kLabels> first, second, third;

  void Clear() {
    first.fill(kMismatch);
    second.fill(kMismatch);
    third.fill(kMismatch);
  }
};

inline void AddCosts(const std::array<std::uint8_t, CostVolume::kLabels>& costs,
                     LeastCosts* least) {
  for (int d = 0; d < CostVolume::kLabels; ++d) {
    const std::uint8_t c = costs[d], a = least->first[d], b = least->second[d];
    least->third[d] = std::min(least->third[d], std::max(b, c));
    least->second[d] = std::min(b, std::max(a, c));
    least->first[d] = std::min(a, c);
  }
}

inline void WriteMeans(const LeastCosts& least, std::uint8_t* costs) {
  for (int d = 0; d < CostVolume::kLabels; ++d) {
    const int a = least.first[d], b = least.second[d], c = least.third[d];
    const int mean = c == kMismatch ? (a + b) / 2 : (a + b + c) / 3;
    costs[d] = static_cast<std::uint8_t>(b == kMismatch ? kMismatch : mean);
  }
}

class Matching {
 public:
  Matching(const LabelRange& labels, const MatchedImage& image,
           const std::vector<const MatchedImage*>& neighbours)
      : labels_(labels), image_(image), neighbours_(neighbours) {
    for (const MatchedImage* neighbour : neighbours) {
      lines_.push_back(LinesBetween(image, *neighbour));
    }
  }

  void WriteCosts(int u, int v, std::uint8_t* costs) const {
    const std::uint64_t census = image_.census(u, v);
    if (census == 0) {
      std::fill(costs, costs + CostVolume::kLabels, kMismatch);
      return;
    }
    const int brightness = image_.brightness(u, v);
    const Eigen::Vector3f ray = image_.camera.Ray(u, v).cast<float>();
    LeastCosts least;
    least.Clear();
    for (std::size_t i = 0; i < neighbours_.size(); ++i) {
      const MatchedImage& other = *neighbours_[i];
      LinePixels pixels;
      FindPixels(lines_[i], ray, labels_, other.camera.width, other.camera.height, &pixels);
      alignas(32) std::array<std::uint8_t, CostVolume::kLabels> found;
      std::int32_t last = -1;
      std::uint8_t cost = kMismatch;
      for (int d = 0; d < CostVolume::kLabels; ++d) {
        const std::int32_t pixel = pixels[d];
        if (pixel != last) {
          last = pixel;
          cost = pixel < 0 ? kMismatch : CostOf(census, brightness, other, pixel);
        }
        found[d] = cost;
      }
      AddCosts(found, &least);
    }
    WriteMeans(least, costs);
  }

 private:
  static std::uint8_t CostOf(std::uint64_t census, int brightness, const MatchedImage& other,
                             std::int32_t pixel) {
    const std::uint64_t seen = other.census[pixel];
    if (seen == 0) return kMismatch;
    const int bits = __builtin_popcountll(census ^ seen);
    const int difference = std::abs(brightness - other.brightness[pixel]);
    return static_cast<std::uint8_t>(
        std::min<int>(kMismatch - 1, kBitCost * bits + std::min(kMaxBrightnessCost, difference)));
  }

  const LabelRange& labels_;
  const MatchedImage& image_;
  const std::vector<const MatchedImage*>& neighbours_;
  std::vector<EpipolarLines> lines_;
};

// Pixels without measured depth, and the measured pixels around them.
Image<std::uint8_t> MatchedPixels(const Image<float>& measured_m) {
  const int width = measured_m.width(), height = measured_m.height();
  Image<std::uint8_t> matched(width, height, 0);
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      if (measured_m(u, v) > 0) continue;
      const int right = std::min(width - 1, u + kMeasuredBorder);
      const int bottom = std::min(height - 1, v + kMeasuredBorder);
      for (int y = std::max(0, v - kMeasuredBorder); y <= bottom; ++y) {
        for (int x = std::max(0, u - kMeasuredBorder); x <= right; ++x) matched(x, y) = 1;
      }
    }
  }
  return matched;
}

void WriteMeasured(float label, std::uint8_t* costs) {
  for (int d = 0; d < CostVolume::kLabels; ++d) {
    const float cost = kLabelCost * std::abs(static_cast<float>(d) - label);
    costs[d] = static_cast<std::uint8_t>(std::min<float>(kMismatch, cost));
  }
}

}  // namespace

Image<float> MatchDepth(const StereoKeyframe& keyframe, const LabelRange& labels,
                        const MatchedImage& image, const StereoNeighbours& neighbours) {
  const int width = image.camera.width, height = image.camera.height;
  Image<float> depth_m(width, height, 0.f);
  if (neighbours.matched.size() < 2) return depth_m;
  const Image<std::uint8_t> pixels = MatchedPixels(keyframe.measured_m);
  CostVolume volume(pixels);
  const Matching matching(labels, image, neighbours.matched);
  WithInstructions([&](auto /*instructions*/) {
    for (int v = 0; v < height; ++v) {
      for (int u = 0; u < width; ++u) {
        const std::int32_t index = volume.IndexOf(u, v);
        if (index == CostVolume::kNone) continue;
        const float measured_m = keyframe.measured_m(u, v);
        if (measured_m > 0) {
          WriteMeasured(labels.LabelOf(1 / measured_m), volume.Costs(index));
        } else {
          matching.WriteCosts(u, v, volume.Costs(index));
        }
      }
    }
  });
  Image<float> found = BestLabels(volume, image.brightness);
  Image<std::uint8_t> unmeasured(width, height, 0);
  for (std::size_t i = 0; i < found.size(); ++i) {
    unmeasured[i] = pixels[i] != 0 && !(keyframe.measured_m[i] > 0) ? 1 : 0;
  }
  found = RefineLabels(found, unmeasured, labels, image, neighbours.matched, kCoarseSteps);
  found = RefineLabels(found, unmeasured, labels, image, neighbours.distant, kFineSteps);
  for (std::size_t i = 0; i < found.size(); ++i) {
    // The surface may be beyond the first or the last label.
    const bool is_in_range = found[i] > 0.5f && found[i] < CostVolume::kLabels - 1.5f;
    if (is_in_range && unmeasured[i] != 0 && image.census[i] != 0) {
      depth_m[i] = 1 / labels.InverseDepth(found[i]);
    }
  }
  return depth_m;
}

}  // namespace surfit
