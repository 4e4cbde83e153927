#include "surfit/registration/point_set.h"

namespace surfit {

PointSet PointSetOf(const FrameLevel& level, const ErrorModel& error_model) {
  PointSet set;
  for (int v = 0; v < level.vertex.height(); ++v) {
    for (int u = 0; u < level.vertex.width(); ++u) {
      const Eigen::Vector3f point = level.vertex(u, v);
      if (!(point.z() > 0)) continue;
      set.Add(point, level.normal(u, v),
              static_cast<float>(error_model.Sigma(point.z(), level.noise)));
    }
  }
  return set;
}

}  // namespace surfit
