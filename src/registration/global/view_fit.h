#pragma once

#include <algorithm>
#include <vector>

#include "registration/global/projections.h"
#include "surfit/core/image.h"
#include "surfit/frame/frame_pyramid.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/registration/error_model.h"

namespace surfit {

struct BrightnessLevel {
  Image<float> value;   // 0: black, 1: white
  Image<float> detail;  // value minus its local mean: edges and texture without shading
};

// Computes the detail of an image.
BrightnessLevel BrightnessOf(Image<float> value);

// Pyramid with `levels` levels. Each level averages 2 x 2 pixels of the previous one, as in
// HalfResolution(). All values are 0 without colour. Aborts if a colour image does not have this
// size.
std::vector<BrightnessLevel> BrightnessPyramid(const Image<Rgb8>& color, int width, int height,
                                               int levels);

// Brightness at 1 / 2^halvings of the resolution of `color`. `detail` is empty. Empty without
// colour.
BrightnessLevel CoarseBrightness(const Image<Rgb8>& color, int halvings);

// One pyramid level: geometry and brightness of the same pixels. Keeps references.
struct ViewLevel {
  const FrameLevel& surface;
  const BrightnessLevel& brightness;
};

// Minimum cosine between the normals of equal surfaces.
inline constexpr float kMinNormalCosine = 0.8f;

inline Eigen::Vector3f At(const VectorImage& image, int pixel) {
  return {image.x[pixel], image.y[pixel], image.z[pixel]};
}

// Bilinear interpolation of an image, and its derivatives per pixel.
struct BilinearSample {
  float value = 0;
  float slope_u = 0;
  float slope_v = 0;
};

// Requires an image of at least 2 x 2 pixels, and (u, v) within half a pixel of it. Extrapolates
// linearly outside the outermost pixel centres.
inline BilinearSample SampleAt(const Image<float>& image, float u, float v) {
  const int left = std::clamp(static_cast<int>(u), 0, image.width() - 2);
  const int top = std::clamp(static_cast<int>(v), 0, image.height() - 2);
  const float a = u - static_cast<float>(left), b = v - static_cast<float>(top);
  const float *const upper = image.row(top) + left, *const lower = image.row(top + 1) + left;
  const float on_top = upper[0] + a * (upper[1] - upper[0]);
  const float below = lower[0] + a * (lower[1] - lower[0]);
  return {on_top + b * (below - on_top),
          (1 - b) * (upper[1] - upper[0]) + b * (lower[1] - lower[0]), below - on_top};
}

// Minimum distance of a free-space violation from the surface, in sigmas.
inline constexpr double kFreeSpaceSigmas = 5;

// Ratio of free-space violations of the source in the target view. A source point p' violates free
// space if it is in front of the surface (vertex q, normal n facing the camera) at its target
// pixel. The ratio is the number of points with r > kFreeSpaceSigmas * sigma, divided by the number
// of points with r >= -kFreeSpaceSigmas * sigma, where
//   r = n . (p' - q),  sigma^2 = floor_sigma_m^2 + sigma_z(p'_z)^2 + sigma_z(q_z)^2.
// Points behind the surface can be occluded and are ignored. Pixels without a normal (missing
// depth, depth edges) are ignored, too. Returns 0 without usable points. Views of a rigid scene
// have few violations at the true pose, and many at a wrong pose.
double FreeSpaceViolationRatio(const FrameLevel& source, const FrameLevel& target,
                               const ErrorModel& error_model, const Rigid3d& target_from_source);

struct CorrelationSums {
  double count = 0, a = 0, b = 0, aa = 0, bb = 0, ab = 0;

  void Add(double value_a, double value_b);
  // Correlation from -1 to 1. `floor_variance` is added to both variances, so that the result is
  // near 0 for uniform images. 0 without values.
  double Correlation(double floor_variance) const;
};

// Agreement of two views at a pose. Correlations are averages over both directions.
struct ViewFit {
  double overlap_ratio = 0;               // ratio of points on the surface of the other view
  double free_space_violation_ratio = 0;  // larger ratio of both directions, see MeasureFit()
  double value_correlation = 0;           // brightness correlation in the overlap
  double detail_correlation = 0;          // correlation of the brightness detail

  // Score of a fit; larger is better:
  //   sqrt(overlap_ratio) * (1 + I(value_correlation) + 2 I(detail_correlation)),
  // reduced by free-space violations. I(rho) = -log(1 - rho^2) / 2 is the mutual information of
  // normally distributed values, in nats per pixel, with rho limited to [0, 0.98]. The square root
  // limits the gain from sliding along unconstrained directions, which adds overlap.
  double Score() const;
};

// Evaluates every stride-th row and column of both views. Value and detail must have the size of
// the surface. All ratios are 0 without valid points. Surfaces overlap if their distance is within
// kFreeSpaceSigmas and their normals agree. Unlike FreeSpaceViolationRatio(), the ratio of
// violations ignores other points at the surface.
ViewFit MeasureFit(const ViewLevel& source, const ViewLevel& target, const ErrorModel& error_model,
                   const Rigid3d& target_from_source, int stride = 1);

}  // namespace surfit
