#include "registration/global/view_fit.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "surfit/core/lanes.h"
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

// Surfaces at the target pixels of projections, as a structure of arrays.
struct Surfaces {
  static constexpr int kCapacity = Projections::kCapacity;

  int count = 0;
  int projection[kCapacity] = {};                      // index in Projections
  alignas(32) float z[kCapacity] = {};                 // depth of the target, m
  alignas(32) float depth[kCapacity] = {};             // depth of the projection, m
  alignas(32) float gap[3][kCapacity] = {};            // p' - q, m
  alignas(32) float normal[3][kCapacity] = {};         // of the target
  alignas(32) float source_normal[3][kCapacity] = {};  // in the source frame
  // Results, 0 or 1: nearer than the surface by more than kFreeSpaceSigmas; within
  // kFreeSpaceSigmas; and with similar normals.
  std::int32_t in_front[kCapacity] = {}, is_near[kCapacity] = {}, at_surface[kCapacity] = {};
};

// Replaces `surfaces` by those of the projections on a surface with a normal.
void FindSurfaces(const Projections& projections, const FrameLevel& source,
                  const FrameLevel& target, Surfaces* surfaces) {
  int count = 0;
  for (int k = 0; k < projections.count; ++k) {
    const int at = projections.target_pixel[k], from = projections.source_pixel[k];
    const Eigen::Vector3f surface = At(target.vertex, at), normal = At(target.normal, at);
    if (!(surface.z() > 0) || normal.isZero(0)) continue;
    const Eigen::Vector3f gap = projections.Point(k) - surface;
    const Eigen::Vector3f source_normal = At(source.normal, from);
    surfaces->projection[count] = k;
    surfaces->z[count] = surface.z();
    surfaces->depth[count] = projections.z[k];
    for (int axis = 0; axis < 3; ++axis) {
      surfaces->gap[axis][count] = gap[axis];
      surfaces->normal[axis][count] = normal[axis];
      surfaces->source_normal[axis][count] = source_normal[axis];
    }
    ++count;
  }
  surfaces->count = count;
}

// Compares the heights above the surfaces with kFreeSpaceSigmas standard deviations, see
// FreeSpaceViolationRatio(), and the normals.
void CompareSurfaces(const FrameLevel& source, const FrameLevel& target,
                     const ErrorModel& error_model, const Eigen::Matrix3f& rotation,
                     Surfaces* surfaces) {
  WithInstructions([&](auto /*instructions*/) {
    Surfaces& s = *surfaces;
    const auto floor_m = static_cast<float>(error_model.floor_sigma_m);
    const auto source_sigma = static_cast<float>(source.noise.inverse_depth_sigma);
    const auto target_sigma = static_cast<float>(target.noise.inverse_depth_sigma);
    constexpr auto kSigmas = static_cast<float>(kFreeSpaceSigmas);
    // No store changes a copy. NOLINTNEXTLINE(performance-unnecessary-copy-initialization)
    const Eigen::Matrix3f r = rotation;
    for (int k = 0; k < Surfaces::kCapacity; ++k) {
      const float nx = s.normal[0][k], ny = s.normal[1][k], nz = s.normal[2][k];
      const float mx = s.source_normal[0][k], my = s.source_normal[1][k];
      const float mz = s.source_normal[2][k];
      const float height_m = nx * s.gap[0][k] + ny * s.gap[1][k] + nz * s.gap[2][k];
      const float of_source_m = source_sigma * s.depth[k] * s.depth[k];
      const float of_target_m = target_sigma * s.z[k] * s.z[k];
      const float bound2 =
          kSigmas * kSigmas *
          (floor_m * floor_m + of_source_m * of_source_m + of_target_m * of_target_m);
      const float turned_x = r(0, 0) * mx + r(0, 1) * my + r(0, 2) * mz;
      const float turned_y = r(1, 0) * mx + r(1, 1) * my + r(1, 2) * mz;
      const float turned_z = r(2, 0) * mx + r(2, 1) * my + r(2, 2) * mz;
      const float cosine = turned_x * nx + turned_y * ny + turned_z * nz;
      const bool is_beyond = height_m * height_m > bound2;
      s.in_front[k] = is_beyond & (height_m > 0);
      s.is_near[k] = !is_beyond;
      s.at_surface[k] = !is_beyond & (cosine > kMinNormalCosine);
    }
  });
}

Count CountRow(const Projector& projector, const FrameLevel& source, const FrameLevel& target,
               const ErrorModel& error_model, int v) {
  Count count;
  Projections projections;
  Surfaces surfaces;
  for (int u = 0; u < source.vertex.width();) {
    u = projector.Project(u, v, 1, &projections);
    FindSurfaces(projections, source, target, &surfaces);
    CompareSurfaces(source, target, error_model, projector.rotation(), &surfaces);
    for (int i = 0; i < surfaces.count; ++i) {
      count.in_front += surfaces.in_front[i];
      count.at_surface += surfaces.is_near[i];
    }
  }
  return count;
}

}  // namespace

double FreeSpaceViolationRatio(const FrameLevel& source, const FrameLevel& target,
                               const ErrorModel& error_model, const Rigid3d& target_from_source) {
  const Projector projector(source, target.camera, target_from_source);
  const Count count =
      ParallelSum(0, source.vertex.height(), kRowsPerBlock, Count(), [&](int begin, int end) {
        Count sum;
        for (int v = begin; v < end; ++v) {
          sum += CountRow(projector, source, target, error_model, v);
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

int CountDepths(const Image<float>& depth_m, int stride) {
  int count = 0;
  for (int v = stride / 2; v < depth_m.height(); v += stride) {
    for (int u = stride / 2; u < depth_m.width(); u += stride) count += depth_m(u, v) > 0;
  }
  return count;
}

OneWayFit MeasureOneWay(const ViewLevel& source, const ViewLevel& target,
                        const ErrorModel& error_model, const Rigid3d& target_from_source,
                        int stride) {
  OneWayFit fit;
  fit.valid = CountDepths(source.surface.vertex.z, stride);
  const Eigen::Matrix3f rotation = target_from_source.rotation.toRotationMatrix().cast<float>();
  Surfaces surfaces;
  ForEachProjections(
      source.surface, target.surface, target_from_source, stride, [&](const Projections& at) {
        FindSurfaces(at, source.surface, target.surface, &surfaces);
        CompareSurfaces(source.surface, target.surface, error_model, rotation, &surfaces);
        for (int i = 0; i < surfaces.count; ++i) {
          fit.in_front += surfaces.in_front[i];
          if (surfaces.at_surface[i] == 0) continue;
          ++fit.at_surface;
          const int k = surfaces.projection[i];
          fit.value.Add(source.brightness.value[at.source_pixel[k]],
                        SampleAt(target.brightness.value, at.u[k], at.v[k]).value);
          fit.detail.Add(source.brightness.detail[at.source_pixel[k]],
                         SampleAt(target.brightness.detail, at.u[k], at.v[k]).value);
        }
      });
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
