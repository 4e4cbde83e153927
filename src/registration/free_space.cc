#include "surfit/registration/free_space.h"

#include <cmath>

#include "surfit/core/parallel.h"

namespace surfit {
namespace {

constexpr int kRowsPerBlock = 8;

struct Count {
  int in_front = 0;
  int at_surface = 0;

  Count& operator+=(const Count& other) {
    in_front += other.in_front;
    at_surface += other.at_surface;
    return *this;
  }
};

// Index of the pixel nearest to a point in the camera's frame, or -1.
int PixelOf(const Eigen::Vector3d& point, const PinholeCamera& camera) {
  if (!(point.z() > 0)) return -1;
  const Eigen::Vector2d pixel = camera.Project(point) + Eigen::Vector2d(0.5, 0.5);
  const bool inside =
      pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() < camera.width && pixel.y() < camera.height;
  return inside ? static_cast<int>(pixel.y()) * camera.width + static_cast<int>(pixel.x()) : -1;
}

Eigen::Vector3d At(const VectorImage& image, int pixel) {
  return {image.x[pixel], image.y[pixel], image.z[pixel]};
}

Count CountRow(const FrameLevel& source, const FrameLevel& target, const ErrorModel& error_model,
               const Rigid3d& target_from_source, int v) {
  const Eigen::Matrix3d rotation = target_from_source.rotation.toRotationMatrix();
  Count count;
  for (int u = 0; u < source.vertex.width(); ++u) {
    if (!(source.vertex.z(u, v) > 0)) continue;
    const Eigen::Vector3d point =
        rotation * source.vertex(u, v).cast<double>() + target_from_source.translation;
    const int pixel = PixelOf(point, target.camera);
    if (pixel < 0) continue;
    const Eigen::Vector3d surface = At(target.vertex, pixel), normal = At(target.normal, pixel);
    if (!(surface.z() > 0) || normal.isZero(0)) continue;
    const double height_m = normal.dot(point - surface);
    const double sigma_m =
        std::hypot(error_model.Sigma(point.z(), source.noise), target.noise.SigmaZ(surface.z()));
    count.in_front += height_m > kFreeSpaceSigmas * sigma_m;
    count.at_surface += std::abs(height_m) <= kFreeSpaceSigmas * sigma_m;
  }
  return count;
}

}  // namespace

double FreeSpaceShare(const FrameLevel& source, const FrameLevel& target,
                      const ErrorModel& error_model, const Rigid3d& target_from_source) {
  const Count count =
      ParallelSum(0, source.vertex.height(), kRowsPerBlock, Count(), [&](int begin, int end) {
        Count sum;
        for (int v = begin; v < end; ++v) {
          sum += CountRow(source, target, error_model, target_from_source, v);
        }
        return sum;
      });
  const int telling = count.in_front + count.at_surface;
  return telling > 0 ? static_cast<double>(count.in_front) / telling : 0;
}

}  // namespace surfit
