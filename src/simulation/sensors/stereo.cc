#include <cmath>
#include <limits>

#include "simulation/random.h"
#include "simulation/sensors/correlated_noise.h"
#include "simulation/sensors/exact_view.h"
#include "surfit/core/options.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

// Pixels of the left image that are occluded in the right image. A pixel u with disparity d has the
// column u - d in the right image. It is occluded if a pixel to its right has a smaller column
// there, because this pixel is on a nearer surface.
Image<std::uint8_t> OccludedPixels(const ExactView& exact, double baseline_m) {
  const double baseline_focal = baseline_m * exact.camera().fx;
  Image<std::uint8_t> occluded(exact.width(), exact.height(), 0);
  for (int v = 0; v < exact.height(); ++v) {
    double smallest = std::numeric_limits<double>::infinity();
    for (int u = exact.width() - 1; u >= 0; --u) {
      if (!exact.HasSurface(u, v)) continue;
      const double column = u - baseline_focal / exact.Depth(u, v);
      occluded(u, v) = smallest < column;
      smallest = std::min(smallest, column);
    }
  }
  return occluded;
}

struct MatchedPixel {
  int u, v;               // pixel whose surface dominates the matching window
  bool has_edge = false;  // there is a depth edge in the window
};

class StereoMatcher {
 public:
  StereoMatcher(const ExactView& exact, std::uint64_t seed, const StereoOptions& options)
      : exact_(exact),
        options_(options),
        occluded_(OccludedPixels(exact, options.baseline_m)),
        noise_(Noise(seed, 0)),
        bleeding_(Noise(seed, 1)),
        loss_(Noise(seed, 2)),
        least_(Noise(seed, 3)),
        min_cosine_(std::cos(options.max_incidence_deg * M_PI / 180)) {}

  // Measured depth of a pixel, 0 if the matching fails.
  double Depth(int u, int v) const {
    if (!exact_.HasSurface(u, v)) return 0;
    const MatchedPixel match = Match(u, v);
    const bool bleeds = match.u != u || match.v != v;
    if (!bleeds && occluded_(u, v)) return 0;
    if (match.has_edge && NormalRatio(loss_(u, v)) < options_.edge_loss) return 0;
    if (exact_.CosIncidence(match.u, match.v) < min_cosine_) return 0;
    const double least = options_.min_contrast * std::exp(options_.min_contrast_sd * least_(u, v));
    if (Contrast(match.u, match.v) < least) return 0;
    const double z = 1 / (1 / static_cast<double>(exact_.Depth(match.u, match.v)) +
                          options_.InverseDepthSigma() * noise_(u, v));
    return z >= options_.min_depth_m && z <= options_.max_depth_m ? z : 0;
  }

 private:
  Image<float> Noise(std::uint64_t seed, std::uint64_t field) const {
    return CorrelatedNoise(exact_.width(), exact_.height(), options_.correlation_px,
                           Random::Mix(seed) + field);
  }

  // Calls visit(u, v, squared distance) for the pixels of the matching window.
  template <typename Visitor>
  void VisitWindow(int u, int v, const Visitor& visit) const {
    const int radius = static_cast<int>(options_.window_px);
    for (int dv = -radius; dv <= radius; ++dv) {
      for (int du = -radius; du <= radius; ++du) {
        if (du * du + dv * dv > options_.window_px * options_.window_px) continue;
        if (exact_.Contains(u + du, v + dv)) visit(u + du, v + dv, du * du + dv * dv);
      }
    }
  }

  // The closest pixel of a nearer surface, if it is within the bleeding width. Otherwise the pixel
  // itself.
  MatchedPixel Match(int u, int v) const {
    const double reach_px = options_.window_px * NormalRatio(bleeding_(u, v));
    double closest = reach_px * reach_px;
    MatchedPixel match = {u, v};
    VisitWindow(u, v, [&](int other_u, int other_v, double squared_px) {
      if (!exact_.AreApart(u, v, other_u, other_v, options_.edge_ratio)) return;
      match.has_edge = true;
      if (squared_px > closest || exact_.Depth(other_u, other_v) >= exact_.Depth(u, v)) return;
      if (squared_px == closest && (match.u != u || match.v != v)) return;
      closest = squared_px;
      match.u = other_u;
      match.v = other_v;
    });
    return match;
  }

  double Contrast(int u, int v) const {
    double count = 0, sum = 0, squares = 0;
    VisitWindow(u, v, [&](int other_u, int other_v, double) {
      const double value = exact_.Reflectance(other_u, other_v);
      ++count;
      sum += value;
      squares += value * value;
    });
    const double mean = sum / count, variance = std::max(0., squares / count - mean * mean);
    const double z = exact_.Depth(u, v);
    const double projected = options_.projector_contrast * exact_.Reflected(u, v) / (z * z);
    return std::sqrt(variance + projected * projected);
  }

  const ExactView& exact_;
  const StereoOptions& options_;
  const Image<std::uint8_t> occluded_;
  const Image<float> noise_, bleeding_, loss_, least_;
  const double min_cosine_;
};

}  // namespace

SensorImage StereoDepth(const Rendering& exact, const PinholeCamera& camera, std::uint64_t seed,
                        const StereoOptions& options) {
  Validate(options);
  const ExactView view(exact, camera);
  const StereoMatcher matcher(view, seed, options);
  SensorImage image = {Image<float>(camera.width, camera.height, 0.f),
                       Image<float>(camera.width, camera.height, 0.f),
                       {}};
  ParallelFor(0, camera.height, kRowsPerBlock, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      for (int u = 0; u < camera.width; ++u) {
        image.depth_m(u, v) = static_cast<float>(matcher.Depth(u, v));
        if (image.depth_m(u, v) == 0) continue;
        image.inverse_depth_sigma(u, v) = static_cast<float>(options.InverseDepthSigma());
      }
    }
  });
  return image;
}

}  // namespace surfit
