#include "surfit/registration/projective_association.h"

#include <glog/logging.h>

#include <cmath>
#include <limits>
#include <vector>

#include "registration/pair_buffer.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

constexpr int kRowsPerBlock = 8;
constexpr float kInlierBound2 =
    static_cast<float>(ErrorModel::kInlierSigmas * ErrorModel::kInlierSigmas);

// Everything the inner loop needs, in single precision.
class RowAssociator {
 public:
  RowAssociator(const FrameLevel& source, const FrameLevel& target, const AssociationGates& gates,
                const ErrorModel& error_model, const Rigid3d& target_from_source)
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
        normal_gate_(gates.max_normal_angle_rad > 0),
        min_cosine_(static_cast<float>(std::cos(gates.max_normal_angle_rad))),
        floor_variance_(static_cast<float>(error_model.floor_sigma_m * error_model.floor_sigma_m)),
        inverse_depth_variance_(static_cast<float>(error_model.noise.inverse_depth_sigma *
                                                   error_model.noise.inverse_depth_sigma)),
        inverse_kernel2_(
            error_model.kernel_width > 0
                ? static_cast<float>(1 / (error_model.kernel_width * error_model.kernel_width))
                : 0.f) {}

  // Fills the buffer with the pairs of row v.
  void Associate(int v, PairBuffer* pairs) const {
    pairs->size = 0;
    pairs->inlier_count = 0;
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
      if (!(q.z() > 0) || (q - p).squaredNorm() > max_distance2_ || n.isZero(0.f)) continue;
      if (normal_gate_ && (rotation_ * source_.normal(u, v)).dot(n) < min_cosine_) continue;
      const float variance = Variance(sz[u]);
      const float residual2 = Square(n.dot(p - q));
      const float kernel = 1.f + residual2 * inverse_kernel2_ / variance;
      Append(p, q, n, 1.f / variance, 1.f / (variance * kernel * kernel), pairs);
      if (residual2 <= kInlierBound2 * variance) ++pairs->inlier_count;
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

  static float Square(float x) { return x * x; }
  float Variance(float depth_m) const {
    const float z2 = depth_m * depth_m;
    return floor_variance_ + inverse_depth_variance_ * z2 * z2;
  }

  static void Append(const Eigen::Vector3f& p, const Eigen::Vector3f& q, const Eigen::Vector3f& n,
                     float information, float weight, PairBuffer* pairs) {
    const int i = pairs->size++;
    pairs->px[i] = p.x(), pairs->py[i] = p.y(), pairs->pz[i] = p.z();
    pairs->qx[i] = q.x(), pairs->qy[i] = q.y(), pairs->qz[i] = q.z();
    pairs->nx[i] = n.x(), pairs->ny[i] = n.y(), pairs->nz[i] = n.z();
    pairs->information[i] = information;
    pairs->weight[i] = weight;
  }

  const FrameLevel& source_;
  const FrameLevel& target_;
  const Eigen::Matrix3f rotation_;
  const Eigen::Vector3f translation_;
  const float fx_, fy_, cx_, cy_;
  const float max_distance2_;
  const bool normal_gate_;
  const float min_cosine_;
  const float floor_variance_;
  const float inverse_depth_variance_;
  const float inverse_kernel2_;
};

}  // namespace

ProjectiveAssociation::ProjectiveAssociation(const FrameLevel& source, const FrameLevel& target,
                                             const AssociationGates& gates,
                                             const ErrorModel& error_model)
    : source_(source), target_(target), gates_(gates), error_model_(error_model) {
  CHECK_EQ(target.vertex.width(), target.camera.width);
  CHECK_EQ(target.vertex.height(), target.camera.height);
}

NormalSystem ProjectiveAssociation::Linearize(const Rigid3d& target_from_source) const {
  const RowAssociator rows(source_, target_, gates_, error_model_, target_from_source);
  return ParallelSum(0, source_.vertex.height(), kRowsPerBlock, NormalSystem(),
                     [&](int begin, int end) {
                       PairBuffer pairs(source_.vertex.width());
                       NormalSystem system;
                       for (int v = begin; v < end; ++v) {
                         rows.Associate(v, &pairs);
                         AddPairs(&pairs, &system);
                       }
                       return system;
                     });
}

std::vector<PairBuffer> ProjectiveAssociation::CollectRows(
    const Rigid3d& target_from_source) const {
  const RowAssociator associator(source_, target_, gates_, error_model_, target_from_source);
  const int height = source_.vertex.height();
  std::vector<PairBuffer> rows(height, PairBuffer(0));
  ParallelFor(0, height, kRowsPerBlock, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      rows[v] = PairBuffer(source_.vertex.width());
      associator.Associate(v, &rows[v]);
    }
  });
  return rows;
}

Correspondences ProjectiveAssociation::Collect(const Rigid3d& target_from_source) const {
  Correspondences all;
  for (const PairBuffer& pairs : CollectRows(target_from_source)) {
    all.inlier_count += pairs.inlier_count;
    for (int i = 0; i < pairs.size; ++i) {
      all.Add({pairs.px[i], pairs.py[i], pairs.pz[i]}, {pairs.qx[i], pairs.qy[i], pairs.qz[i]},
              {pairs.nx[i], pairs.ny[i], pairs.nz[i]}, pairs.weight[i]);
    }
  }
  return all;
}

}  // namespace surfit
