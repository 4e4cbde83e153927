#include "finishing/stereo/refine_labels.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace surfit {
namespace {

constexpr int kMaxSteps = 16;
constexpr int kSmoothRadius = 2, kWindowRadius = 3;  // px
constexpr float kSameSurface = 1.5f;                 // labels
constexpr float kMaxDetailCost = 24;
constexpr float kMinContrast = 1;  // mean difference of the largest and the least cost per pixel

using StepCosts = std::array<float, kMaxSteps>;

Image<float> Smoothed(const Image<float>& labels, const Image<std::uint8_t>& refined) {
  Image<float> smoothed = labels;
  for (int v = 0; v < labels.height(); ++v) {
    for (int u = 0; u < labels.width(); ++u) {
      const float centre = labels(u, v);
      if (refined(u, v) == 0 || centre < 0) continue;
      float sum = 0, count = 0;
      for (int y = std::max(0, v - kSmoothRadius);
           y <= std::min(labels.height() - 1, v + kSmoothRadius); ++y) {
        for (int x = std::max(0, u - kSmoothRadius);
             x <= std::min(labels.width() - 1, u + kSmoothRadius); ++x) {
          const float label = labels(x, y);
          if (label < 0 || std::abs(label - centre) > kSameSurface) continue;
          sum += label;
          ++count;
        }
      }
      smoothed(u, v) = sum / count;
    }
  }
  return smoothed;
}

// Bilinear value; a negative number outside of the image.
float Interpolated(const Image<std::uint8_t>& detail, float u, float v) {
  if (!(u >= 0 && v >= 0 && u < static_cast<float>(detail.width() - 1) &&
        v < static_cast<float>(detail.height() - 1))) {
    return -1;
  }
  const int left = static_cast<int>(u), top = static_cast<int>(v);
  const float s = u - static_cast<float>(left), t = v - static_cast<float>(top);
  const std::uint8_t* const p = detail.row(top) + left;
  const std::uint8_t* const q = p + detail.width();
  const float above = static_cast<float>(p[0]) + s * static_cast<float>(p[1] - p[0]);
  const float below = static_cast<float>(q[0]) + s * static_cast<float>(q[1] - q[0]);
  return above + t * (below - above);
}

class Refinement {
 public:
  Refinement(const LabelRange& range, const MatchedImage& image,
             const std::vector<const MatchedImage*>& neighbours, const RefinedSteps& steps)
      : range_(range), image_(image), neighbours_(neighbours), steps_(steps) {
    for (const MatchedImage* neighbour : neighbours) {
      lines_.push_back(LinesBetween(image, *neighbour));
    }
  }

  float Step(int k) const {
    return steps_.range * (2 * static_cast<float>(k) / static_cast<float>(steps_.count - 1) - 1);
  }

  // Mean of the least three costs of the neighbours for each step.
  StepCosts CostsOf(int u, int v, float label) const {
    const Eigen::Vector3f ray = image_.camera.Ray(u, v).cast<float>();
    const float detail = image_.detail(u, v);
    std::array<StepCosts, 3> least;
    for (StepCosts& costs : least) costs.fill(kMaxDetailCost);
    for (std::size_t i = 0; i < neighbours_.size(); ++i) {
      const Eigen::Vector3f start = lines_[i].rotation * ray;
      for (int k = 0; k < steps_.count; ++k) {
        const Eigen::Vector3f at = start + range_.InverseDepth(label + Step(k)) * lines_[i].shift;
        float cost = kMaxDetailCost;
        if (at.z() > 0.05f) {
          const float seen = Interpolated(neighbours_[i]->detail, at.x() / at.z(), at.y() / at.z());
          if (seen >= 0) cost = std::min(kMaxDetailCost, std::abs(seen - detail));
        }
        const float a = least[0][k], b = least[1][k];
        least[2][k] = std::min(least[2][k], std::max(b, cost));
        least[1][k] = std::min(b, std::max(a, cost));
        least[0][k] = std::min(a, cost);
      }
    }
    StepCosts mean;
    for (int k = 0; k < steps_.count; ++k) {
      mean[k] = (least[0][k] + least[1][k] + least[2][k]) / 3;
    }
    return mean;
  }

  // Vertex of the parabola at the least cost.
  float BestStep(const StepCosts& costs, float pixels) const {
    const auto end = costs.begin() + steps_.count;
    const auto best = static_cast<int>(std::min_element(costs.begin(), end) - costs.begin());
    const float most = *std::max_element(costs.begin(), end);
    if (most - costs[best] < kMinContrast * pixels) return 0;
    if (best == 0 || best == steps_.count - 1) return Step(best);
    const float before = costs[best - 1], after = costs[best + 1];
    const float curvature = before - 2 * costs[best] + after;
    const float fraction = curvature > 0 ? (before - after) / (2 * curvature) : 0;
    return Step(best) + fraction * (Step(1) - Step(0));
  }

 private:
  const LabelRange& range_;
  const MatchedImage& image_;
  const std::vector<const MatchedImage*>& neighbours_;
  const RefinedSteps steps_;
  std::vector<EpipolarLines> lines_;
};

}  // namespace

Image<float> RefineLabels(const Image<float>& labels, const Image<std::uint8_t>& refined,
                          const LabelRange& range, const MatchedImage& image,
                          const std::vector<const MatchedImage*>& neighbours,
                          const RefinedSteps& steps) {
  const int width = labels.width(), height = labels.height();
  Image<float> result = Smoothed(labels, refined);
  const Image<float> smoothed = result;
  const Refinement refinement(range, image, neighbours, steps);
  Image<std::int32_t> index(width, height, -1);
  std::vector<StepCosts> costs;
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      if (refined(u, v) == 0 || smoothed(u, v) < 0 || image.census(u, v) == 0) continue;
      index(u, v) = static_cast<std::int32_t>(costs.size());
      costs.push_back(refinement.CostsOf(u, v, smoothed(u, v)));
    }
  }
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      if (index(u, v) < 0) continue;
      StepCosts sum = {};
      float pixels = 0;
      const float centre = smoothed(u, v);
      for (int y = std::max(0, v - kWindowRadius); y <= std::min(height - 1, v + kWindowRadius);
           ++y) {
        for (int x = std::max(0, u - kWindowRadius); x <= std::min(width - 1, u + kWindowRadius);
             ++x) {
          if (index(x, y) < 0 || std::abs(smoothed(x, y) - centre) > kSameSurface) continue;
          const StepCosts& of_pixel = costs[index(x, y)];
          for (int k = 0; k < steps.count; ++k) sum[k] += of_pixel[k];
          ++pixels;
        }
      }
      result(u, v) = std::max(0.f, centre + refinement.BestStep(sum, pixels));
    }
  }
  return result;
}

}  // namespace surfit
