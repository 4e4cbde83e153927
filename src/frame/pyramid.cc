#include <utility>

#include "frame/surface_slope.h"
#include "surfit/core/lanes.h"
#include "surfit/core/parallel.h"
#include "surfit/frame/preprocess.h"

namespace surfit {
namespace {

constexpr int kMinWidth = 40;
constexpr int kMinHeight = 30;

template <typename V>
struct Block {
  V pixel[4];
};

// Loads up to `count` blocks of 2 x 2 pixels. (u, v): column and row of the first block.
template <typename V>
Block<V> LoadBlocks(const Image<float>& image, int u, int v, int count) {
  Block<V> block;
  for (int i = 0; i < 2; ++i) {
    const float* const row = &image(2 * u, 2 * v + i);
    const V low = V::LoadUpTo(row, 2 * count);
    const V high =
        2 * count > V::kCount ? V::LoadUpTo(row + V::kCount, 2 * count - V::kCount) : V(0.);
    block.pixel[2 * i] = Evens(low, high);
    block.pixel[2 * i + 1] = Odds(low, high);
  }
  return block;
}

// Computes row v of the coarse level. Each coarse pixel is the mean of the fine pixels that lie on
// the nearest surface of its 2 x 2 block.
template <typename V>
void HalveRow(const FrameLevel& fine, const EdgeBounds& bounds, int v, Image<float>* depth_m,
              VectorImage* normal) {
  const int width = depth_m->width();
  for (int u = 0; u < width; u += V::kCount) {
    const int count = width - u;
    Block<V> inverse = LoadBlocks<V>(fine.vertex.z, u, v, count);
    V nearest;
    for (V& r : inverse.pixel) {
      r = Select(r > 0., 1. / r, 0.);
      nearest = Max(nearest, r);
    }
    const V bound = nearest - (bounds.noise + bounds.slant_u * nearest);
    const auto is_near = [&](const V& r) { return (r >= bound) & (r > 0.); };
    V sum, near_count;
    for (const V& r : inverse.pixel) {
      sum += Select(is_near(r), r, 0.);
      near_count += Select(is_near(r), V(1.), 0.);
    }
    Select(sum > 0., near_count / sum, 0.).StoreUpTo(depth_m->row(v) + u, count);

    const auto near_sum = [&](const Image<float>& image) {
      const Block<V> block = LoadBlocks<V>(image, u, v, count);
      V total;
      for (int i = 0; i < 4; ++i) total += Select(is_near(inverse.pixel[i]), block.pixel[i], 0.);
      return total;
    };
    const V x = near_sum(fine.normal.x), y = near_sum(fine.normal.y), z = near_sum(fine.normal.z);
    const V norm = sqrt(x * x + y * y + z * z);
    const auto has_normal = norm > 0.;
    Select(has_normal, x / norm, 0.).StoreUpTo(normal->x.row(v) + u, count);
    Select(has_normal, y / norm, 0.).StoreUpTo(normal->y.row(v) + u, count);
    Select(has_normal, z / norm, 0.).StoreUpTo(normal->z.row(v) + u, count);
  }
}

}  // namespace

FrameLevel HalfResolution(const FrameLevel& fine, const PreprocessOptions& options) {
  FrameLevel coarse;
  coarse.camera = fine.camera.Binned(2);
  coarse.noise = fine.noise;
  const int width = coarse.camera.width, height = coarse.camera.height;
  coarse.normal.Resize(width, height);
  Image<float> depth_m;
  depth_m.Resize(width, height);
  const EdgeBounds bounds(fine.sensor(), options);
  ParallelFor(0, height, kRowsPerBlock, [&](int begin, int end) {
    WithInstructions([&](auto instructions) {
      using V = Lanes<float, decltype(instructions)>;
      for (int v = begin; v < end; ++v) HalveRow<V>(fine, bounds, v, &depth_m, &coarse.normal);
    });
  });
  coarse.vertex = VertexMap(std::move(depth_m), coarse.camera);
  return coarse;
}

FramePyramid BuildPyramid(FrameLevel finest, const PreprocessOptions& options) {
  FramePyramid pyramid;
  pyramid.levels.push_back(std::move(finest));
  while (static_cast<int>(pyramid.levels.size()) < options.pyramid_levels &&
         pyramid.levels.back().camera.width / 2 >= kMinWidth &&
         pyramid.levels.back().camera.height / 2 >= kMinHeight) {
    pyramid.levels.push_back(HalfResolution(pyramid.levels.back(), options));
  }
  return pyramid;
}

FramePyramid PreprocessDepth(const Image<float>& depth_m, const DepthSensor& sensor,
                             const PreprocessOptions& options) {
  FrameLevel finest;
  finest.camera = sensor.camera;
  finest.noise = sensor.noise;
  finest.vertex = VertexMap(FilterDepth(depth_m, sensor.noise, options), sensor.camera);
  finest.normal = NormalMap(finest.vertex, sensor, options);
  return BuildPyramid(std::move(finest), options);
}

VectorImage VertexMap(Image<float> depth_m, const PinholeCamera& camera) {
  const int width = depth_m.width(), height = depth_m.height();
  VectorImage vertex;
  vertex.x.Resize(width, height);
  vertex.y.Resize(width, height);
  vertex.z = std::move(depth_m);
  const float inverse_fx = static_cast<float>(1 / camera.fx);
  const float cx = static_cast<float>(camera.cx);
  ParallelFor(0, height, 16, [&](int begin, int end) {
    WithInstructions([&](auto) {
      for (int v = begin; v < end; ++v) {
        const float ray_y = static_cast<float>((v - camera.cy) / camera.fy);
        const float* const z = vertex.z.row(v);
        float *x = vertex.x.row(v), *y = vertex.y.row(v);
        for (int u = 0; u < width; ++u) {
          x[u] = z[u] * ((static_cast<float>(u) - cx) * inverse_fx);
          y[u] = z[u] * ray_y;
        }
      }
    });
  });
  return vertex;
}

}  // namespace surfit
