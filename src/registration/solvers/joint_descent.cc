#include <algorithm>
#include <cmath>

#include "cost_functions/row_sums.h"
#include "registration/global/initial_pose_search.h"
#include "registration/icp/photometric_term.h"
#include "registration/icp/residual_rows.h"
#include "registration/solvers/decompositions.h"
#include "surfit/core/image.h"
#include "surfit/registration/global_registration.h"

namespace surfit {

namespace {

// Standard deviation of surface errors at coarse levels, added to the sensor noise.
constexpr float kSurfaceSigmaM = 0.02f;
constexpr float kBrightnessSigma = 0.05f;  // includes reflections that differ between distant views
constexpr float kBrightnessKernelWidth = 3;  // in sigmas
constexpr double kKernelsPerDistance = 1.5;  // distance gate in kernel widths
constexpr int kMinPairs = 100;

// Projective correspondences that pass the gates on distance and normal angle. Each column is a
// contiguous array.
class JointPairs {
 public:
  enum Column {
    kX,
    kY,
    kZ,
    kNormalX,
    kNormalY,
    kNormalZ,
    kHeight,
    kShapes,  // number of geometric columns
    kFrom = kShapes,
    kTo,
    kSlopeU,
    kSlopeV,
    kAll
  };

  JointPairs(int capacity, bool has_brightness)
      : capacity_(capacity),
        values_(static_cast<std::size_t>(capacity) * (has_brightness ? kAll : kShapes)) {}

  int size() const { return size_; }
  const float* operator[](int column) const {
    return values_.data() + static_cast<std::ptrdiff_t>(column) * capacity_;
  }
  // height_m: signed distance of the transformed source point to the target plane.
  void Add(const Eigen::Vector3f& point, const Eigen::Vector3f& normal, float height_m) {
    for (int i = 0; i < 3; ++i) Last(kX + i) = point[i];
    for (int i = 0; i < 3; ++i) Last(kNormalX + i) = normal[i];
    Last(kHeight) = height_m;
    ++size_;
  }
  // Sets the brightness of the next pair. Call this before Add().
  void SetBrightness(float from, const BilinearSample& to) {
    Last(kFrom) = from;
    Last(kTo) = to.value;
    Last(kSlopeU) = to.slope_u;
    Last(kSlopeV) = to.slope_v;
  }

 private:
  float& Last(int column) { return values_[static_cast<std::size_t>(column) * capacity_ + size_]; }

  int capacity_, size_ = 0;
  RawVector<float> values_;
};

JointPairs FindPairs(const ViewLevel& source, const ViewLevel& target, const JointOptions& options,
                     const Rigid3d& target_from_source) {
  const Eigen::Matrix3f rotation = target_from_source.rotation.toRotationMatrix().cast<float>();
  const auto max_square = static_cast<float>(options.max_distance_m * options.max_distance_m);
  const int columns = source.surface.camera.width / options.stride + 1;
  const int rows = source.surface.camera.height / options.stride + 1;
  JointPairs pairs(columns * rows, options.use_brightness);
  const auto add = [&](const Projections& at, int k) {
    const Eigen::Vector3f surface = At(target.surface.vertex, at.target_pixel[k]);
    if (!(surface.z() > 0)) return;
    const Eigen::Vector3f point = at.Point(k), gap = point - surface;
    if (gap.squaredNorm() > max_square) return;
    const Eigen::Vector3f normal = At(target.surface.normal, at.target_pixel[k]);
    const Eigen::Vector3f turned = rotation * At(source.surface.normal, at.source_pixel[k]);
    if (!(turned.dot(normal) > kMinNormalCosine)) return;
    if (options.use_brightness) {
      pairs.SetBrightness(source.brightness.value[at.source_pixel[k]],
                          SampleAt(target.brightness.value, at.u[k], at.v[k]));
    }
    pairs.Add(point, normal, normal.dot(gap));
  };
  ForEachProjections(source.surface, target.surface, target_from_source, options.stride,
                     [&](const Projections& at) {
                       for (int k = 0; k < at.count; ++k) add(at, k);
                     });
  return pairs;
}

Exposure MatchExposure(const JointPairs& pairs) {
  constexpr double kFloorVariance = 1e-4;
  if (pairs.size() == 0) return {};
  double a = 0, b = 0, aa = 0, bb = 0;
  for (int i = 0; i < pairs.size(); ++i) {
    const double from = pairs[JointPairs::kFrom][i], to = pairs[JointPairs::kTo][i];
    a += from, b += to, aa += from * from, bb += to * to;
  }
  const double count = pairs.size();
  a /= count, b /= count;
  const double gain =
      std::sqrt((bb / count - b * b + kFloorVariance) / (aa / count - a * a + kFloorVariance));
  const double clamped = std::clamp(gain, 1 / kMaxGain, kMaxGain);
  return {static_cast<float>(clamped), static_cast<float>(b - clamped * a)};
}

// Geman-McClure weight of a residual in units of the kernel width.
template <typename V>
V KernelWeight(const V& residual) {
  const V s = V(1.) + residual * residual;
  return V(1.) / (s * s);
}

template <typename V>
struct JointLanes {
  RowLanes<V> rows;
  V weight, weighted_square;

  void AddShapes(const V* point, const V* normal, const V& height_m, const V& of_shapes) {
    V row[1][kRowColumns];
    SetRow(point, normal, height_m, row[0]);
    rows.Add(row, of_shapes, kNoKernel);
    weight += of_shapes;
    weighted_square += of_shapes * Dot(point, point);
  }
  void AddBrightness(const V* point, const V* gradient, const V& residual, const V& of_residuals) {
    V row[1][kRowColumns];
    SetRow(point, gradient, residual, row[0]);
    rows.Add(row, of_residuals, kNoKernel);
  }

 private:
  // Neutral kernel: the row weights already contain the robust weights.
  static inline const RobustKernel kNoKernel = {RobustKernelType::kNone};
};

// Adds up to V::kCount pairs that start at index `first`.
template <typename V>
void AddPairs(const JointPairs& pairs, int first, int count, const FrameLevel& source,
              const PinholeCamera& camera, const JointOptions& options, const Exposure& exposure,
              JointLanes<V>* lanes) {
  const auto load = [&](int column) { return V::LoadUpTo(pairs[column] + first, count); };
  const V point[3] = {load(JointPairs::kX), load(JointPairs::kY), load(JointPairs::kZ)};
  const V normal[3] = {load(JointPairs::kNormalX), load(JointPairs::kNormalY),
                       load(JointPairs::kNormalZ)};
  const V height_m = load(JointPairs::kHeight);
  const V noise_m = V(source.noise.inverse_depth_sigma) * point[2] * point[2];
  const V of_shapes = KernelWeight<V>(height_m * V(kKernelsPerDistance / options.max_distance_m)) /
                      (V(kSurfaceSigmaM * kSurfaceSigmaM) + noise_m * noise_m);
  lanes->AddShapes(point, normal, height_m, of_shapes.UpTo(count));
  if (!options.use_brightness) return;
  const V residual =
      load(JointPairs::kTo) - (V(exposure.gain) * load(JointPairs::kFrom) + V(exposure.offset));
  const V of_residuals =
      KernelWeight<V>(residual * V(1 / (kBrightnessKernelWidth * kBrightnessSigma))) *
      V(1 / (kBrightnessSigma * kBrightnessSigma));
  V gradient[3];
  const V inverse_z = V(1.) / point[2];
  IntensityGradient(
      load(JointPairs::kSlopeU), load(JointPairs::kSlopeV), V(camera.fx), V(camera.fy), point,
      [&](const V& a) { return a * inverse_z; }, gradient);
  lanes->AddBrightness(point, gradient, residual, of_residuals.UpTo(count));
}

Vector6d DampedStep(const JointSystem& system, const DescentOptions& options) {
  Matrix6d damped = system.hessian;
  const double along = options.damping * system.weight;
  damped.diagonal().head<3>().array() += along * std::pow(system.RmsDistance(), 2);
  damped.diagonal().tail<3>().array() += along;
  return SolveLdlt(damped, system.right_side);
}

}  // namespace

double JointSystem::RmsDistance() const {
  return weight > 0 ? std::sqrt(weighted_square_sum / weight) : 0;
}

JointSystem LinearizeJointly(const ViewLevel& source, const ViewLevel& target,
                             const JointOptions& options, const Rigid3d& target_from_source) {
  const JointPairs pairs = FindPairs(source, target, options, target_from_source);
  const Exposure exposure = options.use_brightness ? MatchExposure(pairs) : Exposure();
  JointSystem system;
  RowSums sums;
  WithInstructions([&](auto instructions) {
    using V = Lanes<float, decltype(instructions)>;
    SumByLanes<V, JointLanes<V>>(
        0, pairs.size(),
        [&](int first, int count, JointLanes<V>* lanes) {
          AddPairs(pairs, first, count, source.surface, target.surface.camera, options, exposure,
                   lanes);
        },
        [&](const JointLanes<V>& lanes) {
          lanes.rows.AddTo(&sums);
          system.weight += SumOfLanes(lanes.weight);
          system.weighted_square_sum += SumOfLanes(lanes.weighted_square);
        });
  });
  double square_sum = 0;
  AddProducts(sums, &system.hessian, &system.right_side, &square_sum);
  system.pair_count = pairs.size();
  return system;
}

Rigid3d Descend(const ViewLevel& source, const ViewLevel& target, const Rigid3d& start,
                const DescentOptions& options) {
  constexpr double kGateShrinkage = 0.85;
  constexpr double kSmallestStep = 3e-4;  // rad and m
  Rigid3d pose = start;
  double max_distance_m = options.max_distance_m;
  for (int i = 0; i < options.max_steps; ++i) {
    const JointSystem system = LinearizeJointly(
        source, target, {max_distance_m, options.use_brightness, options.stride}, pose);
    if (system.pair_count * options.stride * options.stride < kMinPairs) break;
    const Vector6d step = DampedStep(system, options);
    pose = LeftIncrement(step, pose);
    if (step.norm() < kSmallestStep) break;
    max_distance_m = std::max(options.max_distance_end_m, kGateShrinkage * max_distance_m);
  }
  return pose;
}

}  // namespace surfit
