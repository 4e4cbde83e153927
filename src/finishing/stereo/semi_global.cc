#include "finishing/stereo/semi_global.h"

#include <algorithm>
#include <array>
#include <cstdlib>

#include "surfit/core/lanes.h"

namespace surfit {
namespace {

constexpr int kLabels = CostVolume::kLabels;
constexpr int kPaths = 4;                                         // per pass
constexpr std::int16_t kSmallStep = 20;                           // P1
constexpr std::int16_t kMinLargeStep = 100, kMaxLargeStep = 300;  // P2
constexpr int kEdge = 8;              // intensity difference that halves P2
constexpr std::int16_t kMost = 8000;  // greater than all path costs

// Costs of a path at one pixel. The first and the last element are kMost.
struct PathCosts {
  std::array<std::int16_t, kLabels + 2> costs;
  std::int16_t least;
};

std::int16_t LargeStep(int from, int to) {
  const int step = kMaxLargeStep * kEdge / (kEdge + std::abs(from - to));
  return static_cast<std::int16_t>(std::max<int>(kMinLargeStep, step));
}

inline void Begin(const std::uint8_t* cost, PathCosts* path, std::uint16_t* sum) {
  std::int16_t least = kMost;
  std::int16_t* const out = path->costs.data() + 1;
  for (int d = 0; d < kLabels; ++d) {
    const auto c = static_cast<std::int16_t>(cost[d]);
    out[d] = c;
    sum[d] = static_cast<std::uint16_t>(sum[d] + c);
    least = std::min(least, c);
  }
  path->least = least;
}

inline void Continue(const std::uint8_t* cost, const PathCosts& before, std::int16_t large_step,
                     PathCosts* path, std::uint16_t* sum) {
  const std::int16_t* const from = before.costs.data() + 1;
  std::int16_t* const out = path->costs.data() + 1;
  const std::int16_t start = before.least;
  const auto jump = static_cast<std::int16_t>(start + large_step);
  std::int16_t least = kMost;
  for (int d = 0; d < kLabels; ++d) {
    const auto beside = static_cast<std::int16_t>(std::min(from[d - 1], from[d + 1]) + kSmallStep);
    const std::int16_t best = std::min(std::min(from[d], beside), jump);
    const auto c = static_cast<std::int16_t>(cost[d] + best - start);
    out[d] = c;
    sum[d] = static_cast<std::uint16_t>(sum[d] + c);
    least = std::min(least, c);
  }
  path->least = least;
}

class Paths {
 public:
  Paths(const CostVolume& volume, const Image<std::uint8_t>& intensity, std::uint16_t* sums)
      : volume_(volume),
        intensity_(intensity),
        sums_(sums),
        rows_{Row(volume.width()), Row(volume.width())} {}

  // Adds the four paths from the left and from above, or from the right and from below.
  void Add(bool forward) {
    WithInstructions([&](auto /*instructions*/) {
      const int step = forward ? 1 : -1, height = volume_.height();
      for (int i = 0; i < height; ++i) AddRow(forward ? i : height - 1 - i, step);
    });
  }

 private:
  using Row = std::vector<std::array<PathCosts, kPaths>>;

  void AddRow(int v, int step) {
    const int width = volume_.width();
    Row &row = rows_[v % 2], &above = rows_[(v + 1) % 2];
    for (int i = 0; i < width; ++i) {
      const int u = step > 0 ? i : width - 1 - i;
      const std::int32_t index = volume_.IndexOf(u, v);
      if (index == CostVolume::kNone) continue;
      // Predecessors: in the row, and in the row above at -1, 0 and +1 columns.
      AddPath(index, u, v, u - step, v, row, 0, &row[u]);
      for (int path = 1; path < kPaths; ++path) {
        AddPath(index, u, v, u + path - 2, v - step, above, path, &row[u]);
      }
    }
  }

  void AddPath(std::int32_t index, int u, int v, int from_u, int from_v, const Row& from, int path,
               std::array<PathCosts, kPaths>* to) {
    PathCosts& out = (*to)[path];
    out.costs.front() = out.costs.back() = kMost;
    const std::uint8_t* const cost = volume_.Costs(index);
    std::uint16_t* const sum = sums_ + static_cast<std::size_t>(index) * kLabels;
    const bool begins = from_u < 0 || from_v < 0 || from_u >= volume_.width() ||
                        from_v >= volume_.height() ||
                        volume_.IndexOf(from_u, from_v) == CostVolume::kNone;
    if (begins) {
      Begin(cost, &out, sum);
    } else {
      Continue(cost, from[from_u][path], LargeStep(intensity_(from_u, from_v), intensity_(u, v)),
               &out, sum);
    }
  }

  const CostVolume& volume_;
  const Image<std::uint8_t>& intensity_;
  std::uint16_t* const sums_;
  std::array<Row, 2> rows_;
};

float BestLabel(const std::uint16_t* sum) {
  const int best = static_cast<int>(std::min_element(sum, sum + kLabels) - sum);
  if (best == 0 || best == kLabels - 1) return static_cast<float>(best);
  const auto before = static_cast<float>(sum[best - 1]), at = static_cast<float>(sum[best]),
             after = static_cast<float>(sum[best + 1]);
  const float curvature = before - 2 * at + after;
  return static_cast<float>(best) + (curvature > 0 ? (before - after) / (2 * curvature) : 0);
}

}  // namespace

CostVolume::CostVolume(const Image<std::uint8_t>& pixels)
    : index_(pixels.width(), pixels.height(), kNone) {
  std::int32_t count = 0;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    if (pixels[i] != 0) index_[i] = count++;
  }
  costs_.resize(Offset(count));
}

Image<float> BestLabels(const CostVolume& volume, const Image<std::uint8_t>& intensity) {
  std::vector<std::uint16_t> sums(volume.pixel_count() * kLabels);
  Paths paths(volume, intensity, sums.data());
  for (const bool forward : {true, false}) paths.Add(forward);
  Image<float> labels(volume.width(), volume.height(), -1.f);
  for (int v = 0; v < volume.height(); ++v) {
    for (int u = 0; u < volume.width(); ++u) {
      const std::int32_t index = volume.IndexOf(u, v);
      if (index == CostVolume::kNone) continue;
      labels(u, v) = BestLabel(&sums[static_cast<std::size_t>(index) * kLabels]);
    }
  }
  return labels;
}

}  // namespace surfit
