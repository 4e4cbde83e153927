// Registers two views of a corner with only the registration library.
#include <cmath>
#include <cstdio>

#include "surfit/frame/preprocess.h"
#include "surfit/registration/icp.h"

namespace {

// Depth image of the planes z = 2 m, x = 0.5 m and y = 0.4 m, from z = `z_m` on the z axis.
surfit::Image<float> CornerFrom(double z_m, const surfit::PinholeCamera& camera) {
  surfit::Image<float> depth_m(camera.width, camera.height);
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const Eigen::Vector3d ray = camera.Ray(u, v);
      double depth = 2 - z_m;
      if (ray.x() > 0) depth = std::fmin(depth, 0.5 / ray.x());
      if (ray.y() > 0) depth = std::fmin(depth, 0.4 / ray.y());
      depth_m(u, v) = static_cast<float>(depth);
    }
  }
  return depth_m;
}

}  // namespace

int main() {
  const surfit::PinholeCamera camera{160, 120, 130, 130, 79.5, 59.5};
  const surfit::PreprocessOptions options;
  const surfit::FramePyramid target =
      surfit::PreprocessDepth(CornerFrom(0, camera), {camera, {}}, options);
  const surfit::FramePyramid source =
      surfit::PreprocessDepth(CornerFrom(0.02, camera), {camera, {}}, options);
  const surfit::IcpResult icp = surfit::Register(source, target, {}, surfit::IcpOptions());
  const double z_m = icp.target_from_source.translation.z();
  std::printf("%s: z = %.4f m\n", ToString(icp.termination).c_str(), z_m);
  return icp.Succeeded() && std::fabs(z_m - 0.02) < 1e-3 ? 0 : 1;
}
