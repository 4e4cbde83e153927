#include "registration/global/view_fit.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "surfit/core/parallel.h"

namespace surfit {
namespace {

struct Count {
  int in_front = 0;
  int at_surface = 0;

  Count& operator+=(const Count& other) {
    in_front += other.in_front;
    at_surface += other.at_surface;
    return *this;
  }
};

// Index of the pixel nearest to a point in the camera frame; -1 outside the image.
int PixelOf(const Eigen::Vector3d& point, const PinholeCamera& camera) {
  if (!(point.z() > 0)) return -1;
  const Eigen::Vector2d pixel = camera.Project(point) + Eigen::Vector2d(0.5, 0.5);
  const bool inside =
      pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() < camera.width && pixel.y() < camera.height;
  return inside ? static_cast<int>(pixel.y()) * camera.width + static_cast<int>(pixel.x()) : -1;
}

// Maximum distance between a source point and the target surface that noise explains, m.
double FreeSpaceBound(const FrameLevel& source, double source_z_m, const FrameLevel& target,
                      double target_z_m, const ErrorModel& error_model) {
  const double of_source_m = error_model.Sigma(source_z_m, source.noise);
  const double of_target_m = target.noise.SigmaZ(target_z_m);
  return kFreeSpaceSigmas * std::sqrt(of_source_m * of_source_m + of_target_m * of_target_m);
}

Count CountRow(const FrameLevel& source, const FrameLevel& target, const ErrorModel& error_model,
               const Rigid3d& target_from_source, int v) {
  const Eigen::Matrix3d rotation = target_from_source.rotation.toRotationMatrix();
  Count count;
  for (int u = 0; u < source.vertex.width(); ++u) {
    if (!(source.vertex.z(u, v) > 0)) continue;
    const Eigen::Vector3d point =
        rotation * source.vertex(u, v).cast<double>() + target_from_source.translation;
    const int pixel = PixelOf(point, target.camera);
    if (pixel < 0) continue;
    const Eigen::Vector3d surface = At(target.vertex, pixel).cast<double>();
    const Eigen::Vector3d normal = At(target.normal, pixel).cast<double>();
    if (!(surface.z() > 0) || normal.isZero(0)) continue;
    const double height_m = normal.dot(point - surface);
    const double bound_m = FreeSpaceBound(source, point.z(), target, surface.z(), error_model);
    count.in_front += height_m > bound_m;
    count.at_surface += std::abs(height_m) <= bound_m;
  }
  return count;
}

constexpr double kDetailSigmaPx = 3;

Image<float> Brightness(const Image<Rgb8>& color) {
  Image<float> brightness(color.width(), color.height());
  ParallelFor(0, color.height(), kRowsPerBlock, [&](int begin, int end) {
    std::transform(color.row(begin), color.row(begin) + std::ptrdiff_t{end - begin} * color.width(),
                   brightness.row(begin), GreyOf);
  });
  return brightness;
}

Image<float> Detail(Image<float>& value) {
  Image<float> detail(value.width(), value.height());
  const cv::Mat in(value.height(), value.width(), CV_32F, value.data());
  cv::Mat out(value.height(), value.width(), CV_32F, detail.data());
  cv::GaussianBlur(in, out, cv::Size(), kDetailSigmaPx);
  cv::subtract(in, out, out);
  return detail;
}

}  // namespace

double FreeSpaceViolationRatio(const FrameLevel& source, const FrameLevel& target,
                               const ErrorModel& error_model, const Rigid3d& target_from_source) {
  const Count count =
      ParallelSum(0, source.vertex.height(), kRowsPerBlock, Count(), [&](int begin, int end) {
        Count sum;
        for (int v = begin; v < end; ++v) {
          sum += CountRow(source, target, error_model, target_from_source, v);
        }
        return sum;
      });
  const int telling = count.in_front + count.at_surface;
  return telling > 0 ? static_cast<double>(count.in_front) / telling : 0;
}

namespace {

// Minimum variances of brightness and brightness detail. Reasons: the rounding step 1 / 255 of
// 8-bit colours, and noise.
constexpr double kValueFloorVariance = 1e-5;
constexpr double kDetailFloorVariance = 1e-6;

struct OneWayFit {
  int valid = 0;
  int at_surface = 0;
  int in_front = 0;
  CorrelationSums value, detail;

  double FreeSpaceViolationRatio() const {
    return in_front > 0 ? static_cast<double>(in_front) / (in_front + at_surface) : 0;
  }
};

OneWayFit MeasureOneWay(const ViewLevel& source, const ViewLevel& target,
                        const ErrorModel& error_model, const Rigid3d& target_from_source,
                        int stride) {
  OneWayFit fit;
  const auto& depth_m = source.surface.vertex.z;
  for (int v = stride / 2; v < depth_m.height(); v += stride) {
    for (int u = stride / 2; u < depth_m.width(); u += stride) fit.valid += depth_m(u, v) > 0;
  }
  const Eigen::Matrix3f rotation = target_from_source.rotation.toRotationMatrix().cast<float>();
  const auto measure = [&](const ProjectedPixel& landing) {
    const Eigen::Vector3f surface = At(target.surface.vertex, landing.target_pixel);
    const Eigen::Vector3f normal = At(target.surface.normal, landing.target_pixel);
    if (!(surface.z() > 0) || normal.isZero(0)) return;
    const double height_m = normal.dot(landing.point - surface);
    const double bound_m =
        FreeSpaceBound(source.surface, landing.point.z(), target.surface, surface.z(), error_model);
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
  ForEachProjection(source.surface, target.surface, target_from_source, measure, stride);
  return fit;
}

// Mutual information of two brightness images with this correlation, in nats per pixel.
double Information(double correlation) {
  constexpr double kLargest = 0.98;  // maximum correlation, because images have noise
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
  constexpr double kWrongFreeSpaceRatio = 0.2;
  const double tells = 1 + Information(value_correlation) + 2 * Information(detail_correlation);
  return std::sqrt(overlap_ratio) * tells *
         std::max(0.01, 1 - free_space_violation_ratio / kWrongFreeSpaceRatio);
}

ViewFit MeasureFit(const ViewLevel& source, const ViewLevel& target, const ErrorModel& error_model,
                   const Rigid3d& target_from_source, int stride) {
  const OneWayFit there = MeasureOneWay(source, target, error_model, target_from_source, stride);
  const OneWayFit back =
      MeasureOneWay(target, source, error_model, target_from_source.Inverse(), stride);
  ViewFit fit;
  const int valid = there.valid + back.valid;
  if (valid == 0) return fit;
  fit.overlap_ratio = static_cast<double>(there.at_surface + back.at_surface) / valid;
  fit.free_space_violation_ratio =
      std::max(there.FreeSpaceViolationRatio(), back.FreeSpaceViolationRatio());
  fit.value_correlation =
      (there.value.Correlation(kValueFloorVariance) + back.value.Correlation(kValueFloorVariance)) /
      2;
  fit.detail_correlation = (there.detail.Correlation(kDetailFloorVariance) +
                            back.detail.Correlation(kDetailFloorVariance)) /
                           2;
  return fit;
}

BrightnessLevel BrightnessOf(Image<float> value) {
  Image<float> detail = Detail(value);
  return {std::move(value), std::move(detail)};
}

std::vector<BrightnessLevel> BrightnessPyramid(const Image<Rgb8>& color, int width, int height,
                                               int levels) {
  CHECK(color.empty() || (color.width() == width && color.height() == height));
  Image<float> value = color.empty() ? Image<float>(width, height) : Brightness(color);
  std::vector<BrightnessLevel> pyramid;
  for (int level = 0; level < levels; ++level) {
    Image<float> next = level + 1 < levels ? HalfResolution(value) : Image<float>();
    pyramid.push_back(BrightnessOf(std::move(value)));
    value = std::move(next);
  }
  return pyramid;
}

BrightnessLevel CoarseBrightness(const Image<Rgb8>& color, int halvings) {
  if (color.empty()) return {};
  Image<float> value = Brightness(color);
  for (int i = 0; i < halvings; ++i) value = HalfResolution(value);
  return {std::move(value), {}};
}

}  // namespace surfit
