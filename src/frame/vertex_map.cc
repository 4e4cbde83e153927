#include "surfit/core/parallel.h"
#include "surfit/frame/preprocess.h"

namespace surfit {

VectorImage VertexMap(const Image<float>& depth_m, const PinholeCamera& camera) {
  VectorImage vertex;
  vertex.Resize(depth_m.width(), depth_m.height());
  ParallelFor(0, depth_m.height(), 16, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      const float* depth = depth_m.row(v);
      const float ray_y = static_cast<float>((v - camera.cy) / camera.fy);
      const float inverse_fx = static_cast<float>(1 / camera.fx);
      const float cx = static_cast<float>(camera.cx);
      float *x = vertex.x.row(v), *y = vertex.y.row(v), *z = vertex.z.row(v);
      for (int u = 0; u < depth_m.width(); ++u) {
        x[u] = depth[u] * ((static_cast<float>(u) - cx) * inverse_fx);
        y[u] = depth[u] * ray_y;
        z[u] = depth[u];
      }
    }
  });
  return vertex;
}

}  // namespace surfit
