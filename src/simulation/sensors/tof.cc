#include <cmath>
#include <limits>
#include <optional>

#include "simulation/random.h"
#include "simulation/sensors/exact_view.h"
#include "simulation/sensors/multipath.h"
#include "surfit/core/options.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

struct Pixel {
  int u, v;
};

// The neighbour beyond a depth edge with the largest difference of depth, or std::nullopt.
std::optional<Pixel> PixelBeyondEdge(const ExactView& exact, int u, int v, double edge_ratio) {
  std::optional<Pixel> beyond;
  float largest = 0;
  for (const Pixel other : {Pixel{u + 1, v}, {u - 1, v}, {u, v + 1}, {u, v - 1}}) {
    if (!exact.Contains(other.u, other.v)) continue;
    const float difference = std::abs(exact.Depth(other.u, other.v) - exact.Depth(u, v));
    if (difference <= largest || !exact.AreApart(u, v, other.u, other.v, edge_ratio)) continue;
    largest = difference;
    beyond = other;
  }
  return beyond;
}

// Amplitude of the received light: S of RangeNoise.
double Signal(const ExactView& exact, int u, int v) {
  const double range = exact.Range(u, v);
  return exact.Reflected(u, v) / (range * range);
}

// Range of a pixel whose share `area` sees the surface of another pixel.
double MixedRange(const ExactView& exact, Pixel here, Pixel there, double area) {
  const double a = (1 - area) * Signal(exact, here.u, here.v);
  const double b = area * Signal(exact, there.u, there.v);
  const double range = exact.Range(here.u, here.v);
  if (!(a + b > 0)) return range;
  return (a * range + b * exact.Range(there.u, there.v)) / (a + b);
}

}  // namespace

double RangeNoise::Sigma(double range_m, double reflected) const {
  const double signal = reflected / (range_m * range_m);
  if (!(signal > 0)) return std::numeric_limits<double>::infinity();
  return std::sqrt(floor_m * floor_m + shot_m * shot_m * (signal + ambient) / (signal * signal));
}

SensorImage TofDepth(const Rendering& exact, const PinholeCamera& camera, std::uint64_t seed,
                     const TofOptions& options) {
  Validate(options);
  const ExactView view(exact, camera);
  const Multipath multipath(view, options);
  SensorImage image = {Image<float>(camera.width, camera.height, 0.f),
                       Image<float>(camera.width, camera.height, 0.f),
                       {}};
  ParallelFor(0, camera.height, kRowsPerBlock, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      Random random(seed, v);
      for (int u = 0; u < camera.width; ++u) {
        // Every pixel draws the same count of numbers.
        const double noise = random.Normal(), area = random.Uniform(), flies = random.Uniform();
        if (!view.HasSurface(u, v)) continue;
        double range = view.Range(u, v);
        const double sigma = options.noise.Sigma(range, view.Reflected(u, v));
        if (sigma > options.max_sigma_m) continue;
        if (flies < options.flying_ratio) {
          const auto beyond = PixelBeyondEdge(view, u, v, options.edge_ratio);
          if (beyond) range = MixedRange(view, {u, v}, *beyond, area);
        }
        range += multipath.Bias(u, v);
        const double ray = camera.Ray(u, v).norm();
        const double z = (range + sigma * noise) / ray;
        if (z < options.min_depth_m || z > options.max_depth_m) continue;
        image.depth_m(u, v) = static_cast<float>(z);
        image.inverse_depth_sigma(u, v) = static_cast<float>(sigma / (ray * z * z));
      }
    }
  });
  return image;
}

}  // namespace surfit
