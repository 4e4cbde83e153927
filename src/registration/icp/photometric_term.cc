#include "registration/icp/photometric_term.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>

#include "registration/icp/intensity_finder.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

constexpr int kRowsOfPoints = 8;   // per block
constexpr int kFewestPairs = 100;  // minimum for an exposure estimate

// Points of the rows [begin, end) with an intensity gradient of at least `min_slope` per px. Skips
// points without a normal: the gradient at depth edges depends on the background. Skips unknown
// intensities.
TexturedPoints PointsOfRows(const FrameLevel& level, int begin, int end, double min_slope) {
  // The central differences below span 2 px.
  const auto min_square = static_cast<float>(4 * min_slope * min_slope);
  TexturedPoints points;
  const Image<float>& image = level.intensity;
  for (int v = std::max(begin, 1); v < std::min(end, image.height() - 1); ++v) {
    for (int u = 1; u + 1 < image.width(); ++u) {
      if (level.normal.z(u, v) == 0) continue;
      const float slope_u = image(u + 1, v) - image(u - 1, v);
      const float slope_v = image(u, v + 1) - image(u, v - 1);
      if (!(slope_u * slope_u + slope_v * slope_v >= min_square)) continue;
      if (!(image(u, v) >= 0)) continue;
      points.x.push_back(level.vertex.x(u, v));
      points.y.push_back(level.vertex.y(u, v));
      points.z.push_back(level.vertex.z(u, v));
      points.intensity.push_back(image(u, v));
    }
  }
  return points;
}

struct Quartiles {
  float lower, middle, upper;
};

Quartiles QuartilesOf(RawVector<float> values) {
  const auto quantile = [&](std::size_t quarters) {
    const auto at = values.begin() + static_cast<std::ptrdiff_t>(values.size() * quarters / 4);
    std::nth_element(values.begin(), at, values.end());
    return *at;
  };
  return {quantile(1), quantile(2), quantile(3)};
}

// Exposure that equalises the quartiles of both images over the same points. A regression would
// underestimate the gain if the initial pose is inaccurate.
Exposure MatchExposure(const IntensityPairs& pairs) {
  constexpr float kFloor = 1e-3f;  // quantisation of 8-bit intensities
  const Quartiles source = QuartilesOf(pairs.source), target = QuartilesOf(pairs.target);
  const float ratio =
      (target.upper - target.lower + kFloor) / (source.upper - source.lower + kFloor);
  const float gain =
      std::clamp(ratio, static_cast<float>(1 / kMaxGain), static_cast<float>(kMaxGain));
  return {gain, target.middle - gain * source.middle};
}

}  // namespace

PhotometricTerm::PhotometricTerm(const FrameLevel& source, const FrameLevel& target,
                                 double max_distance_m, const ErrorModel& error_model,
                                 const Rigid3d& start)
    : target_(target),
      max_distance_m_(max_distance_m),
      information_(error_model.photometric_weight /
                   (error_model.intensity_sigma * error_model.intensity_sigma)),
      kernel_(error_model.intensity_kernel) {
  CHECK_EQ(source.intensity.width(), source.vertex.width());
  CHECK_EQ(target.intensity.width(), target.camera.width);
  CHECK_EQ(target.vertex.width(), target.camera.width);
  // A kernel of width k has the loss rho(s) = k^2 f(s / k^2) for a squared residual s. So W rho(s)
  // is the loss of W s with the width k sqrt(W). W: photometric weight.
  kernel_.width *= std::sqrt(error_model.photometric_weight);
  const int height = source.intensity.height();
  blocks_.resize((height + kRowsOfPoints - 1) / kRowsOfPoints);
  ParallelFor(0, height, kRowsOfPoints, [&](int begin, int end) {
    blocks_[begin / kRowsOfPoints] = PointsOfRows(source, begin, end, error_model.intensity_sigma);
  });
  const IntensityPairs pairs = Collect(start);
  if (pairs.size >= kFewestPairs) {
    exposure_ = MatchExposure(pairs);
  } else {
    blocks_.clear();
  }
}

void PhotometricTerm::Find(int block, const Rigid3d& target_from_source,
                           IntensityPairs* pairs) const {
  const TexturedPoints& points = blocks_[block];
  pairs->SetCapacity(static_cast<int>(points.x.size()) + Lanes<float>::kCount);
  pairs->size = WithInstructions([&](auto instructions) {
    return IntensityFinder<decltype(instructions)>({target_, target_from_source, max_distance_m_})
        .Find(points, 0, pairs);
  });
}

IntensityPairs PhotometricTerm::Collect(const Rigid3d& target_from_source) const {
  std::vector<IntensityPairs> found(block_count());
  ParallelFor(0, block_count(), 1,
              [&](int block, int) { Find(block, target_from_source, &found[block]); });
  IntensityPairs all;
  for (const IntensityPairs& pairs : found) all.size += pairs.size;
  all.SetCapacity(all.size);
  int first = 0;
  for (IntensityPairs& pairs : found) {
    const auto from = pairs.Arrays(), to = all.Arrays();
    for (int k = 0; k < IntensityPairs::kArrays; ++k) {
      std::copy_n(from[k]->begin(), pairs.size, to[k]->begin() + first);
    }
    first += pairs.size;
  }
  return all;
}

}  // namespace surfit
