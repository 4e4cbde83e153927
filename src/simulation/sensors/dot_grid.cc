#include "simulation/sensors/dot_grid.h"

#include <algorithm>

#include "simulation/random.h"

namespace surfit {
namespace {

constexpr double kMaxSigmaRatio = 0.1;  // dots with more noise per range are not detected

LidarDot MeasureDot(const ExactView& exact, int u, int v, double noise, const RangeNoise& law) {
  LidarDot dot;
  dot.u = u;
  dot.v = v;
  dot.color = exact.Color(u, v);
  if (!exact.HasSurface(u, v)) return dot;
  const double range = exact.Range(u, v), ray = exact.camera().Ray(u, v).norm();
  const double sigma = law.Sigma(range, exact.Reflected(u, v));
  if (!(sigma <= kMaxSigmaRatio * range)) return dot;
  dot.inverse_depth = ray / (range + sigma * noise);
  dot.sigma = sigma * ray / (range * range);
  return dot;
}

}  // namespace

DotGrid::DotGrid(const ExactView& exact, std::uint64_t seed, const LidarOptions& options)
    : across_(options.dots_across),
      down_(options.dots_down),
      spacing_u_(static_cast<double>(exact.width()) / across_),
      spacing_v_(static_cast<double>(exact.height()) / down_) {
  Random random(seed);
  for (int j = 0; j < down_; ++j) {
    for (int i = 0; i < across_; ++i) {
      const int u = static_cast<int>((i + 0.5) * spacing_u_);
      const int v = static_cast<int>((j + 0.5) * spacing_v_);
      dots_.push_back(MeasureDot(exact, u, v, random.Normal(), options.noise));
    }
  }
}

std::vector<const LidarDot*> DotGrid::Around(int u, int v) const {
  const int i = static_cast<int>(u / spacing_u_), j = static_cast<int>(v / spacing_v_);
  std::vector<const LidarDot*> dots;
  for (int reach = 2; dots.empty() && reach < 2 * std::max(across_, down_); reach *= 2) {
    for (int y = std::max(0, j - reach); y <= std::min(down_ - 1, j + reach); ++y) {
      for (int x = std::max(0, i - reach); x <= std::min(across_ - 1, i + reach); ++x) {
        const LidarDot& dot = dots_[static_cast<std::size_t>(y) * across_ + x];
        if (dot.inverse_depth > 0) dots.push_back(&dot);
      }
    }
  }
  return dots;
}

}  // namespace surfit
