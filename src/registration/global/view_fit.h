#pragma once

#include <algorithm>
#include <vector>

#include "surfit/core/image.h"
#include "surfit/frame/frame_pyramid.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/registration/error_model.h"

namespace surfit {

// How bright one pyramid level of a frame is.
struct BrightnessLevel {
  Image<float> value;   // 0 = black, 1 = white
  Image<float> detail;  // value less its mean over some pixels: edges and texture without shading
};

// With the detail of these values.
BrightnessLevel BrightnessOf(Image<float> value);

// As many levels as asked for, each further one the mean of 2 x 2 pixels like HalfResolution();
// all zero where there is no colour.
std::vector<BrightnessLevel> BrightnessPyramid(const Image<Rgb8>& color, int width, int height,
                                               int levels);

// The brightness `halvings` levels below that of the colours, without detail; empty without
// colours.
BrightnessLevel CoarseBrightness(const Image<Rgb8>& color, int halvings);

// One resolution of a frame: shape and brightness of the same pixels.
struct ViewLevel {
  const FrameLevel& surface;
  const BrightnessLevel& brightness;
};

// Surfaces of two views are the same only if their normals differ by no more.
inline constexpr float kMinNormalCosine = 0.8f;

// Where a source pixel with depth lands in the target's image.
struct Landing {
  int source_pixel = 0;   // index of the source pixel
  int target_pixel = 0;   // and of the target pixel nearest to
  float u = 0, v = 0;     // where it lands, px
  Eigen::Vector3f point;  // p' = R p + t, metres
};

// Calls visit(landing) for each, row by row, of every n-th column and row of the source.
template <typename Visit>
void ForEachLanding(const FrameLevel& source, const FrameLevel& target,
                    const Rigid3d& target_from_source, const Visit& visit, int stride = 1) {
  constexpr float kNearest = 0.05f;  // m; closer to the camera's plane pixels fly apart
  const Eigen::Matrix3f rotation = target_from_source.rotation.toRotationMatrix().cast<float>();
  const Eigen::Vector3f translation = target_from_source.translation.cast<float>();
  const PinholeCamera& camera = target.camera;
  const auto fx = static_cast<float>(camera.fx), fy = static_cast<float>(camera.fy);
  const auto cx = static_cast<float>(camera.cx), cy = static_cast<float>(camera.cy);
  const float right = static_cast<float>(camera.width) - 0.5f;
  const float bottom = static_cast<float>(camera.height) - 0.5f;
  const VectorImage& vertex = source.vertex;
  const auto on_pixel = [&](int i) {
    if (!(vertex.z[i] > 0)) return;
    const Eigen::Vector3f vertex_i(vertex.x[i], vertex.y[i], vertex.z[i]);
    Landing landing;
    landing.point = rotation * vertex_i + translation;
    if (!(landing.point.z() > kNearest)) return;
    landing.u = fx * landing.point.x() / landing.point.z() + cx;
    landing.v = fy * landing.point.y() / landing.point.z() + cy;
    if (!(landing.u >= -0.5f && landing.v >= -0.5f && landing.u < right && landing.v < bottom)) {
      return;
    }
    landing.source_pixel = i;
    const float from_left = landing.u + 0.5f, from_top = landing.v + 0.5f;  // not negative
    landing.target_pixel = static_cast<int>(from_top) * camera.width + static_cast<int>(from_left);
    visit(landing);
  };
  for (int v = stride / 2; v < vertex.height(); v += stride) {
    for (int u = stride / 2; u < vertex.width(); u += stride) on_pixel(v * vertex.width() + u);
  }
}

inline Eigen::Vector3f At(const VectorImage& image, int pixel) {
  return {image.x[pixel], image.y[pixel], image.z[pixel]};
}

// A value between four pixels, and how it changes per pixel.
struct BilinearSample {
  float value = 0;
  float slope_u = 0;
  float slope_v = 0;
};

// At a place within half a pixel of the image, which is at least 2 x 2; beyond the outermost pixel
// centres it goes on linearly.
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

// A point farther in front of a surface than so many sigmas contradicts it.
inline constexpr double kFreeSpaceSigmas = 5;

// How far the source contradicts the target at a pose: a source point p' in front of the surface
// (vertex q, normal n facing the camera) at the target pixel it projects to fills space that the
// target camera saw through. Returns the share of points with r > kFreeSpaceSigmas * sigma among
// those with r >= -kFreeSpaceSigmas * sigma,
//   r = n . (p' - q),  sigma^2 = floor_sigma_m^2 + sigma_z(p'_z)^2 + sigma_z(q_z)^2.
// Points behind may be hidden and say nothing, nor do pixels without a normal (missing depth, depth
// edges); 0 where no point says anything. Two views of a rigid scene hardly contradict each other
// at the true pose, while a fit of some surfaces to others leaves the rest in each other's free
// space.
double FreeSpaceShare(const FrameLevel& source, const FrameLevel& target,
                      const ErrorModel& error_model, const Rigid3d& target_from_source);

// Sums that the correlation of two images follows from.
struct CorrelationSums {
  double count = 0, a = 0, b = 0, aa = 0, bb = 0, ab = 0;

  void Add(double value_a, double value_b);
  // From -1 to 1; near 0 where an image is even: `floor_variance` is added to both variances.
  double Correlation(double floor_variance) const;
};

// How well two views agree at a pose: the correlations are means of both ways.
struct ViewFit {
  double overlap_share = 0;       // of all points, those that lie on the other view's surface
  double free_space_share = 0;    // the larger share of telling points in the other's free space
  double value_correlation = 0;   // of the brightness where the surfaces lie on each other
  double detail_correlation = 0;  // and of its detail

  // The larger, the better: the square root of the overlap, times what the images tell of each
  // other in nats per pixel (for normally distributed values, -log(1 - rho^2) / 2) and a constant
  // for the shapes, less where free space is filled. The root, as sliding along what the shapes
  // leave open often adds overlap where hardly anything tells.
  double Score() const;
};

// Surfaces lie on each other where the distance is within kFreeSpaceSigmas of the error model and
// the normals agree. Of both views every n-th column and row is taken.
ViewFit MeasureFit(const ViewLevel& source, const ViewLevel& target, const ErrorModel& error_model,
                   const Rigid3d& target_from_source, int stride = 1);

}  // namespace surfit
