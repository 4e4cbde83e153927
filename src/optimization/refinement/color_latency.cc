#include "surfit/optimization/color_latency.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

namespace surfit {
namespace {

constexpr int kStride = 4;
constexpr int kNeighbours = 3;  // each keyframe is compared with this number of preceding keyframes
constexpr int kMinKeyframes = 10;  // minimum for the scatter of the gradients
constexpr int kMaxIterations = 15;
constexpr double kConverged_s = 1e-4;
constexpr double kMaxLatency_s = 0.1;  // validity of the constant-velocity assumption
// Unit: intensity in [0, 1]. A narrow kernel would reject informative points with large initial
// residuals.
constexpr double kKernelWidth = 0.3;
constexpr double kMaxDepthSigmas = 6;     // gate on the difference of inverse depth
constexpr double kModelSigma_s = 0.0015;  // systematic error by timestamps and exposure
constexpr double kSureSigmas = 3;

struct Sighting {
  double value = 0, by_latency = 0;
};

// Normal equations of one pair of keyframes, from weighted rows (by latency, gain, offset |
// residual).
struct PairSums {
  Eigen::Matrix3d hessian = Eigen::Matrix3d::Zero();
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
};

struct LatencySums {
  double hessian = 0, gradient = 0;
};

class ColorComparison {
 public:
  ColorComparison(const std::vector<ColoredKeyframe>& keyframes, const PinholeCamera& camera)
      : keyframes_(keyframes), camera_(camera) {}

  LatencySums SumsOf(int k, double latency_s) const {
    LatencySums sums;
    for (int j = std::max(0, k - kNeighbours); j < k; ++j) {
      const std::optional<LatencySums> pair = SumsOfPair(keyframes_[k], keyframes_[j], latency_s);
      if (!pair) continue;
      sums.hessian += pair->hessian;
      sums.gradient += pair->gradient;
    }
    return sums;
  }

 private:
  struct Row {
    Sighting here, there;
  };

  std::optional<LatencySums> SumsOfPair(const ColoredKeyframe& here, const ColoredKeyframe& there,
                                        double latency_s) const;
  std::vector<Row> RowsOf(const ColoredKeyframe& here, const ColoredKeyframe& there,
                          double latency_s) const;
  std::optional<Sighting> See(const ColoredKeyframe& colored, const Eigen::Vector3d& point,
                              double latency_s) const;

  const std::vector<ColoredKeyframe>& keyframes_;
  PinholeCamera camera_;
};

bool IsSurface(const KeyframeImages& images, int u, int v) {
  return images.inverse_depth(u, v) > 0 && std::isfinite(images.slope_u(u, v));
}

std::optional<Sighting> ColorComparison::See(const ColoredKeyframe& colored,
                                             const Eigen::Vector3d& point, double latency_s) const {
  const KeyframeImages& images = colored.keyframe.images;
  const CameraMotion& motion = images.readout.motion;
  const Eigen::Vector3d way =
      motion.angular_velocity_rad_per_s.cross(point) + motion.velocity_m_per_s;
  const double rho = 1 / point.z(), x = point.x() * rho, y = point.y() * rho;
  const double u_per_s = -camera_.fx * rho * (way.x() - x * way.z());
  const double v_per_s = -camera_.fy * rho * (way.y() - y * way.z());
  const double t = colored.color_after_s - latency_s;
  const double u = camera_.fx * x + camera_.cx + u_per_s * t;
  const double v = camera_.fy * y + camera_.cy + v_per_s * t;
  const Image<float>& intensity = images.intensity;
  if (!(u >= 0 && v >= 0 && u < intensity.width() - 1 && v < intensity.height() - 1)) return {};
  const int left = static_cast<int>(u), top = static_cast<int>(v);
  const double right = u - left, below = v - top;
  const double a = intensity(left, top), b = intensity(left + 1, top);
  const double c = intensity(left, top + 1), d = intensity(left + 1, top + 1);
  const double by_u = (1 - below) * (b - a) + below * (d - c);
  const double by_v = (1 - right) * (c - a) + right * (d - b);
  const double value = a + right * (b - a) + below * (c - a) + right * below * (a - b - c + d);
  if (!std::isfinite(value)) return {};
  return Sighting{value, -(by_u * u_per_s + by_v * v_per_s)};
}

std::vector<ColorComparison::Row> ColorComparison::RowsOf(const ColoredKeyframe& here,
                                                          const ColoredKeyframe& there,
                                                          double latency_s) const {
  const KeyframeImages &images = here.keyframe.images, &others = there.keyframe.images;
  const Rigid3d there_from_here =
      there.keyframe.world_from_camera.Inverse() * here.keyframe.world_from_camera;
  const double max_difference = kMaxDepthSigmas * images.noise.inverse_depth_sigma;
  std::vector<Row> rows;
  for (int v = 0; v < camera_.height; v += kStride) {
    for (int u = 0; u < camera_.width; u += kStride) {
      if (!IsSurface(images, u, v)) continue;
      const Eigen::Vector3d point = camera_.Ray(u, v) / images.inverse_depth(u, v);
      const Eigen::Vector3d seen = there_from_here * point;
      if (!(seen.z() > 0)) continue;
      const Eigen::Vector2d pixel = camera_.Project(seen);
      const int at_u = static_cast<int>(std::floor(pixel.x() + 0.5));
      const int at_v = static_cast<int>(std::floor(pixel.y() + 0.5));
      const bool inside = at_u >= 0 && at_v >= 0 && at_u < camera_.width && at_v < camera_.height;
      if (!inside || !IsSurface(others, at_u, at_v)) continue;
      if (std::abs(1 / seen.z() - others.inverse_depth(at_u, at_v)) > max_difference) continue;
      const std::optional<Sighting> a = See(here, point, latency_s);
      const std::optional<Sighting> b = See(there, seen, latency_s);
      if (a && b) rows.push_back({*a, *b});
    }
  }
  return rows;
}

// The second pass repeats the estimate of gain and offset with updated kernel weights.
std::optional<LatencySums> ColorComparison::SumsOfPair(const ColoredKeyframe& here,
                                                       const ColoredKeyframe& there,
                                                       double latency_s) const {
  constexpr std::size_t kMinRows = 100;
  const std::vector<Row> rows = RowsOf(here, there, latency_s);
  if (rows.size() < kMinRows) return {};
  double gain = 1, offset = 0;
  for (const Row& row : rows) {
    offset += (row.here.value - row.there.value) / static_cast<double>(rows.size());
  }
  LatencySums sums;
  for (int pass = 0; pass < 2; ++pass) {
    PairSums pair;
    for (const Row& row : rows) {
      const double residual = row.here.value - gain * row.there.value - offset;
      const double share = residual / kKernelWidth;
      const double weight = 1 / ((1 + share * share) * (1 + share * share));
      const Eigen::Vector3d a(row.here.by_latency - gain * row.there.by_latency, -row.there.value,
                              -1);
      pair.hessian += weight * a * a.transpose();
      pair.gradient += weight * residual * a;
    }
    const Eigen::LDLT<Eigen::Matrix2d> of_exposure(pair.hessian.bottomRightCorner<2, 2>());
    const Eigen::Vector2d change = of_exposure.solve(pair.gradient.tail<2>());
    const Eigen::Vector2d cross = pair.hessian.col(0).tail<2>();
    if (!change.allFinite()) return {};
    sums = {pair.hessian(0, 0) - cross.dot(of_exposure.solve(cross)),
            pair.gradient[0] - cross.dot(change)};
    gain -= change[0];
    offset -= change[1];
  }
  return sums;
}

// Variance of a sum of correlated terms (Newey and West 1987). Neighbouring terms share
// keyframes.
double VarianceOfSum(const std::vector<double>& terms) {
  double variance = 0;
  for (std::size_t lag = 0; lag <= kNeighbours; ++lag) {
    const double weight = (lag == 0 ? 1 : 2) * (1 - static_cast<double>(lag) / (kNeighbours + 1));
    for (std::size_t k = lag; k < terms.size(); ++k) variance += weight * terms[k] * terms[k - lag];
  }
  return variance;
}

// Combines an estimate with the zero-mean prior. Variances are in s^2.
ColorLatency WithPrior(double latency_s, double variance, double prior_variance, int keyframes) {
  const double joint_s = latency_s * prior_variance / (prior_variance + variance);
  const double sigma_s = std::sqrt(variance * prior_variance / (prior_variance + variance));
  return {std::abs(joint_s) > kSureSigmas * sigma_s ? joint_s : 0, sigma_s, keyframes};
}

}  // namespace

ColorLatency EstimateColorLatency(const std::vector<ColoredKeyframe>& keyframes,
                                  const PinholeCamera& camera, double prior_sigma_s) {
  const ColorComparison comparison(keyframes, camera);
  double latency_s = 0;
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    double hessian = 0;
    std::vector<double> gradients;
    for (int k = 1; k < static_cast<int>(keyframes.size()); ++k) {
      const LatencySums sums = comparison.SumsOf(k, latency_s);
      if (!(sums.hessian > 0)) continue;
      hessian += sums.hessian;
      gradients.push_back(sums.gradient);
    }
    const int count = static_cast<int>(gradients.size());
    if (count < kMinKeyframes) break;
    const double step_s = -std::accumulate(gradients.begin(), gradients.end(), 0.) / hessian;
    latency_s += step_s;
    if (!(std::abs(latency_s) < kMaxLatency_s)) break;
    if (std::abs(step_s) > kConverged_s) continue;
    const double variance = VarianceOfSum(gradients) / (hessian * hessian);
    return WithPrior(latency_s, variance + kModelSigma_s * kModelSigma_s,
                     prior_sigma_s * prior_sigma_s, count);
  }
  return {0, prior_sigma_s, 0};
}

}  // namespace surfit
