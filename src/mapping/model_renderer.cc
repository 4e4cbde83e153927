#include "surfit/mapping/model_renderer.h"

#include <algorithm>
#include <cmath>

#include "mapping/atomic_minimum.h"
#include "mapping/surfel_projection.h"
#include "surfit/core/error.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

constexpr std::uint64_t kUnstableBit = std::uint64_t{1} << 63;

// The plane of a surfel and the rays of pixels: the ray (x, y, 1) meets n . X = n . p at depth
// (n . p) / (n . ray), and n . ray is linear in pixel coordinates.
struct DiscPlane {
  DiscPlane(const Eigen::Vector3f& p, const Eigen::Vector3f& n, const PosedCamera& camera)
      : offset(n.dot(p)),
        slope_u(n.x() / camera.fx),
        slope_v(n.y() / camera.fy),
        constant(n.z() - slope_u * camera.cx - slope_v * camera.cy) {}

  float Depth(int u, int v) const {
    return offset / (slope_u * static_cast<float>(u) + slope_v * static_cast<float>(v) + constant);
  }

  float offset, slope_u, slope_v, constant;
};

// The largest integer not above x, for x > -1024: a conversion alone, unlike std::floor.
int Floor(float x) { return static_cast<int>(x + 1024.f) - 1024; }

Eigen::Vector3f PointAtDepth(const PosedCamera& camera, int u, int v, float depth) {
  return {depth * ((static_cast<float>(u) - camera.cx) / camera.fx),
          depth * ((static_cast<float>(v) - camera.cy) / camera.fy), depth};
}

// Offers a disc to the pixels that it covers.
class Splatter {
 public:
  Splatter(const SurfelMap& map, const PosedCamera& camera, const RenderOptions& options,
           std::vector<std::atomic<std::uint64_t>>* nearest)
      : map_(map), camera_(camera), options_(options), nearest_(nearest->data()) {}

  void SplatChunk(int begin, int end) const {
    ProjectedChunk chunk;
    chunk.Project(map_, camera_, begin, end);
    const float margin = static_cast<float>(options_.max_half_window_px);
    for (int k = 0; k < end - begin; ++k) {
      const float u = chunk.u[k], v = chunk.v[k];
      if (u > -margin && v > -margin && u < static_cast<float>(camera_.width) + margin &&
          v < static_cast<float>(camera_.height) + margin) {
        Splat(begin + k, {chunk.x[k], chunk.y[k], chunk.z[k]}, u, v);
      }
    }
  }

 private:
  void Splat(int i, const Eigen::Vector3f& p, float u, float v) const {
    const Eigen::Vector3f n = camera_.NormalInCamera(map_, i);
    if (!(n.dot(p) < 0)) return;
    const DiscPlane plane(p, n, camera_);
    const std::uint64_t unstable =
        map_.confidence[i] < options_.stable_confidence ? kUnstableBit : 0;
    const float radius = options_.radius_share * map_.radius_m[i];
    const float extent =
        std::min(camera_.fx * radius / p.z(), static_cast<float>(options_.max_half_window_px));
    const int u_begin = std::max(0, Floor(u - extent) + 1);
    const int u_end = std::min(camera_.width - 1, Floor(u + extent));
    const int v_begin = std::max(0, Floor(v - extent) + 1);
    const int v_end = std::min(camera_.height - 1, Floor(v + extent));
    for (int pv = v_begin; pv <= v_end; ++pv) {
      for (int pu = u_begin; pu <= u_end; ++pu) {
        const float depth = plane.Depth(pu, pv);
        if (!(depth > 0)) continue;  // a steep disc close by: the ray meets its plane behind us
        const Eigen::Vector3f x = PointAtDepth(camera_, pu, pv, depth);
        if (!((x - p).squaredNorm() <= radius * radius)) continue;
        LowerTo(unstable | MinimumKey(depth, i), &nearest_[pv * camera_.width + pu]);
      }
    }
  }

  const SurfelMap& map_;
  const PosedCamera& camera_;
  const RenderOptions& options_;
  std::atomic<std::uint64_t>* nearest_;
};

// Writes what the pixel (u, v) sees of surfel i.
void Resolve(const SurfelMap& map, const PosedCamera& camera, int i, int u, int v,
             ModelView* view) {
  const Eigen::Vector3f n = camera.NormalInCamera(map, i);
  const DiscPlane plane(camera.PositionInCamera(map, i), n, camera);
  view->surface.vertex.Set(u, v, PointAtDepth(camera, u, v, plane.Depth(u, v)));
  view->surface.normal.Set(u, v, n);
  view->color(u, v) = map.Color(i);
  view->surfel_index(u, v) = i;
}

}  // namespace

void RenderOptions::Validate() const {
  const auto require = [](bool holds, const char* field, double value, const char* constraint) {
    if (!holds) throw InputError(Concat(field, " is ", value, ", must be ", constraint));
  };
  require(stable_confidence >= 0, "stable_confidence", stable_confidence, "zero or positive");
  require(radius_share > 0, "radius_share", radius_share, "positive");
  require(max_half_window_px >= 0 && max_half_window_px <= 64, "max_half_window_px",
          max_half_window_px, "from 0 to 64");
}

ModelRenderer::ModelRenderer(const RenderOptions& options) : options_(options) {
  options.Validate();
}

ModelView ModelRenderer::Render(const SurfelMap& map, const PinholeCamera& camera,
                                const Rigid3d& world_from_view) {
  const int width = camera.width, height = camera.height;
  ResetMinima(static_cast<std::size_t>(width) * height, &nearest_);
  const PosedCamera posed(camera, world_from_view);
  const Splatter splatter(map, posed, options_, &nearest_);
  ParallelFor(0, static_cast<int>(map.size()), 16 * ProjectedChunk::kCapacity,
              [&](int begin, int end) {
                for (int i = begin; i < end; i += ProjectedChunk::kCapacity) {
                  splatter.SplatChunk(i, std::min(end, i + ProjectedChunk::kCapacity));
                }
              });

  ModelView view;
  view.world_from_view = world_from_view;
  view.surface.camera = camera;
  view.surface.vertex = VectorImage(width, height);
  view.surface.normal = VectorImage(width, height);
  view.color = Image<Rgb8>(width, height);
  view.surfel_index = Image<std::int32_t>(width, height, ModelView::kNoSurfel);
  ParallelFor(0, height, 8, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      for (int u = 0; u < width; ++u) {
        const std::uint64_t key = nearest_[v * width + u].load(std::memory_order_relaxed);
        if (key != kNoMinimum) Resolve(map, posed, IndexOfKey(key), u, v, &view);
      }
    }
  });
  return view;
}

}  // namespace surfit
