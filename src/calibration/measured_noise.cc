// Depth noise from the first frames of a recording: MeasureNoise() of calibrator.h.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "calibration/calibrator.h"
#include "core/median.h"
#include "surfit/frame/preprocess.h"
#include "surfit/registration/icp.h"

namespace surfit {
namespace {

constexpr int kMaxWidth = 320;             // larger images are subsampled
constexpr double kFirstSigma = 0.004;      // noise for the first registrations, 1/m
constexpr double kMaxSigma = 0.05;         // maximum noise for registrations, 1/m
constexpr int kRounds = 2;                 // the last round registers with the measured noise
constexpr double kMinMotion = 2. / 320;    // mean displacement of pixels / image width
constexpr double kMinInlierRatio = 0.3;    // of a registration
constexpr double kMaxDifference = 0.1;     // larger residuals are other surfaces, 1/m
constexpr std::size_t kMinSamples = 1000;  // per pair of frames
constexpr int kMinPairs = 2;

Image<float> Subsampled(const Image<float>& depth_m, int stride, const PinholeCamera& camera) {
  Image<float> some(camera.width, camera.height, 0.f);
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) some(u, v) = depth_m(u * stride, v * stride);
  }
  return some;
}

// Standard deviation of a normal distribution with outliers. The first value is from the median.
// Then residuals beyond three standard deviations are ignored; a normal distribution without them
// has 0.98658 times its standard deviation.
double RobustSigma(const std::vector<float>& residuals) {
  constexpr double kSigmasOfMedian = 1.4826, kMaxSigmas = 3, kCut = 0.98658, kSmallest = 5e-4;
  constexpr int kSteps = 10;
  std::vector<float> sizes(residuals.size());
  std::transform(residuals.begin(), residuals.end(), sizes.begin(),
                 [](float residual) { return std::abs(residual); });
  double sigma = std::max<double>(kSigmasOfMedian * MedianOf(std::move(sizes)), kSmallest);
  for (int step = 0; step < kSteps; ++step) {
    double squares = 0, count = 0;
    for (const float residual : residuals) {
      if (std::abs(residual) > kMaxSigmas * sigma) continue;
      squares += static_cast<double>(residual) * residual;
      ++count;
    }
    sigma = std::sqrt(squares / count) / kCut;
  }
  return sigma;
}

// Rounds to four digits, so that options and files contain the exact value.
double Rounded(double sigma) {
  if (sigma == 0) return 0;
  const double digits = std::pow(10., 3 - std::floor(std::log10(sigma)));
  return std::round(sigma * digits) / digits;
}

struct MeasuredFrame {
  Image<float> depth_m;  // unfiltered
  FramePyramid pyramid;
};

struct Comparison {
  std::vector<float> residuals;  // 1/m
  double motion_px = 0;          // mean displacement of the pixels
};

// Inverse depth of the surface at the pixel coordinates, 1/m: unfiltered depth of the nearest
// pixel, plus the slope of inverse depth at this pixel. With the normal n, the slope along u is n_x
// / (fx n.X). std::nullopt without a surface.
std::optional<double> InverseDepthAt(const MeasuredFrame& frame, const Eigen::Vector2d& pixel) {
  const FrameLevel& level = frame.pyramid.levels.front();
  const int u = static_cast<int>(std::floor(pixel.x() + 0.5));
  const int v = static_cast<int>(std::floor(pixel.y() + 0.5));
  if (u < 0 || v < 0 || u >= level.camera.width || v >= level.camera.height) return {};
  const Eigen::Vector3d normal = level.normal(u, v).cast<double>();
  if (normal.isZero()) return {};
  const double distance = normal.dot(level.vertex(u, v).cast<double>());
  return 1 / frame.depth_m(u, v) + normal.x() / (level.camera.fx * distance) * (pixel.x() - u) +
         normal.y() / (level.camera.fy * distance) * (pixel.y() - v);
}

Comparison Compare(const MeasuredFrame& source, const MeasuredFrame& target,
                   const Rigid3d& target_from_source) {
  const FrameLevel& level = source.pyramid.levels.front();
  Comparison comparison;
  double motion_sum = 0, count = 0;
  for (int v = 0; v < level.camera.height; ++v) {
    for (int u = 0; u < level.camera.width; ++u) {
      if (level.normal(u, v).isZero()) continue;
      const Eigen::Vector3d point =
          target_from_source * Eigen::Vector3d(source.depth_m(u, v) * level.camera.Ray(u, v));
      if (!(point.z() > 0)) continue;
      const Eigen::Vector2d pixel = level.camera.Project(point);
      motion_sum += (pixel - Eigen::Vector2d(u, v)).norm();
      ++count;
      const std::optional<double> measured = InverseDepthAt(target, pixel);
      if (!measured) continue;
      const double residual = 1 / point.z() - *measured;
      if (!(std::abs(residual) < kMaxDifference)) continue;
      comparison.residuals.push_back(static_cast<float>(residual));
    }
  }
  if (count > 0) comparison.motion_px = motion_sum / count;
  return comparison;
}

// Registers each frame to the last reference frame. The first frame with enough motion is compared,
// and becomes the next reference frame.
std::optional<MeasuredNoise> MeasureWith(const DepthSensor& sensor,
                                         const std::vector<Image<float>>& depths_m) {
  MeasuredNoise measured;
  std::vector<float> residuals;
  std::optional<MeasuredFrame> reference;
  Rigid3d reference_from_frame;
  for (const Image<float>& depth_m : depths_m) {
    MeasuredFrame frame = {depth_m, PreprocessDepth(depth_m, sensor, {})};
    bool is_next = !reference;
    if (reference) {
      const IcpResult icp =
          Register(frame.pyramid, reference->pyramid, reference_from_frame, IcpOptions());
      is_next = !icp.Succeeded() || icp.inlier_ratio < kMinInlierRatio;
      if (!is_next) {
        reference_from_frame = icp.target_from_source;
        const Comparison found = Compare(frame, *reference, reference_from_frame);
        is_next = found.motion_px >= kMinMotion * sensor.camera.width;
        if (is_next && found.residuals.size() >= kMinSamples) {
          residuals.insert(residuals.end(), found.residuals.begin(), found.residuals.end());
          ++measured.pairs;
        }
      }
    }
    if (!is_next) continue;
    reference = std::move(frame);
    reference_from_frame = {};
  }
  if (measured.pairs < kMinPairs) return std::nullopt;
  measured.inverse_depth_sigma = Rounded(RobustSigma(residuals) / std::sqrt(2.));
  measured.samples = static_cast<std::int64_t>(residuals.size());
  return measured;
}

}  // namespace

DepthNoise MeasuredNoise::Noise() const { return {std::max(inverse_depth_sigma, kMinSigma)}; }

bool MeasuredNoise::Contradicts(const DepthNoise& start) const {
  const double ratio = Noise().inverse_depth_sigma / start.inverse_depth_sigma;
  return std::max(ratio, 1 / ratio) > kMaxRatio;
}

std::optional<MeasuredNoise> MeasureNoise(const std::vector<Image<float>>& depths_m,
                                          const PinholeCamera& camera) {
  const int stride = (camera.width + kMaxWidth - 1) / kMaxWidth;
  DepthSensor sensor = {camera.Subsampled(stride), {kFirstSigma}};
  std::vector<Image<float>> some;
  for (const Image<float>& depth_m : depths_m) {
    if (depth_m.width() != camera.width || depth_m.height() != camera.height) continue;
    some.push_back(Subsampled(depth_m, stride, sensor.camera));
  }
  std::optional<MeasuredNoise> measured;
  for (int round = 0; round < kRounds; ++round) {
    measured = MeasureWith(sensor, some);
    if (!measured) break;
    sensor.noise.inverse_depth_sigma = std::min(measured->Noise().inverse_depth_sigma, kMaxSigma);
  }
  return measured;
}

}  // namespace surfit
