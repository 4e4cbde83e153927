#include "registration/view_fit.h"

#include <algorithm>
#include <cmath>

#include "surfit/registration/free_space.h"

namespace surfit {
namespace {

constexpr float kMinNormalCosine = 0.8f;
// 8-bit colours are rounded by 1 / 255 at least, and noisy.
constexpr double kValueFloorVariance = 1e-5;
constexpr double kDetailFloorVariance = 1e-6;

struct OneWayFit {
  int valid = 0;
  int at_surface = 0;
  int in_front = 0;
  CorrelationSums value, detail;

  double FreeSpaceShare() const {
    return in_front > 0 ? static_cast<double>(in_front) / (in_front + at_surface) : 0;
  }
};

OneWayFit MeasureOneWay(const ViewLevel& source, const ViewLevel& target,
                        const ErrorModel& error_model, const Rigid3d& target_from_source) {
  OneWayFit fit;
  const auto& depth_m = source.surface.vertex.z;
  fit.valid = static_cast<int>(
      std::count_if(depth_m.begin(), depth_m.end(), [](float z) { return z > 0; }));
  const Eigen::Matrix3f rotation = target_from_source.rotation.toRotationMatrix().cast<float>();
  const auto measure = [&](const Landing& landing) {
    const Eigen::Vector3f surface = At(target.surface.vertex, landing.target_pixel);
    const Eigen::Vector3f normal = At(target.surface.normal, landing.target_pixel);
    if (!(surface.z() > 0) || normal.isZero(0)) return;
    const double height_m = normal.dot(landing.point - surface);
    const double sigma_m = std::hypot(error_model.Sigma(landing.point.z(), source.surface.noise),
                                      target.surface.noise.SigmaZ(surface.z()));
    const double bound_m = kFreeSpaceSigmas * sigma_m;
    if (height_m > bound_m) ++fit.in_front;
    if (std::abs(height_m) > bound_m) return;
    const Eigen::Vector3f turned = rotation * At(source.surface.normal, landing.source_pixel);
    if (!(turned.dot(normal) > kMinNormalCosine)) return;
    ++fit.at_surface;
    fit.value.Add(source.brightness.value[landing.source_pixel],
                  SampleAt(target.brightness.value, landing.u, landing.v).value);
    fit.detail.Add(source.brightness.detail[landing.source_pixel],
                   SampleAt(target.brightness.detail, landing.u, landing.v).value);
  };
  ForEachLanding(source.surface, target.surface, target_from_source, measure);
  return fit;
}

// What one image tells of the other, in nats per pixel.
double Information(double correlation) {
  constexpr double kLargest = 0.98;  // of what noise leaves
  const double rho = std::clamp(correlation, 0., kLargest);
  return -0.5 * std::log(1 - rho * rho);
}

}  // namespace

void CorrelationSums::Add(double value_a, double value_b) {
  count += 1;
  a += value_a;
  b += value_b;
  aa += value_a * value_a;
  bb += value_b * value_b;
  ab += value_a * value_b;
}

double CorrelationSums::Correlation(double floor_variance) const {
  if (count == 0) return 0;
  const double mean_a = a / count, mean_b = b / count;
  const double variance_a = aa / count - mean_a * mean_a + floor_variance;
  const double variance_b = bb / count - mean_b * mean_b + floor_variance;
  return (ab / count - mean_a * mean_b) / std::sqrt(variance_a * variance_b);
}

double ViewFit::Score() const {
  constexpr double kWrongFreeSpaceShare = 0.2;
  const double tells = 1 + Information(value_correlation) + 2 * Information(detail_correlation);
  return std::sqrt(overlap_share) * tells *
         std::max(0.01, 1 - free_space_share / kWrongFreeSpaceShare);
}

ViewFit MeasureFit(const ViewLevel& source, const ViewLevel& target, const ErrorModel& error_model,
                   const Rigid3d& target_from_source) {
  const OneWayFit there = MeasureOneWay(source, target, error_model, target_from_source);
  const OneWayFit back = MeasureOneWay(target, source, error_model, target_from_source.Inverse());
  ViewFit fit;
  const int valid = there.valid + back.valid;
  if (valid == 0) return fit;
  fit.overlap_share = static_cast<double>(there.at_surface + back.at_surface) / valid;
  fit.free_space_share = std::max(there.FreeSpaceShare(), back.FreeSpaceShare());
  fit.value_correlation =
      (there.value.Correlation(kValueFloorVariance) + back.value.Correlation(kValueFloorVariance)) /
      2;
  fit.detail_correlation = (there.detail.Correlation(kDetailFloorVariance) +
                            back.detail.Correlation(kDetailFloorVariance)) /
                           2;
  return fit;
}

}  // namespace surfit
