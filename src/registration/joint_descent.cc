#include <algorithm>
#include <cmath>

#include "registration/decompositions.h"
#include "registration/photometric_term.h"
#include "registration/residual_rows.h"
#include "registration/start_search.h"
#include "surfit/registration/far_registration.h"

namespace surfit {

namespace {

constexpr float kSurfaceSigmaM = 0.02f;      // of the coarse levels' shapes, near
constexpr float kBrightnessSigma = 0.05f;    // views far apart see surfaces shine differently
constexpr float kBrightnessKernelWidth = 3;  // in sigmas
constexpr int kMinPairs = 100;

// A landing on a surface near enough and of the same orientation.
struct Pair {
  Eigen::Vector3f normal;
  float height_m;  // n . (p' - q)
};

template <typename Visit>
void ForEachPair(const ViewLevel& source, const ViewLevel& target, double max_distance_m,
                 const Rigid3d& target_from_source, const Visit& visit) {
  const Eigen::Matrix3f rotation = target_from_source.rotation.toRotationMatrix().cast<float>();
  const auto max_square = static_cast<float>(max_distance_m * max_distance_m);
  const auto on_landing = [&](const Landing& landing) {
    const Eigen::Vector3f surface = At(target.surface.vertex, landing.target_pixel);
    if (!(surface.z() > 0)) return;
    const Eigen::Vector3f gap = landing.point - surface;
    if (gap.squaredNorm() > max_square) return;
    const Eigen::Vector3f normal = At(target.surface.normal, landing.target_pixel);
    const Eigen::Vector3f turned = rotation * At(source.surface.normal, landing.source_pixel);
    if (!(turned.dot(normal) > kMinNormalCosine)) return;
    visit(landing, Pair{normal, normal.dot(gap)});
  };
  ForEachLanding(source.surface, target.surface, target_from_source, on_landing);
}

Exposure MatchExposure(const ViewLevel& source, const ViewLevel& target, double max_distance_m,
                       const Rigid3d& target_from_source) {
  constexpr double kFloorVariance = 1e-4;
  double count = 0, a = 0, b = 0, aa = 0, bb = 0;
  ForEachPair(source, target, max_distance_m, target_from_source,
              [&](const Landing& landing, const Pair&) {
                const double from = source.brightness.value[landing.source_pixel];
                const double to = target.brightness.value[landing.target_pixel];
                count += 1, a += from, b += to, aa += from * from, bb += to * to;
              });
  if (count == 0) return {};
  a /= count, b /= count;
  const double gain =
      std::sqrt((bb / count - b * b + kFloorVariance) / (aa / count - a * a + kFloorVariance));
  const double clamped = std::clamp(gain, 1 / kMaxGain, kMaxGain);
  return {static_cast<float>(clamped), static_cast<float>(b - clamped * a)};
}

// Geman and McClure's weight of a residual in units of the kernel's width.
float KernelWeight(float residual) {
  const float s = 1 + residual * residual;
  return 1 / (s * s);
}

class JointSums {
 public:
  JointSums(const DepthNoise& noise, const PinholeCamera& camera, double max_distance_m)
      : inverse_depth_sigma_(static_cast<float>(noise.inverse_depth_sigma)),
        fx_(static_cast<float>(camera.fx)),
        fy_(static_cast<float>(camera.fy)),
        kernel_width_m_(static_cast<float>(max_distance_m / 1.5)) {}

  void AddShape(const Eigen::Vector3f& point, const Pair& pair) {
    const float noise = inverse_depth_sigma_ * point.z() * point.z();
    const float weight = KernelWeight(pair.height_m / kernel_width_m_) /
                         (kSurfaceSigmaM * kSurfaceSigmaM + noise * noise);
    AddRow(point, pair.normal.data(), pair.height_m, weight);
    system_.weight += weight;
    system_.weighted_square_sum += weight * point.squaredNorm();
    ++system_.pair_count;
  }

  void AddBrightness(const Eigen::Vector3f& point, const BilinearSample& sample, float expected) {
    const float residual = sample.value - expected;
    const float weight = KernelWeight(residual / (kBrightnessKernelWidth * kBrightnessSigma)) /
                         (kBrightnessSigma * kBrightnessSigma);
    float d[3];
    IntensityGradient(
        sample.slope_u, sample.slope_v, fx_, fy_, point.data(),
        [&](float a) { return a / point.z(); }, d);
    AddRow(point, d, residual, weight);
  }

  const JointSystem& system() const { return system_; }

 private:
  // The row of a residual whose derivative by p' is d. Few pairs: no lanes.
  void AddRow(const Eigen::Vector3f& point, const float* d, float residual, float weight) {
    float columns[kRowColumns];
    SetRow(point.data(), d, residual, columns);
    const Vector6d row = Eigen::Map<const Eigen::Matrix<float, 6, 1>>(columns).cast<double>();
    system_.hessian.noalias() += (weight * row) * row.transpose();
    system_.right_side.noalias() -= (weight * residual) * row;
  }

  float inverse_depth_sigma_;
  float fx_, fy_;
  float kernel_width_m_;
  JointSystem system_;
};

Vector6d DampedStep(const JointSystem& system, const DescentOptions& options) {
  Matrix6d damped = system.hessian;
  const double along = options.damping * system.weight;
  damped.diagonal().head<3>().array() += along * std::pow(system.RmsDistance(), 2);
  damped.diagonal().tail<3>().array() += along;
  Vector6d step = Vector6d::Zero();
  if (options.rotation_only) {
    step.head<3>() = SolveLdlt3(damped.topLeftCorner<3, 3>(), system.right_side.head<3>());
  } else {
    step = SolveLdlt(damped, system.right_side);
  }
  return step;
}

}  // namespace

double JointSystem::RmsDistance() const {
  return weight > 0 ? std::sqrt(weighted_square_sum / weight) : 0;
}

JointSystem LinearizeJointly(const ViewLevel& source, const ViewLevel& target,
                             double max_distance_m, bool use_brightness,
                             const Rigid3d& target_from_source) {
  const Exposure exposure = use_brightness
                                ? MatchExposure(source, target, max_distance_m, target_from_source)
                                : Exposure();
  JointSums sums(source.surface.noise, target.surface.camera, max_distance_m);
  ForEachPair(source, target, max_distance_m, target_from_source,
              [&](const Landing& landing, const Pair& pair) {
                sums.AddShape(landing.point, pair);
                if (!use_brightness) return;
                const float from = source.brightness.value[landing.source_pixel];
                sums.AddBrightness(landing.point,
                                   SampleAt(target.brightness.value, landing.u, landing.v),
                                   exposure.gain * from + exposure.offset);
              });
  return sums.system();
}

Rigid3d Descend(const ViewLevel& source, const ViewLevel& target, const Rigid3d& start,
                const DescentOptions& options) {
  constexpr double kGateShrinkage = 0.85;
  constexpr double kSmallestStep = 3e-4;  // rad and m
  Rigid3d pose = start;
  double max_distance_m = options.max_distance_m;
  for (int i = 0; i < options.max_steps; ++i) {
    const JointSystem system =
        LinearizeJointly(source, target, max_distance_m, options.use_brightness, pose);
    if (system.pair_count < kMinPairs) break;
    const Vector6d step = DampedStep(system, options);
    pose = LeftIncrement(step, pose);
    if (step.norm() < kSmallestStep) break;
    max_distance_m = std::max(options.max_distance_end_m, kGateShrinkage * max_distance_m);
  }
  return pose;
}

Rigid3d AlignRotation(const ViewPair& views, const Rigid3d& target_from_source_initial) {
  const auto levels =
      static_cast<int>(std::min(views.source.levels.size(), views.target.levels.size()));
  if (levels == 0) return target_from_source_initial;
  const BrightnessLevel source = CoarseBrightness(views.source_color, levels - 1);
  const BrightnessLevel target = CoarseBrightness(views.target_color, levels - 1);
  DescentOptions descent;
  descent.rotation_only = true;
  descent.use_brightness = !source.value.empty() && !target.value.empty();
  return Descend({views.source.levels[levels - 1], source},
                 {views.target.levels[levels - 1], target}, target_from_source_initial, descent);
}

}  // namespace surfit
