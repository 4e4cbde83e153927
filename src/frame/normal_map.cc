#include <cmath>
#include <vector>

#include "surfit/core/parallel.h"
#include "surfit/frame/preprocess.h"

namespace surfit {
namespace {

// Least-squares slopes of inverse depth along one direction for a row of pixels: sum over offsets
// k of k (r(+k) - r(-k)) / sum 2 k^2, as far as both sides continue the surface from offset to
// offset. `rows` points into padded inverse depth; offset k lies k * stride away.
class RowSlopes {
 public:
  RowSlopes(int width, int radius, float slant, float noise)
      : width_(width),
        radius_(radius),
        slant_(slant),
        noise_(noise),
        alive_(width),
        slope_(width),
        norm_(width) {}

  // Fills slopes; norm is 0 where not even the nearest offset continues the surface.
  void Compute(const float* center, std::ptrdiff_t stride) {
    for (int u = 0; u < width_; ++u) {
      alive_[u] = center[u] > 0 ? 1.f : 0.f;
      slope_[u] = 0;
      norm_[u] = 0;
    }
    for (int k = 1; k <= radius_; ++k) AddOffset(center, stride, k);
  }

  float slope(int u) const { return slope_[u] / norm_[u]; }
  bool valid(int u) const { return norm_[u] > 0; }

 private:
  void AddOffset(const float* center, std::ptrdiff_t stride, int k) {
    const float step = static_cast<float>(k);
    const float *ahead = center + k * stride, *behind = center - k * stride;
    const float *before_ahead = ahead - stride, *before_behind = behind + stride;
    for (int u = 0; u < width_; ++u) {
      const float bound = noise_ + slant_ * center[u];
      const bool continues = std::fabs(ahead[u] - before_ahead[u]) < bound &&
                             std::fabs(behind[u] - before_behind[u]) < bound && ahead[u] > 0 &&
                             behind[u] > 0;
      alive_[u] = continues ? alive_[u] : 0.f;
      slope_[u] += alive_[u] * step * (ahead[u] - behind[u]);
      norm_[u] += alive_[u] * 2.f * step * step;
    }
  }

  int width_;
  int radius_;
  float slant_;
  float noise_;
  std::vector<float> alive_, slope_, norm_;
};

}  // namespace

VectorImage NormalMap(const VectorImage& vertex, const PinholeCamera& camera,
                      const PreprocessOptions& options) {
  const int width = vertex.width(), height = vertex.height();
  const int radius = options.normal_radius_px;
  Image<float> inverse(width + 2 * radius, height + 2 * radius, 0.f);
  ParallelFor(0, height, 16, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      const float* z = vertex.z.row(v);
      float* out = inverse.row(v + radius) + radius;
      for (int u = 0; u < width; ++u) out[u] = z[u] > 0 ? 1.f / z[u] : 0.f;
    }
  });

  VectorImage normal;
  normal.Resize(width, height);
  const float tan_slant = static_cast<float>(std::tan(options.max_slant_rad));
  const float noise = static_cast<float>(3 * options.noise.inverse_depth_sigma);
  const float fx = static_cast<float>(camera.fx), fy = static_cast<float>(camera.fy);
  ParallelFor(0, height, 16, [&](int begin, int end) {
    RowSlopes along_u(width, radius, tan_slant / fx, noise);
    RowSlopes along_v(width, radius, tan_slant / fy, noise);
    for (int v = begin; v < end; ++v) {
      const float* center = inverse.row(v + radius) + radius;
      along_u.Compute(center, 1);
      along_v.Compute(center, inverse.width());
      const float dv = static_cast<float>(v - camera.cy);
      for (int u = 0; u < width; ++u) {
        float nx = 0, ny = 0, nz = 0;
        if (along_u.valid(u) && along_v.valid(u)) {
          const float du = static_cast<float>(u - camera.cx);
          const float slope_u = along_u.slope(u), slope_v = along_v.slope(u);
          // n . X = d with d < 0 for a normal that faces the camera: the negative of the formula.
          nx = -fx * slope_u;
          ny = -fy * slope_v;
          nz = -(center[u] - du * slope_u - dv * slope_v);
          const float scale = 1.f / std::sqrt(nx * nx + ny * ny + nz * nz);
          nx *= scale, ny *= scale, nz *= scale;
        }
        normal.x(u, v) = nx;
        normal.y(u, v) = ny;
        normal.z(u, v) = nz;
      }
    }
  });
  return normal;
}

}  // namespace surfit
