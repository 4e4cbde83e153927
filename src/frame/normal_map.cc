#include <vector>

#include "frame/inverse_depth_band.h"
#include "frame/surface_slope.h"
#include "surfit/core/lanes.h"
#include "surfit/core/parallel.h"
#include "surfit/frame/preprocess.h"

namespace surfit {
namespace {

class NormalRows {
 public:
  NormalRows(const DepthSensor& sensor, const PreprocessOptions& options)
      : bounds_(sensor, options),
        radius_(options.normal_radius_px),
        fx_(static_cast<float>(sensor.camera.fx)),
        fy_(static_cast<float>(sensor.camera.fy)),
        cy_(sensor.camera.cy),
        du_(sensor.camera.width + Lanes<float>::kCount) {
    for (int u = 0; u < sensor.camera.width; ++u) {
      du_[u] = static_cast<float>(u - sensor.camera.cx);
    }
  }

  int radius() const { return radius_; }

  // Computes row v. Requires radius() == radius.
  template <typename V, typename Radius>
  void Compute(const InverseDepthBand& band, int v, Radius radius, VectorImage* normal) const {
    const int width = normal->width();
    const float* const row = band.row(v);
    const V dv(static_cast<float>(v - cy_));
    for (int u = 0; u < width; u += V::kCount) {
      const V r = V::Load(row + u);
      const auto along_u = SlopeAlong<V>(row + u, 1, radius, bounds_.noise + bounds_.slant_u * r);
      const auto along_v =
          SlopeAlong<V>(row + u, band.stride(), radius, bounds_.noise + bounds_.slant_v * r);
      // The formula of NormalMap() with the sign that turns the normal towards the camera.
      const V nx = -fx_ * along_u.value, ny = -fy_ * along_v.value;
      const V nz = V::Load(du_.data() + u) * along_u.value + dv * along_v.value - r;
      const V scale = 1. / sqrt(nx * nx + ny * ny + nz * nz);
      const auto valid = along_u.valid & along_v.valid;
      Select(valid, nx * scale, 0.).StoreUpTo(normal->x.row(v) + u, width - u);
      Select(valid, ny * scale, 0.).StoreUpTo(normal->y.row(v) + u, width - u);
      Select(valid, nz * scale, 0.).StoreUpTo(normal->z.row(v) + u, width - u);
    }
  }

 private:
  EdgeBounds bounds_;
  int radius_;
  float fx_, fy_;
  double cy_;
  std::vector<float> du_;
};

template <typename V>
void DropRow(const InverseDepthBand& band, const EdgeBounds& bounds, int v, VectorImage* normal) {
  const int width = normal->width();
  const float* const row = band.row(v);
  for (int u = 0; u < width; u += V::kCount) {
    const V r = V::Load(row + u);
    const auto inside = Continues<V>(row + u, 1, 1, bounds.noise + bounds.slant_u * r) &
                        Continues<V>(row + u, band.stride(), 1, bounds.noise + bounds.slant_v * r);
    for (Image<float>* plane : {&normal->x, &normal->y, &normal->z}) {
      float* const n = plane->row(v) + u;
      Select(inside, V::LoadUpTo(n, width - u), 0.).StoreUpTo(n, width - u);
    }
  }
}

}  // namespace

VectorImage NormalMap(const VectorImage& vertex, const DepthSensor& sensor,
                      const PreprocessOptions& options) {
  const int width = vertex.width(), height = vertex.height();
  const NormalRows rows(sensor, options);
  VectorImage normal;
  normal.Resize(width, height);
  ParallelFor(0, height, kRowsPerBlock, [&](int begin, int end) {
    InverseDepthBand band(width, end - begin, options.normal_radius_px);
    WithInstructions([&](auto instructions) {
      using V = Lanes<float, decltype(instructions)>;
      band.Fill<V>(vertex.z, begin, end, 1);
      WithConstant<PreprocessOptions().normal_radius_px>(rows.radius(), [&](auto radius) {
        for (int v = begin; v < end; ++v) rows.Compute<V>(band, v, radius, &normal);
      });
    });
  });
  return normal;
}

void DropNormalsAtEdges(const PreprocessOptions& options, FrameLevel* surface) {
  const int width = surface->vertex.width(), height = surface->vertex.height();
  const EdgeBounds bounds(surface->sensor(), options);
  ParallelFor(0, height, kRowsPerBlock, [&](int begin, int end) {
    InverseDepthBand band(width, end - begin, 1);
    WithInstructions([&](auto instructions) {
      using V = Lanes<float, decltype(instructions)>;
      band.Fill<V>(surface->vertex.z, begin, end, 1);
      for (int v = begin; v < end; ++v) DropRow<V>(band, bounds, v, &surface->normal);
    });
  });
}

}  // namespace surfit
