#include "simulation/sensors/correlated_noise.h"

#include <cmath>
#include <vector>

#include "simulation/random.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

// White noise that is filtered with exp(-x^2 / (2 s^2)) has the correlation exp(-r^2 / (4 s^2)), so
// s = correlation_px / 2. The squares of the weights sum to 1, which keeps the variance.
std::vector<float> FilterWeights(double correlation_px) {
  const double s = correlation_px / 2;
  const int radius = static_cast<int>(std::ceil(3 * s));
  std::vector<double> weights;
  double squares = 0;
  for (int x = -radius; x <= radius; ++x) {
    weights.push_back(x == 0 ? 1 : std::exp(-x * x / (2 * s * s)));
    squares += weights.back() * weights.back();
  }
  std::vector<float> normalised;
  for (const double weight : weights) {
    normalised.push_back(static_cast<float>(weight / std::sqrt(squares)));
  }
  return normalised;
}

}  // namespace

Image<float> CorrelatedNoise(int width, int height, double correlation_px, std::uint64_t seed) {
  const std::vector<float> weights = FilterWeights(correlation_px);
  const int taps = static_cast<int>(weights.size()), margin = taps - 1;
  Image<float> rows(width, height + margin, 0.f);  // filtered along u
  ParallelFor(0, rows.height(), kRowsPerBlock, [&](int begin, int end) {
    std::vector<float> white(width + margin);
    for (int v = begin; v < end; ++v) {
      Random random(seed, v);
      for (float& value : white) value = static_cast<float>(random.Normal());
      for (int k = 0; k < taps; ++k) {
        for (int u = 0; u < width; ++u) rows(u, v) += weights[k] * white[u + k];
      }
    }
  });
  Image<float> noise(width, height, 0.f);
  ParallelFor(0, height, kRowsPerBlock, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      for (int k = 0; k < taps; ++k) {
        for (int u = 0; u < width; ++u) noise(u, v) += weights[k] * rows(u, v + k);
      }
    }
  });
  return noise;
}

double NormalRatio(double value) { return 0.5 * std::erfc(-value / std::sqrt(2.)); }

}  // namespace surfit
