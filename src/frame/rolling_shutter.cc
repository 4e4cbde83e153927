#include "frame/rolling_shutter.h"

#include <Eigen/LU>
#include <algorithm>
#include <cstdint>
#include <numeric>
#include <vector>

#include "surfit/core/lanes.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

// Maximum second difference of inverse depth on one surface, in standard deviations of inverse
// depth. Noise alone causes a standard deviation of sqrt(6) = 2.4.
constexpr double kMaxBendSigmas = 6;

constexpr double kMinScale = 0.1;

// Lower bound of the pivots of ReadoutCorrection(), relative to the largest pivot. Rounding of
// float points and normals gives pivots of about (1e-7)^2 along unconstrained directions. One pixel
// in 1e4 that constrains a rotation with a lever of 1 cm gives 1e-8.
constexpr double kMinPivotRatio = 1e-10;

// Displacement of each pixel to the middle of the readout in px, ratio of new to old depth, and old
// inverse depth in 1/m (0: missing). Missing pixels move as points at infinity.
struct MovedPixels {
  Image<float> du, dv, scale, inverse_depth;
};

std::vector<float> ColumnsOf(int width) {
  std::vector<float> columns(width);
  std::iota(columns.begin(), columns.end(), 0.f);
  return columns;
}

// Moves the points X of row v to X + tau (w x X + velocity). w: angular velocity. tau: capture time
// of the row, relative to the middle of the readout.
template <typename V>
void MoveRow(const Image<float>& depth_m, const DepthSensor& sensor, const CameraMotion& motion,
             const std::vector<float>& columns, int v, MovedPixels* moved) {
  const PinholeCamera& camera = sensor.camera;
  const int width = depth_m.width();
  const double tau = ((v + 0.5) / depth_m.height() - 0.5) * sensor.readout_s;
  const Eigen::Vector3d turn = tau * motion.angular_velocity_rad_per_s,
                        way = tau * motion.velocity_m_per_s;
  const V y = (v - camera.cy) / camera.fy;
  for (int u = 0; u < width; u += V::kCount) {
    const int count = width - u;
    const V x = (V::LoadUpTo(columns.data() + u, count) - camera.cx) * (1 / camera.fx);
    const V z = V::LoadUpTo(depth_m.row(v) + u, count);
    const V inverse = Select(z > V(0.), V(1.) / z, 0.);
    const V scale = Max(kMinScale, y * turn.x() - x * turn.y() + inverse * way.z() + 1.);
    const V moved_x = x + turn.y() - y * turn.z() + inverse * way.x();
    const V moved_y = y + x * turn.z() - turn.x() + inverse * way.y();
    ((moved_x / scale - x) * camera.fx).StoreUpTo(moved->du.row(v) + u, count);
    ((moved_y / scale - y) * camera.fy).StoreUpTo(moved->dv.row(v) + u, count);
    scale.StoreUpTo(moved->scale.row(v) + u, count);
    inverse.StoreUpTo(moved->inverse_depth.row(v) + u, count);
  }
}

MovedPixels MovePixels(const Image<float>& depth_m, const DepthSensor& sensor,
                       const CameraMotion& motion) {
  MovedPixels moved;
  for (Image<float>* image : {&moved.du, &moved.dv, &moved.scale, &moved.inverse_depth}) {
    image->Resize(depth_m.width(), depth_m.height());
  }
  const std::vector<float> columns = ColumnsOf(depth_m.width());
  ParallelFor(0, depth_m.height(), kRowsPerBlock, [&](int begin, int end) {
    WithInstructions([&](auto instructions) {
      using V = Lanes<float, decltype(instructions)>;
      for (int v = begin; v < end; ++v) MoveRow<V>(depth_m, sensor, motion, columns, v, &moved);
    });
  });
  return moved;
}

template <typename V>
class OriginFinder {
 public:
  OriginFinder(const MovedPixels& moved, const std::vector<float>& columns, double max_bend)
      : moved_(moved), columns_(columns), max_bend_(max_bend) {}

  // Writes corrected depths, m (0: missing), and the indices of their source pixels (-1: outside
  // the image). `origin` may be null.
  void FindRow(int v, float* depth_m, std::int32_t* origin) const {
    for (int u = 0; u < width_; u += V::kCount) {
      const int count = std::min(width_ - u, V::kCount);
      std::int32_t pixels[V::kCount];
      FindLanes(u, v, count, pixels).StoreUpTo(depth_m + u, count);
      if (origin != nullptr) std::copy_n(pixels, count, origin + u);
    }
  }

 private:
  using Mask = typename V::Mask;

  struct Neighbours {
    V u, v, du, dv, scale, inverse, left, right, above, below;
  };

  // rows(v) is the distance of row v from the middle row. The displacement dv is proportional to
  // rows(v). So the source row v0 satisfies v0 + dv rows(v0) / rows(v) = v.
  V FindLanes(int u, int v, int count, std::int32_t* pixels) const {
    const float rows = static_cast<float>(v) + 0.5f - 0.5f * static_cast<float>(height_);
    const V at_u = V::LoadUpTo(columns_.data() + u, count), at_v(v);
    const V dv = V::LoadUpTo(moved_.dv.row(v) + u, count);
    const V share = V(1.) / Max(kMinScale, dv * (rows == 0 ? 0 : 1 / rows) + 1.);
    const V from_u = at_u + 0.5 - V::LoadUpTo(moved_.du.row(v) + u, count) * share;
    const V from_v = at_v + 0.5 - dv * share;
    const Mask inside =
        (from_u >= V(0.)) & (from_v >= V(0.)) & (from_u < V(width_)) & (from_v < V(height_));
    const Neighbours near = Gather(Select(inside, from_u, 0.), Select(inside, from_v, 0.));
    Select(inside, near.v * width_ + near.u, -1.).StoreTruncated(pixels);
    const V inverse = near.inverse +
                      (at_u - near.du - near.u) * Slope(near.left, near.inverse, near.right) +
                      (at_v - near.dv - near.v) * Slope(near.above, near.inverse, near.below);
    const Mask has_depth = inside & (near.inverse > V(0.)) & (inverse > V(0.));
    return Select(has_depth, near.scale / inverse, 0.);
  }

  Neighbours Gather(const V& from_u, const V& from_v) const {
    std::int32_t column[V::kCount], row[V::kCount];
    from_u.StoreTruncated(column);
    from_v.StoreTruncated(row);
    const float* const inverse = moved_.inverse_depth.data();
    if (AreInARow(column, row)) {
      const int at = row[0] * width_ + column[0];
      return {V::Load(columns_.data() + column[0]),
              V(row[0]),
              V::Load(moved_.du.data() + at),
              V::Load(moved_.dv.data() + at),
              V::Load(moved_.scale.data() + at),
              V::Load(inverse + at),
              V::Load(inverse + at - 1),
              V::Load(inverse + at + 1),
              V::Load(inverse + at - width_),
              V::Load(inverse + at + width_)};
    }
    Neighbours near;
    for (int k = 0; k < V::kCount; ++k) {
      const int at = row[k] * width_ + column[k];
      near.u.v[k] = static_cast<float>(column[k]);
      near.v.v[k] = static_cast<float>(row[k]);
      near.du.v[k] = moved_.du[at];
      near.dv.v[k] = moved_.dv[at];
      near.scale.v[k] = moved_.scale[at];
      near.inverse.v[k] = inverse[at];
      near.left.v[k] = inverse[column[k] > 0 ? at - 1 : at];
      near.right.v[k] = inverse[column[k] + 1 < width_ ? at + 1 : at];
      near.above.v[k] = inverse[row[k] > 0 ? at - width_ : at];
      near.below.v[k] = inverse[row[k] + 1 < height_ ? at + width_ : at];
    }
    return near;
  }

  // True for consecutive pixels of one row whose neighbours are inside the image.
  bool AreInARow(const std::int32_t* column, const std::int32_t* row) const {
    if (column[0] < 1 || column[0] + V::kCount >= width_) return false;
    if (row[0] < 1 || row[0] + 1 >= height_) return false;
    bool are = true;
    for (int k = 1; k < V::kCount; ++k) are &= column[k] == column[0] + k && row[k] == row[0];
    return are;
  }

  V Slope(const V& before, const V& here, const V& after) const {
    const Mask continues =
        (before > V(0.)) & (after > V(0.)) & (abs(before + after - here * 2.) <= max_bend_);
    return Select(continues, (after - before) * 0.5, 0.);
  }

  const MovedPixels& moved_;
  const std::vector<float>& columns_;
  V max_bend_;
  int width_ = moved_.du.width(), height_ = moved_.du.height();
};

}  // namespace

RgbdFrame CorrectRollingShutter(const RgbdFrame& frame, const DepthSensor& sensor,
                                const CameraMotion& motion) {
  if (sensor.readout_s == 0 || motion.IsZero()) return frame;
  const int width = frame.depth_m.width(), height = frame.depth_m.height();
  const MovedPixels moved = MovePixels(frame.depth_m, sensor, motion);
  const std::vector<float> columns = ColumnsOf(width);
  RgbdFrame result = {frame.index, frame.stamp_s, frame.color_stamp_s, {}, {}};
  Image<std::int32_t> origin;
  result.depth_m.Resize(width, height);
  if (!frame.color.empty()) origin.Resize(width, height);
  ParallelFor(0, height, kRowsPerBlock, [&](int begin, int end) {
    WithInstructions([&](auto instructions) {
      using V = Lanes<float, decltype(instructions)>;
      const OriginFinder<V> finder(moved, columns,
                                   kMaxBendSigmas * sensor.noise.inverse_depth_sigma);
      for (int v = begin; v < end; ++v) {
        finder.FindRow(v, result.depth_m.row(v), origin.empty() ? nullptr : origin.row(v));
      }
    });
  });
  result.color.Resize(origin.width(), origin.height());
  std::transform(origin.begin(), origin.end(), result.color.begin(),
                 [&](std::int32_t from) { return from < 0 ? Rgb8() : frame.color[from]; });
  return result;
}

Rigid3d ReadoutCorrection(const FrameLevel& surface, double readout_s, const CameraMotion& expected,
                          const CameraMotion& found, double seconds) {
  using Matrix6d = Eigen::Matrix<double, 6, 6>;
  Matrix6d a_sum = Matrix6d::Zero(), b_sum = Matrix6d::Zero();
  const int height = surface.camera.height;
  for (int v = 0; v < height; ++v) {
    Matrix6d row = Matrix6d::Zero();
    for (int u = 0; u < surface.camera.width; ++u) {
      const Eigen::Vector3d point = surface.vertex(u, v).cast<double>();
      const Eigen::Vector3d normal = surface.normal(u, v).cast<double>();
      if (!(normal.dot(point) < 0)) continue;
      Eigen::Matrix<double, 6, 1> a;
      a << point.cross(normal), normal;
      a /= surface.noise.SigmaZ(point.z());
      row += a * a.transpose();
    }
    a_sum += row;
    b_sum += ((v + 0.5) / height - 0.5) * readout_s * row;
  }
  Eigen::Matrix<double, 6, 1> motion;
  motion << found.angular_velocity_rad_per_s - expected.angular_velocity_rad_per_s,
      found.velocity_m_per_s - expected.velocity_m_per_s;
  Eigen::FullPivLU<Matrix6d> lu(a_sum + b_sum / seconds);
  lu.setThreshold(kMinPivotRatio);
  if (!lu.isInvertible()) return {};
  const Eigen::Matrix<double, 6, 1> change = -lu.solve(b_sum * motion);
  if (!change.allFinite()) return {};
  return {QuaternionExp<double>(change.head<3>()), change.tail<3>()};
}

}  // namespace surfit
