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

// A disc where the ray of one pixel meets it.
struct Fragment {
  std::int32_t surfel;
  int pixel;
  float depth;
  float offset2;  // from the disc's centre, squared, as a share of its drawn radius
  bool stable;
};

// Finds the pixels that discs cover.
class Splatter {
 public:
  Splatter(const SurfelMap& map, const PosedCamera& camera, const RenderOptions& options)
      : map_(map), camera_(camera), options_(options) {}

  // Calls visit(Fragment) for all discs, in parallel.
  template <typename Visit>
  void ForEachFragment(const Visit& visit) const {
    ParallelFor(0, static_cast<int>(map_.size()), 16 * ProjectedChunk::kCapacity,
                [&](int begin, int end) {
                  for (int i = begin; i < end; i += ProjectedChunk::kCapacity) {
                    SplatChunk(i, std::min(end, i + ProjectedChunk::kCapacity), visit);
                  }
                });
  }

 private:
  template <typename Visit>
  void SplatChunk(int begin, int end, const Visit& visit) const {
    ProjectedChunk chunk;
    chunk.Project(map_, camera_, begin, end);
    const float margin = static_cast<float>(options_.max_half_window_px);
    for (int k = 0; k < end - begin; ++k) {
      const float u = chunk.u[k], v = chunk.v[k];
      if (u > -margin && v > -margin && u < static_cast<float>(camera_.width) + margin &&
          v < static_cast<float>(camera_.height) + margin) {
        Splat(begin + k, {chunk.x[k], chunk.y[k], chunk.z[k]}, u, v, visit);
      }
    }
  }

  template <typename Visit>
  void Splat(int i, const Eigen::Vector3f& p, float u, float v, const Visit& visit) const {
    const Eigen::Vector3f n = camera_.NormalInCamera(map_, i);
    if (!(n.dot(p) < 0)) return;
    const DiscPlane plane(p, n, camera_);
    const bool stable = map_.confidence[i] >= options_.stable_confidence;
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
        const float offset2 =
            (PointAtDepth(camera_, pu, pv, depth) - p).squaredNorm() / (radius * radius);
        if (offset2 <= 1) visit(Fragment{i, pv * camera_.width + pu, depth, offset2, stable});
      }
    }
  }

  const SurfelMap& map_;
  const PosedCamera& camera_;
  const RenderOptions& options_;
};

// Discs up to this depth are the same surface as the first disc.
float BackOfSurface(float first_depth, const RenderOptions& options) {
  const float sigma =
      static_cast<float>(options.noise.inverse_depth_sigma) * first_depth * first_depth;
  return first_depth + options.surface_thickness_m + 4.f * sigma;
}

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
  require(surface_thickness_m >= 0, "surface_thickness_m", surface_thickness_m, "zero or positive");
  require(noise.inverse_depth_sigma >= 0, "inverse_depth_sigma", noise.inverse_depth_sigma,
          "zero or positive");
}

ModelRenderer::ModelRenderer(const RenderOptions& options) : options_(options) {
  options.Validate();
}

ModelView ModelRenderer::Render(const SurfelMap& map, const PinholeCamera& camera,
                                const Rigid3d& world_from_view) {
  const int width = camera.width, height = camera.height;
  ResetMinima(static_cast<std::size_t>(width) * height, &first_);
  ResetMinima(static_cast<std::size_t>(width) * height, &drawn_);
  const PosedCamera posed(camera, world_from_view);
  const Splatter splatter(map, posed, options_);
  splatter.ForEachFragment([&](const Fragment& f) {
    const std::uint64_t class_bit = f.stable ? 0 : kUnstableBit;
    LowerTo(class_bit | MinimumKey(f.depth, 0), &first_[f.pixel]);
  });
  splatter.ForEachFragment([&](const Fragment& f) {
    const std::uint64_t first = first_[f.pixel].load(std::memory_order_relaxed);
    const bool first_is_stable = (first & kUnstableBit) == 0;
    if (f.stable != first_is_stable) return;
    if (f.depth > BackOfSurface(ValueOfKey(first & ~kUnstableBit), options_)) return;
    LowerTo(MinimumKey(f.offset2, f.surfel), &drawn_[f.pixel]);
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
        const std::uint64_t key = drawn_[v * width + u].load(std::memory_order_relaxed);
        if (key != kNoMinimum) Resolve(map, posed, IndexOfKey(key), u, v, &view);
      }
    }
  });
  return view;
}

}  // namespace surfit
