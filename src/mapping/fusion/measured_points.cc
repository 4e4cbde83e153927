#include "mapping/fusion/measured_points.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "mapping/map/eight_records.h"
#include "surfit/core/lanes.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

class Points {
 public:
  Points(const Image<float>& depth_m, const FrameLevel& surface, const FusionOptions& options)
      : depth_m_(depth_m),
        surface_(surface),
        pixel_size_(std::sqrt(2.f) / static_cast<float>(surface.camera.fx)),
        max_slant_scale_(options.max_slant_scale),
        sigma_(static_cast<float>(surface.noise.inverse_depth_sigma)),
        ray_x_(depth_m.width()),
        ray_y_(depth_m.height()) {
    for (int u = 0; u < depth_m.width(); ++u) {
      ray_x_[u] = static_cast<float>(surface.camera.Ray(u, 0).x());
    }
    for (int v = 0; v < depth_m.height(); ++v) {
      ray_y_[v] = static_cast<float>(surface.camera.Ray(0, v).y());
    }
  }

  void MeasureRow(int v, MeasuredPoint* points) const {
    WithInstructions([&](auto instructions) {
      for (int u = 0; u < depth_m_.width(); u += 8) {
        MeasureEight<decltype(instructions)>(u, v, points);
      }
    });
  }

 private:
  template <typename Instructions>
  void MeasureEight(int u, int v, MeasuredPoint* points) const {
    using V = Lanes<float, Instructions>;
    static_assert(sizeof(MeasuredPoint) == 8 * sizeof(float));
    const int count = std::min(8, depth_m_.width() - u);
    const VectorImage& normal = surface_.normal;
    const V zero = 0.f, depth = V::LoadUpTo(depth_m_.row(v) + u, count);
    const V nx = V::LoadUpTo(normal.x.row(v) + u, count);
    const V ny = V::LoadUpTo(normal.y.row(v) + u, count);
    const V nz = V::LoadUpTo(normal.z.row(v) + u, count);
    const auto has_no_normal = (abs(nx) <= zero) & (abs(ny) <= zero) & (abs(nz) <= zero);
    const V slant = Min(V(1.f) / Max(abs(nz), V(1e-6f)), V(max_slant_scale_));
    const V radius = Select(has_no_normal, zero, V(pixel_size_) * depth * slant);
    const V x = V::LoadUpTo(&ray_x_[u], count) * depth, y = V(ray_y_[v]) * depth;
    const V columns[8] = {x, y, depth, nx, ny, nz, radius, zero};
    float beyond[8];
    float* records[8];
    for (int k = 0; k < 8; ++k) {
      records[k] = k < count ? reinterpret_cast<float*>(&points[u + k]) : beyond;
    }
    EightRecords<Instructions>::Store(columns, records);
    const auto at_edge = (depth > zero) & has_no_normal;
    if (!V::Any(at_edge)) return;
    float is_at_edge[8];
    Select(at_edge, V(1.f), zero).Store(is_at_edge);
    for (int k = 0; k < count; ++k) {
      if (is_at_edge[k] != 0) MeasureAtEdge(u + k, v, &points[u + k]);
    }
  }

  void MeasureAtEdge(int u, int v, MeasuredPoint* point) const {
    const Eigen::Vector3f position = Position(u, v), normal = NormalOfNeighbour(u, v, position);
    const float slant = std::min(1.f / std::max(std::fabs(normal.z()), 1e-6f), max_slant_scale_);
    point->at_edge = true;
    point->radius_m = normal.isZero(0.f) ? 0.f : pixel_size_ * depth_m_(u, v) * slant;
    point->patch = {position.x(), position.y(), position.z(), normal.x(), normal.y(), normal.z()};
  }

  Eigen::Vector3f Position(int u, int v) const {
    const float depth = depth_m_(u, v);
    return {ray_x_[u] * depth, ray_y_[v] * depth, depth};
  }

  // Normal of the neighbour pixel whose tangent plane is nearest to the point. Zero if all
  // distances exceed half a standard deviation of depth.
  Eigen::Vector3f NormalOfNeighbour(int u, int v, const Eigen::Vector3f& point) const {
    Eigen::Vector3f normal = Eigen::Vector3f::Zero();
    float nearest = 0.5f * sigma_ * point.z() * point.z();
    for (int qv = std::max(0, v - 1); qv <= std::min(depth_m_.height() - 1, v + 1); ++qv) {
      for (int qu = std::max(0, u - 1); qu <= std::min(depth_m_.width() - 1, u + 1); ++qu) {
        const Eigen::Vector3f n = surface_.normal(qu, qv);
        if (n.isZero(0.f)) continue;
        const float distance = std::fabs(n.dot(point - Position(qu, qv)));
        if (distance > nearest || !(n.dot(point) < 0)) continue;
        nearest = distance;
        normal = n;
      }
    }
    return normal;
  }

  const Image<float>& depth_m_;
  const FrameLevel& surface_;
  const float pixel_size_;
  const float max_slant_scale_;
  const float sigma_;  // standard deviation of inverse depth, 1/m
  std::vector<float> ray_x_, ray_y_;
};

}  // namespace

void MeasurePoints(const RgbdFrame& frame, const FrameLevel& surface, const FusionOptions& options,
                   std::vector<MeasuredPoint>* points) {
  const int width = surface.camera.width, height = surface.camera.height;
  const Points measured(frame.depth_m, surface, options);
  points->resize(static_cast<std::size_t>(width) * height);
  ParallelFor(0, height, kRowsPerBlock, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      measured.MeasureRow(v, &(*points)[static_cast<std::size_t>(v) * width]);
    }
  });
}

Image<float> FreeDepths(const Image<float>& depth_m, const DepthNoise& noise,
                        const FusionOptions& options) {
  const int width = depth_m.width(), height = depth_m.height();
  const float margin = options.free_space_margin_m;
  const auto inverse_depth_sigma = static_cast<float>(noise.inverse_depth_sigma);
  Image<float> along_rows, result;
  along_rows.Resize(width, height);
  result.Resize(width, height);
  const auto least_of = [width](const float* a, const float* b, const float* c, float* least) {
    WithInstructions([&](auto) {
      for (int u = 0; u < width; ++u) least[u] = std::min(std::min(a[u], b[u]), c[u]);
    });
  };
  ParallelFor(0, height, kRowsPerBlock, [&](int begin, int end) {
    std::vector<float> padded(width + 2, std::numeric_limits<float>::infinity());
    float* const own = padded.data() + 1;
    for (int v = begin; v < end; ++v) {
      const float* const depth = depth_m.row(v);
      WithInstructions([&](auto) {
        for (int u = 0; u < width; ++u) {
          const float sigma = inverse_depth_sigma * depth[u] * depth[u];
          const float free = depth[u] - margin - 4.f * sigma;
          own[u] = (depth[u] > 0) & (free > 0) ? free : 0.f;
        }
      });
      least_of(own - 1, own, own + 1, along_rows.row(v));
    }
  });
  ParallelFor(0, height, kRowsPerBlock, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      least_of(along_rows.row(std::max(0, v - 1)), along_rows.row(v),
               along_rows.row(std::min(height - 1, v + 1)), result.row(v));
    }
  });
  return result;
}

Image<float> PointWeights(const PinholeCamera& camera) {
  Image<float> weights(camera.width, camera.height);
  const double corner_u = std::max(camera.cx, camera.width - 1 - camera.cx);
  const double corner_v = std::max(camera.cy, camera.height - 1 - camera.cy);
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const double du = u - camera.cx, dv = v - camera.cy;
      const double g2 = (du * du + dv * dv) / (corner_u * corner_u + corner_v * corner_v);
      weights(u, v) = static_cast<float>(std::exp(-g2 / 0.72));
    }
  }
  return weights;
}

}  // namespace surfit
