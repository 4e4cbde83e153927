#include "frame/inverse_depth_band.h"
#include "frame/surface_slope.h"
#include "surfit/core/lanes.h"
#include "surfit/core/parallel.h"
#include "surfit/frame/preprocess.h"

namespace surfit {
namespace {

constexpr int kRowsPerBlock = 16;

// Zeroes the normals of a row where a neighbour does not continue the surface.
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
