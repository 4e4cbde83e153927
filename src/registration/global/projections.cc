#include "registration/global/projections.h"

#include "surfit/core/lanes.h"

namespace surfit {

Projector::Projector(const FrameLevel& source, const PinholeCamera& target,
                     const Rigid3d& target_from_source)
    : source_(source),
      rotation_(target_from_source.rotation.toRotationMatrix().cast<float>()),
      translation_(target_from_source.translation.cast<float>()),
      fx_(static_cast<float>(target.fx)),
      fy_(static_cast<float>(target.fy)),
      cx_(static_cast<float>(target.cx)),
      cy_(static_cast<float>(target.cy)),
      width_(target.width),
      height_(target.height) {}

int Projector::Project(int u, int v, int stride, Projections* projections) const {
  constexpr int kCapacity = Projections::kCapacity;
  // Minimum depth in m, because projections diverge near the camera plane.
  constexpr float kNearest = 0.05f;
  Projections& to = *projections;
  const VectorImage& vertex = source_.vertex;
  const int width = vertex.width(), begin = v * width;
  int with_depth = 0;
  for (; u < width && with_depth < kCapacity; u += stride) {
    const int i = begin + u;
    to.x[with_depth] = vertex.x[i];
    to.y[with_depth] = vertex.y[i];
    to.z[with_depth] = vertex.z[i];
    to.source_pixel[with_depth] = i;
    with_depth += vertex.z[i] > 0;
  }
  std::int32_t is_inside[kCapacity];
  WithInstructions([&](auto /*instructions*/) {
    const Eigen::Matrix3f r = rotation_;
    const float tx = translation_.x(), ty = translation_.y(), tz = translation_.z();
    const float fx = fx_, fy = fy_, cx = cx_, cy = cy_;
    const float right = static_cast<float>(width_) - 0.5f;
    const float bottom = static_cast<float>(height_) - 0.5f;
    const int columns = width_;
    for (int k = 0; k < kCapacity; ++k) {
      const float x = to.x[k], y = to.y[k], z = to.z[k];
      const float px = r(0, 0) * x + r(0, 1) * y + r(0, 2) * z + tx;
      const float py = r(1, 0) * x + r(1, 1) * y + r(1, 2) * z + ty;
      const float pz = r(2, 0) * x + r(2, 1) * y + r(2, 2) * z + tz;
      const bool is_near = pz > kNearest;
      const float divisor = is_near ? pz : 1.f;
      const float to_u = fx * px / divisor + cx, to_v = fy * py / divisor + cy;
      const bool inside =
          is_near & (to_u >= -0.5f) & (to_v >= -0.5f) & (to_u < right) & (to_v < bottom);
      const float from_left = inside ? to_u + 0.5f : 0.f, from_top = inside ? to_v + 0.5f : 0.f;
      to.x[k] = px;
      to.y[k] = py;
      to.z[k] = pz;
      to.u[k] = to_u;
      to.v[k] = to_v;
      to.target_pixel[k] =
          static_cast<std::int32_t>(from_top) * columns + static_cast<std::int32_t>(from_left);
      is_inside[k] = inside;
    }
  });
  int count = 0;
  for (int k = 0; k < with_depth; ++k) {
    to.x[count] = to.x[k];
    to.y[count] = to.y[k];
    to.z[count] = to.z[k];
    to.u[count] = to.u[k];
    to.v[count] = to.v[k];
    to.source_pixel[count] = to.source_pixel[k];
    to.target_pixel[count] = to.target_pixel[k];
    count += is_inside[k];
  }
  to.count = count;
  return u;
}

}  // namespace surfit
