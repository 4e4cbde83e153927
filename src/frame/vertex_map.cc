#include <utility>

#include "surfit/core/parallel.h"
#include "surfit/frame/preprocess.h"

namespace surfit {

VectorImage VertexMap(Image<float> depth_m, const PinholeCamera& camera) {
  const int width = depth_m.width(), height = depth_m.height();
  VectorImage vertex;
  vertex.x.Resize(width, height);
  vertex.y.Resize(width, height);
  vertex.z = std::move(depth_m);
  const float inverse_fx = static_cast<float>(1 / camera.fx);
  const float cx = static_cast<float>(camera.cx);
  ParallelFor(0, height, 16, [&](int begin, int end) {
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
  return vertex;
}

}  // namespace surfit
