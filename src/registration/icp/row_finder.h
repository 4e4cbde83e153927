#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>

#include "surfit/core/lanes.h"
#include "surfit/frame/frame_pyramid.h"
#include "surfit/registration/association.h"
#include "surfit/registration/error_model.h"
#if SURFIT_HAS_AVX2
#include <immintrin.h>
#endif

namespace surfit {

// Moves the selected lanes of a vector to its front, in order. The other lanes of the result are
// unspecified.
template <typename Instructions>
class LanePacking {
 public:
  using V = Lanes<float, Instructions>;

  explicit LanePacking(const typename V::Mask& mask) {
    for (int k = 0; k < V::kCount; ++k) {
      if (mask.v[k] != 0) lane_[count_++] = k;
    }
  }

  int count() const { return count_; }
  V operator()(const V& x) const {
    V packed;
    for (int k = 0; k < count_; ++k) packed.v[k] = x.v[lane_[k]];
    return packed;
  }

 private:
  int lane_[V::kCount];
  int count_ = 0;
};

#if SURFIT_HAS_AVX2
// Indices of the set bits in ascending order, for each 8-bit number.
inline constexpr auto kSetBits = [] {
  std::array<std::array<std::int32_t, 8>, 256> table{};
  for (int bits = 0; bits < 256; ++bits) {
    for (int k = 0, count = 0; k < 8; ++k) {
      if ((bits >> k & 1) != 0) table[bits][count++] = k;
    }
  }
  return table;
}();

template <>
class LanePacking<Avx2Instructions> {
 public:
  using V = Lanes<float, Avx2Instructions>;

  SURFIT_AVX2 explicit LanePacking(const V::Mask& mask) {
    const int bits = _mm256_movemask_ps(reinterpret_cast<__m256>(mask.v));
    count_ = __builtin_popcount(bits);
    std::memcpy(&lane_, kSetBits[bits].data(), sizeof(lane_));
  }

  int count() const { return count_; }
  SURFIT_AVX2 V operator()(const V& x) const {
    return V::Vector(_mm256_permutevar8x32_ps(__m256(x.v), lane_));
  }

 private:
  __m256i lane_;
  int count_;
};
#endif

// Keeps references.
struct ProjectiveSearch {
  const FrameLevel& source;
  const FrameLevel& target;
  Rigid3d target_from_source;
  AssociationGates gates;
  ErrorModel error_model;
  NeededNormals needed_normals;
};

// Finds the pairs of one row of source pixels, eight pixels at a time. ProjectiveAssociation
// defines the pairs.
template <typename Instructions>
class RowFinder {
 public:
  explicit RowFinder(const ProjectiveSearch& search)
      : source_(search.source), target_(search.target) {
    const Eigen::Matrix3d rotation = search.target_from_source.rotation.toRotationMatrix();
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) rotation_[i][j] = V(rotation(i, j));
      translation_[i] = V(search.target_from_source.translation[i]);
    }
    const AssociationGates& gates = search.gates;
    const bool gates_normals = gates.max_normal_angle_rad > 0;
    if (gates.max_distance_m > 0) max_distance2_ = V(gates.max_distance_m * gates.max_distance_m);
    if (gates_normals) min_cosine_ = V(std::cos(gates.max_normal_angle_rad));
    // Valid normals have length 1, missing normals have length 0.
    if (gates_normals || search.needed_normals != NeededNormals::kNone)
      min_target_normal2_ = V(0.5);
    if (gates_normals || search.needed_normals == NeededNormals::kBoth)
      min_source_normal2_ = V(0.5);
    const ErrorModel& model = search.error_model;
    floor_variance_ = V(model.floor_sigma_m * model.floor_sigma_m);
    const double inverse_depth_sigma = source_.noise.inverse_depth_sigma;
    inverse_depth_variance_ = V(inverse_depth_sigma * inverse_depth_sigma);
  }

  // Implements PairFinder::Find() for row v.
  int Find(int v, int first, PairBuffer* pairs) const {
    return Find(v, 0, source_.vertex.width(), first, pairs);
  }

  // Finds the pairs of the columns [begin, end) of row v.
  int Find(int v, int begin, int end, int first, PairBuffer* pairs) const {
    const int row = v * source_.vertex.width();
    int next = first;
    for (int u = begin; u < end; u += V::kCount) {
      next += FindLanes(row + u, end - u, next, pairs);
    }
    return next - first;
  }

 private:
  using V = Lanes<float, Instructions>;
  using Mask = typename V::Mask;
  struct Point {
    V x, y, z;
    V Dot(const Point& other) const { return x * other.x + y * other.y + z * other.z; }
  };

  // Finds the pairs of up to `count` source pixels from index `pixel`.
  int FindLanes(int pixel, int count, int first, PairBuffer* pairs) const {
    const Point s = Load(source_.vertex, pixel, count);
    const V depth = s.z.UpTo(count);
    if (!V::Any(depth > V(0.))) return 0;
    Point p = Rotated(s);
    p = {p.x + translation_[0], p.y + translation_[1], p.z + translation_[2]};
    int target_pixel[V::kCount];
    Mask valid = Project(p, target_pixel) & (depth > V(0.));
    const Point q = Gather(target_.vertex, target_pixel), n = Gather(target_.normal, target_pixel);
    const Point m = Rotated(Load(source_.normal, pixel, count));
    const Point offset = {q.x - p.x, q.y - p.y, q.z - p.z};
    valid = valid & (q.z > V(0.)) & (offset.Dot(offset) <= max_distance2_) &
            (n.Dot(n) >= min_target_normal2_) & (m.Dot(m) >= min_source_normal2_) &
            (m.Dot(n) >= min_cosine_);
    const V depth2 = depth * depth;
    const V information = V(1.) / (floor_variance_ + inverse_depth_variance_ * depth2 * depth2);
    const LanePacking<Instructions> packing(valid);
    const auto store = [&](const V& value, RawVector<float>* to) {
      packing(value).Store(to->data() + first);
    };
    store(p.x, &pairs->px), store(p.y, &pairs->py), store(p.z, &pairs->pz);
    store(q.x, &pairs->qx), store(q.y, &pairs->qy), store(q.z, &pairs->qz);
    store(n.x, &pairs->nx), store(n.y, &pairs->ny), store(n.z, &pairs->nz);
    store(m.x, &pairs->mx), store(m.y, &pairs->my), store(m.z, &pairs->mz);
    store(information, &pairs->information);
    return packing.count();
  }

  static Point Load(const VectorImage& image, int pixel, int count) {
    return {V::LoadUpTo(image.x.data() + pixel, count), V::LoadUpTo(image.y.data() + pixel, count),
            V::LoadUpTo(image.z.data() + pixel, count)};
  }

  static Point Gather(const VectorImage& image, const int* pixel) {
    Point point;
    for (int k = 0; k < V::kCount; ++k) {
      point.x.v[k] = image.x[pixel[k]];
      point.y.v[k] = image.y[pixel[k]];
      point.z.v[k] = image.z[pixel[k]];
    }
    return point;
  }

  Point Rotated(const Point& a) const {
    const auto row = [&](const V* r) { return r[0] * a.x + r[1] * a.y + r[2] * a.z; };
    return {row(rotation_[0]), row(rotation_[1]), row(rotation_[2])};
  }

  // Indices of the target pixels of the projections of p; 0 outside the image. Returns the mask of
  // the points inside.
  Mask Project(const Point& p, int* pixel) const {
    const PinholeCamera& camera = target_.camera;
    const V inverse_z = V(1.) / p.z;
    const V u = V(camera.fx) * p.x * inverse_z + V(camera.cx + 0.5);
    const V v = V(camera.fy) * p.y * inverse_z + V(camera.cy + 0.5);
    const Mask inside = (p.z > V(0.)) & (u >= V(0.)) & (v >= V(0.)) & (u < V(camera.width)) &
                        (v < V(camera.height));
    int column[V::kCount], row[V::kCount];
    Select(inside, u, V(0.)).StoreTruncated(column);
    Select(inside, v, V(0.)).StoreTruncated(row);
    for (int k = 0; k < V::kCount; ++k) pixel[k] = row[k] * camera.width + column[k];
    return inside;
  }

  const FrameLevel& source_;
  const FrameLevel& target_;
  V rotation_[3][3], translation_[3];
  V max_distance2_{std::numeric_limits<double>::infinity()};
  V min_cosine_{-std::numeric_limits<double>::infinity()};
  V min_target_normal2_{0.}, min_source_normal2_{0.};
  V floor_variance_, inverse_depth_variance_;
};

}  // namespace surfit
