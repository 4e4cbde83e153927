#pragma once

#include <limits>

#include "registration/icp/photometric_term.h"
#include "registration/icp/row_finder.h"

namespace surfit {

// Keeps a reference to the target, which has intensities and vertices of the size of its camera.
struct IntensitySearch {
  const FrameLevel& target;
  Rigid3d target_from_source;
  double max_distance_m = 0;  // to the target depth; 0: no limit
};

// Samples the target image at projected points, eight at a time.
template <typename Instructions>
class IntensityFinder {
 public:
  explicit IntensityFinder(const IntensitySearch& search) : target_(search.target) {
    const Eigen::Matrix3d rotation = search.target_from_source.rotation.toRotationMatrix();
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) rotation_[i][j] = V(rotation(i, j));
      translation_[i] = V(search.target_from_source.translation[i]);
    }
    if (search.max_distance_m > 0) max_distance_ = V(search.max_distance_m);
  }

  // Writes the pairs of all points from index `first`. Returns the number of pairs, without
  // changing pairs->size. The arrays need space for all points plus one vector of lanes.
  int Find(const TexturedPoints& points, int first, IntensityPairs* pairs) const {
    const int count = static_cast<int>(points.x.size());
    int next = first;
    for (int i = 0; i < count; i += V::kCount) next += FindLanes(points, i, count - i, next, pairs);
    return next - first;
  }

 private:
  using V = Lanes<float, Instructions>;
  using Mask = typename V::Mask;

  // Bilinear interpolation of the image at (u, v), px.
  struct Sample {
    V value, slope_u, slope_v, depth_m;
  };

  int FindLanes(const TexturedPoints& points, int i, int count, int first,
                IntensityPairs* pairs) const {
    const V x = V::LoadUpTo(points.x.data() + i, count);
    const V y = V::LoadUpTo(points.y.data() + i, count);
    const V z = V::LoadUpTo(points.z.data() + i, count);
    V p[3];
    for (int k = 0; k < 3; ++k) {
      const V* r = rotation_[k];
      p[k] = r[0] * x + r[1] * y + r[2] * z + translation_[k];
    }
    const PinholeCamera& camera = target_.camera;
    const V inverse_z = V(1.) / p[2];
    const V u = V(camera.fx) * p[0] * inverse_z + V(camera.cx);
    const V v = V(camera.fy) * p[1] * inverse_z + V(camera.cy);
    const Mask inside = (p[2] > V(0.)) & (u >= V(0.)) & (v >= V(0.)) & (u < V(camera.width - 1.)) &
                        (v < V(camera.height - 1.));
    const Sample sample = SampleAt(Select(inside, u, V(0.)), Select(inside, v, V(0.)));
    // Rejects NaN, too.
    const Mask valid = inside & (sample.value >= V(0.)) & (sample.depth_m > V(0.)) &
                       (abs(sample.depth_m - p[2]) <= max_distance_) & (V(1.).UpTo(count) > V(0.));
    const LanePacking<Instructions> packing(valid);
    const auto store = [&](const V& value, RawVector<float>* to) {
      packing(value).Store(to->data() + first);
    };
    store(p[0], &pairs->px), store(p[1], &pairs->py), store(p[2], &pairs->pz);
    store(V::LoadUpTo(points.intensity.data() + i, count), &pairs->source);
    store(sample.value, &pairs->target);
    store(sample.slope_u, &pairs->slope_u), store(sample.slope_v, &pairs->slope_v);
    return packing.count();
  }

  Sample SampleAt(const V& u, const V& v) const {
    const int width = target_.camera.width;
    int left[V::kCount], top[V::kCount], near_u[V::kCount], near_v[V::kCount];
    u.StoreTruncated(left), v.StoreTruncated(top);
    (u + V(0.5)).StoreTruncated(near_u), (v + V(0.5)).StoreTruncated(near_v);
    V column, row, upper_left, upper_right, lower_left, lower_right;
    Sample sample;
    for (int k = 0; k < V::kCount; ++k) {
      const float* upper = target_.intensity.data() + top[k] * width + left[k];
      upper_left.v[k] = upper[0], upper_right.v[k] = upper[1];
      lower_left.v[k] = upper[width], lower_right.v[k] = upper[width + 1];
      column.v[k] = static_cast<float>(left[k]), row.v[k] = static_cast<float>(top[k]);
      sample.depth_m.v[k] = target_.vertex.z[near_v[k] * width + near_u[k]];
    }
    const V a = u - column, b = v - row;
    const V on_top = upper_left + a * (upper_right - upper_left);
    const V below = lower_left + a * (lower_right - lower_left);
    sample.slope_u = (V(1.) - b) * (upper_right - upper_left) + b * (lower_right - lower_left);
    sample.slope_v = below - on_top;
    sample.value = on_top + b * sample.slope_v;
    return sample;
  }

  const FrameLevel& target_;
  V rotation_[3][3], translation_[3];
  V max_distance_{std::numeric_limits<double>::infinity()};
};

}  // namespace surfit
