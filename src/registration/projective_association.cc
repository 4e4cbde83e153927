#include "surfit/registration/projective_association.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace surfit {
namespace {

int CountValid(const FrameLevel& level) {
  const auto& z = level.vertex.z;
  return static_cast<int>(std::count_if(z.begin(), z.end(), [](float depth) { return depth > 0; }));
}

// Everything the inner loop needs, in single precision.
class RowFinder final : public PairFinder {
 public:
  RowFinder(const FrameLevel& source, const FrameLevel& target, const AssociationGates& gates,
            const ErrorModel& error_model, NeededNormals needed_normals,
            const Rigid3d& target_from_source)
      : source_(source),
        target_(target),
        rotation_(target_from_source.rotation.toRotationMatrix().cast<float>()),
        translation_(target_from_source.translation.cast<float>()),
        fx_(static_cast<float>(target.camera.fx)),
        fy_(static_cast<float>(target.camera.fy)),
        cx_(static_cast<float>(target.camera.cx)),
        cy_(static_cast<float>(target.camera.cy)),
        max_distance2_(gates.max_distance_m > 0
                           ? static_cast<float>(gates.max_distance_m * gates.max_distance_m)
                           : std::numeric_limits<float>::infinity()),
        target_normal_(gates.max_normal_angle_rad > 0 || needed_normals != NeededNormals::kNone),
        source_normal_(gates.max_normal_angle_rad > 0 || needed_normals == NeededNormals::kBoth),
        min_cosine_(gates.max_normal_angle_rad > 0
                        ? static_cast<float>(std::cos(gates.max_normal_angle_rad))
                        : -std::numeric_limits<float>::infinity()),
        floor_variance_(static_cast<float>(error_model.floor_sigma_m * error_model.floor_sigma_m)),
        inverse_depth_variance_(static_cast<float>(error_model.noise.inverse_depth_sigma *
                                                   error_model.noise.inverse_depth_sigma)) {}

  void Find(int v, PairBuffer* pairs) const override {
    pairs->size = 0;
    const float *sx = source_.vertex.x.row(v), *sy = source_.vertex.y.row(v),
                *sz = source_.vertex.z.row(v);
    const int width = source_.vertex.width();
    for (int u = 0; u < width; ++u) {
      if (!(sz[u] > 0)) continue;
      const Eigen::Vector3f p = rotation_ * Eigen::Vector3f(sx[u], sy[u], sz[u]) + translation_;
      const int pixel = TargetPixel(p);
      if (pixel < 0) continue;
      const Eigen::Vector3f q(target_.vertex.x[pixel], target_.vertex.y[pixel],
                              target_.vertex.z[pixel]);
      const Eigen::Vector3f n(target_.normal.x[pixel], target_.normal.y[pixel],
                              target_.normal.z[pixel]);
      if (!(q.z() > 0) || (q - p).squaredNorm() > max_distance2_) continue;
      if (target_normal_ && n.isZero(0.f)) continue;
      const Eigen::Vector3f unmoved = source_.normal(u, v);
      if (source_normal_ && unmoved.isZero(0.f)) continue;
      const Eigen::Vector3f m = rotation_ * unmoved;
      if (m.dot(n) < min_cosine_) continue;
      pairs->Append(p, q, n, m, Information(sz[u]));
    }
  }

 private:
  // Index of the target pixel that p projects to, or -1.
  int TargetPixel(const Eigen::Vector3f& p) const {
    if (!(p.z() > 0)) return -1;
    const float inverse_z = 1.f / p.z();
    const float u = fx_ * p.x() * inverse_z + cx_ + 0.5f;
    const float v = fy_ * p.y() * inverse_z + cy_ + 0.5f;
    const bool inside = u >= 0.f && v >= 0.f && u < static_cast<float>(target_.vertex.width()) &&
                        v < static_cast<float>(target_.vertex.height());
    return inside ? static_cast<int>(v) * target_.vertex.width() + static_cast<int>(u) : -1;
  }

  float Information(float depth_m) const {
    const float z2 = depth_m * depth_m;
    return 1.f / (floor_variance_ + inverse_depth_variance_ * z2 * z2);
  }

  const FrameLevel& source_;
  const FrameLevel& target_;
  const Eigen::Matrix3f rotation_;
  const Eigen::Vector3f translation_;
  const float fx_, fy_, cx_, cy_;
  const float max_distance2_;
  const bool target_normal_, source_normal_;
  const float min_cosine_;
  const float floor_variance_;
  const float inverse_depth_variance_;
};

}  // namespace

ProjectiveAssociation::ProjectiveAssociation(const FrameLevel& source, const FrameLevel& target,
                                             const AssociationGates& gates,
                                             const ErrorModel& error_model,
                                             NeededNormals needed_normals)
    : source_(source),
      target_(target),
      gates_(gates),
      error_model_(error_model),
      needed_normals_(needed_normals),
      source_count_(CountValid(source)) {
  CHECK_EQ(target.vertex.width(), target.camera.width);
  CHECK_EQ(target.vertex.height(), target.camera.height);
}

std::unique_ptr<const PairFinder> ProjectiveAssociation::At(
    const Rigid3d& target_from_source) const {
  return std::make_unique<RowFinder>(source_, target_, gates_, error_model_, needed_normals_,
                                     target_from_source);
}

}  // namespace surfit
