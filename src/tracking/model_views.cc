#include "tracking/model_views.h"

#include <algorithm>
#include <limits>
#include <numeric>

namespace surfit {
namespace {

double MeanDepth(const Image<float>& depth_m) {
  const auto count = std::count_if(depth_m.begin(), depth_m.end(), [](float z) { return z > 0; });
  const double sum = std::accumulate(depth_m.begin(), depth_m.end(), 0.);
  return count > 0 ? sum / static_cast<double>(count) : 0;
}

}  // namespace

double ImageShift(const Rigid3d& motion, const FrameLevel& level) {
  const double depth_m = MeanDepth(level.vertex.z);
  if (depth_m == 0) return std::numeric_limits<double>::infinity();
  const double turn_rad = RotationAngle(motion.rotation);
  const PinholeCamera& camera = level.camera;
  return camera.fx / camera.width * (turn_rad + motion.translation.norm() / depth_m);
}

}  // namespace surfit
