#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "simulation/sensors/dot_grid.h"
#include "simulation/sensors/exact_view.h"
#include "surfit/core/options.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

double SquaredDifference(Rgb8 a, Rgb8 b) {
  const double r = a.r - b.r, g = a.g - b.g, blue = a.b - b.b;
  return (r * r + g * g + blue * blue) / (3 * 255. * 255.);
}

struct FilledPixel {
  double inverse_depth = 0, sigma = 0;  // 1/m; 0: there is no dot
};

// Least squares of inverse depth = a + b du + c dv with the weight
//   w = exp(-(du^2 + dv^2) / 2 - color difference^2 / (2 color_scale^2))
// in units of the spacing. The value at the pixel is a = sum(g_k inverse depth_k), with the first
// row g of (A' W A + ridge)^-1 A' W. Its variance is sum(g_k^2 sigma_k^2). A plane has no bias,
// except for the ridge on b and c, which is for dots on one line.
FilledPixel Fill(const DotGrid& grid, int u, int v, Rgb8 color, double color_scale) {
  constexpr double kMinWeight = 1e-4, kRidge = 1e-9, kMargin = 0.25;
  const std::vector<const LidarDot*> dots = grid.Around(u, v);
  if (dots.empty()) return {};
  std::vector<Eigen::Vector3d> rows;
  std::vector<double> weights;
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  double total = 0, low = std::numeric_limits<double>::infinity(), high = 0;
  for (const LidarDot* const dot : dots) {
    const double du = (dot->u - u) / grid.spacing_u(), dv = (dot->v - v) / grid.spacing_v();
    const double exponent = (du * du + dv * dv) / 2 +
                            SquaredDifference(dot->color, color) / (2 * color_scale * color_scale);
    const double weight = std::max(kMinWeight, std::exp(-exponent));
    rows.emplace_back(1, du, dv);
    weights.push_back(weight);
    information += weight * rows.back() * rows.back().transpose();
    total += weight;
    low = std::min(low, dot->inverse_depth);
    high = std::max(high, dot->inverse_depth);
  }
  information.diagonal().tail<2>().array() += kRidge * total;
  const Eigen::Vector3d first = information.ldlt().solve(Eigen::Vector3d::UnitX());
  FilledPixel filled;
  double variance = 0;
  for (std::size_t k = 0; k < dots.size(); ++k) {
    const double g = weights[k] * first.dot(rows[k]);
    filled.inverse_depth += g * dots[k]->inverse_depth;
    variance += g * g * dots[k]->sigma * dots[k]->sigma;
  }
  // Limits the extrapolation at depth edges. The limit has no effect on a plane: a pixel at the
  // image border is half a spacing beyond dots that span two spacings.
  const double margin = kMargin * (high - low);
  filled.inverse_depth =
      std::clamp(filled.inverse_depth, std::max(low - margin, low / 2), high + margin);
  filled.sigma = std::sqrt(variance);
  return filled;
}

// Smallest distance of a pixel to a pixel beyond a depth edge, up to `reach_px`.
double DistanceToEdge(const ExactView& exact, int u, int v, double reach_px, double edge_ratio) {
  const int radius = static_cast<int>(reach_px);
  double nearest = std::numeric_limits<double>::infinity();
  for (int dv = -radius; dv <= radius; ++dv) {
    for (int du = -radius; du <= radius; ++du) {
      const double distance = std::hypot(du, dv);
      if (distance > reach_px || distance >= nearest || !exact.Contains(u + du, v + dv)) continue;
      if (exact.AreApart(u, v, u + du, v + dv, edge_ratio)) nearest = distance;
    }
  }
  return nearest;
}

std::uint8_t Confidence(const ExactView& exact, int u, int v, const LidarOptions& options) {
  const double sigma = options.noise.Sigma(exact.Range(u, v), exact.Reflected(u, v));
  if (sigma > options.medium_sigma_m) return 0;
  const double edge = DistanceToEdge(exact, u, v, 2 * options.edge_px, options.edge_ratio);
  if (edge <= options.edge_px) return 0;
  return edge <= 2 * options.edge_px || sigma > options.high_sigma_m ? 1 : 2;
}

}  // namespace

SensorImage LidarDepth(const Rendering& exact, const PinholeCamera& camera, std::uint64_t seed,
                       const LidarOptions& options) {
  Validate(options);
  const ExactView view(exact, camera);
  const DotGrid grid(view, seed, options);
  SensorImage image = {Image<float>(camera.width, camera.height, 0.f),
                       Image<float>(camera.width, camera.height, 0.f),
                       Image<std::uint8_t>(camera.width, camera.height, 0)};
  ParallelFor(0, camera.height, kRowsPerBlock, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      for (int u = 0; u < camera.width; ++u) {
        const FilledPixel filled = Fill(grid, u, v, view.Color(u, v), options.color_scale);
        if (filled.inverse_depth == 0) continue;
        image.depth_m(u, v) = static_cast<float>(1 / filled.inverse_depth);
        image.inverse_depth_sigma(u, v) = static_cast<float>(filled.sigma);
        if (view.HasSurface(u, v)) image.confidence(u, v) = Confidence(view, u, v, options);
      }
    }
  });
  return image;
}

}  // namespace surfit
