#include "mapping/surfel_projection.h"

#include <glog/logging.h>

namespace surfit {

void ProjectedChunk::Project(const SurfelMap& map, const PosedCamera& camera, int begin, int end) {
  CHECK_LE(end - begin, kCapacity);
  const Eigen::Matrix3f& r = camera.rotation;
  const Eigen::Vector3f& t = camera.translation;
  const float r00 = r(0, 0), r01 = r(0, 1), r02 = r(0, 2), tx = t.x();
  const float r10 = r(1, 0), r11 = r(1, 1), r12 = r(1, 2), ty = t.y();
  const float r20 = r(2, 0), r21 = r(2, 1), r22 = r(2, 2), tz = t.z();
  const float *wx = &map.x[begin], *wy = &map.y[begin], *wz = &map.z[begin];
  for (int i = 0; i < end - begin; ++i) {
    x[i] = r00 * wx[i] + r01 * wy[i] + r02 * wz[i] + tx;
    y[i] = r10 * wx[i] + r11 * wy[i] + r12 * wz[i] + ty;
    z[i] = r20 * wx[i] + r21 * wy[i] + r22 * wz[i] + tz;
  }
  for (int i = 0; i < end - begin; ++i) {
    const bool in_front = z[i] > kMinDepth;
    const float inverse_z = 1.f / (in_front ? z[i] : 1.f);
    const float pixel_u = camera.fx * x[i] * inverse_z + camera.cx;
    const float pixel_v = camera.fy * y[i] * inverse_z + camera.cy;
    u[i] = in_front ? pixel_u : kOutside;
    v[i] = in_front ? pixel_v : kOutside;
  }
}

}  // namespace surfit
