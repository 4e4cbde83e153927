#pragma once

#include <cmath>

#include "registration/brightness.h"
#include "surfit/frame/frame_pyramid.h"
#include "surfit/geometry/rigid3.h"

namespace surfit {

// One resolution of a frame: shape and brightness of the same pixels.
struct ViewLevel {
  const FrameLevel& surface;
  const BrightnessLevel& brightness;
};

// Where a source pixel with depth lands in the target's image.
struct Landing {
  int source_pixel = 0;   // index of the source pixel
  int target_pixel = 0;   // and of the target pixel nearest to
  float u = 0, v = 0;     // where it lands, px
  Eigen::Vector3f point;  // p' = R p + t, metres
};

// Calls visit(landing) for each, row by row.
template <typename Visit>
void ForEachLanding(const FrameLevel& source, const FrameLevel& target,
                    const Rigid3d& target_from_source, const Visit& visit) {
  constexpr float kNearest = 0.05f;  // m; closer to the camera's plane pixels fly apart
  const Eigen::Matrix3f rotation = target_from_source.rotation.toRotationMatrix().cast<float>();
  const Eigen::Vector3f translation = target_from_source.translation.cast<float>();
  const PinholeCamera& camera = target.camera;
  const auto fx = static_cast<float>(camera.fx), fy = static_cast<float>(camera.fy);
  const auto cx = static_cast<float>(camera.cx), cy = static_cast<float>(camera.cy);
  const float right = static_cast<float>(camera.width) - 0.5f;
  const float bottom = static_cast<float>(camera.height) - 0.5f;
  const VectorImage& vertex = source.vertex;
  for (int i = 0; i < static_cast<int>(vertex.z.size()); ++i) {
    if (!(vertex.z[i] > 0)) continue;
    const Eigen::Vector3f vertex_i(vertex.x[i], vertex.y[i], vertex.z[i]);
    Landing landing;
    landing.point = rotation * vertex_i + translation;
    if (!(landing.point.z() > kNearest)) continue;
    landing.u = fx * landing.point.x() / landing.point.z() + cx;
    landing.v = fy * landing.point.y() / landing.point.z() + cy;
    if (!(landing.u >= -0.5f && landing.v >= -0.5f && landing.u < right && landing.v < bottom)) {
      continue;
    }
    landing.source_pixel = i;
    const float from_left = landing.u + 0.5f, from_top = landing.v + 0.5f;  // not negative
    landing.target_pixel = static_cast<int>(from_top) * camera.width + static_cast<int>(from_left);
    visit(landing);
  }
}

inline Eigen::Vector3f At(const VectorImage& image, int pixel) {
  return {image.x[pixel], image.y[pixel], image.z[pixel]};
}

}  // namespace surfit
