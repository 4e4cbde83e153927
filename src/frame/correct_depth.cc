#include "surfit/frame/correct_depth.h"

namespace surfit {

void CorrectDepth(const PinholeCamera& camera, const InverseDepthField& field,
                  Image<float>* depth_m) {
  for (int v = 0; v < depth_m->height(); ++v) {
    for (int u = 0; u < depth_m->width(); ++u) {
      const Eigen::Vector3d ray = camera.Ray(u, v);
      (*depth_m)(u, v) = field.Corrected((*depth_m)(u, v), ray.x(), ray.y());
    }
  }
}

}  // namespace surfit
