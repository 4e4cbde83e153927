#include "surfit/loop_closure/keyframe.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "registration/global/feature_points.h"
#include "surfit/core/options.h"

namespace surfit {
namespace {

// 0 if the depth is too large.
std::uint16_t CompactDepth(double depth_m) {
  const double units = std::round(depth_m * PlaceView::kDepthUnitsPerMetre);
  return units <= std::numeric_limits<std::uint16_t>::max() ? static_cast<std::uint16_t>(units) : 0;
}

Image<std::uint16_t> CompactDepth(const Image<float>& depth_m) {
  Image<std::uint16_t> compact(depth_m.width(), depth_m.height());
  for (std::size_t i = 0; i < depth_m.size(); ++i) {
    compact[i] = CompactDepth(static_cast<double>(depth_m[i]));
  }
  return compact;
}

// 0 if the corrected depth is not valid.
std::uint16_t RecalibratedDepth(std::uint16_t depth, const Eigen::Vector2d& pixel,
                                const DepthCalibration& from, const DepthCalibration& to) {
  if (depth == 0) return 0;
  const Eigen::Vector3d before = from.camera.Ray(pixel.x(), pixel.y());
  const Eigen::Vector3d after = to.camera.Ray(pixel.x(), pixel.y());
  const double inverse = PlaceView::kDepthUnitsPerMetre / depth -
                         from.field.At(before.x(), before.y()) + to.field.At(after.x(), after.y());
  return inverse > InverseDepthField::kMinInverse ? CompactDepth(1 / inverse) : 0;
}

Image<float> DepthOf(const PlaceView& view) {
  Image<float> depth_m(view.depth.width(), view.depth.height());
  for (std::size_t i = 0; i < depth_m.size(); ++i) {
    depth_m[i] = static_cast<float>(view.depth[i] / PlaceView::kDepthUnitsPerMetre);
  }
  return depth_m;
}

// Grey image with NaN for pixels without colour. HalfResolution() returns NaN for blocks with a NaN
// pixel.
Image<float> GreyImage(const Image<Rgb8>& color) {
  Image<float> grey(color.width(), color.height());
  for (std::size_t i = 0; i < color.size(); ++i) {
    grey[i] = color[i] == Rgb8() ? std::numeric_limits<float>::quiet_NaN() : GreyOf(color[i]);
  }
  return grey;
}

Image<std::uint8_t> CompactIntensity(const Image<Rgb8>& color, int halvings) {
  if (color.empty()) return {};
  Image<float> grey = GreyImage(color);
  for (int i = 0; i < halvings; ++i) grey = HalfResolution(grey);
  Image<std::uint8_t> compact(grey.width(), grey.height());
  for (std::size_t i = 0; i < grey.size(); ++i) {
    if (grey[i] >= 0) compact[i] = static_cast<std::uint8_t>(std::lround(1 + 254 * grey[i]));
  }
  return compact;
}

Image<float> IntensityOf(const PlaceView& view) {
  Image<float> intensity(view.intensity.width(), view.intensity.height());
  for (std::size_t i = 0; i < intensity.size(); ++i) {
    intensity[i] = view.intensity[i] == 0 ? std::numeric_limits<float>::quiet_NaN()
                                          : static_cast<float>(view.intensity[i] - 1) / 254;
  }
  return intensity;
}

// Shaded relief: the brightness of a pixel is the slope of the smoothed depth to the right and
// down. Near viewpoints have similar reliefs. Pixels without depth are black.
Image<Rgb8> ReliefOf(const FrameLevel& surface) {
  constexpr double kBlur_px = 1.5;
  constexpr float kMinWeight = 0.6f;
  constexpr int kHalfStep_px = 2;
  constexpr float kGrey = 128, kContrast = 60;
  const Image<float>& depth_m = surface.vertex.z;
  const int width = depth_m.width(), height = depth_m.height();
  Image<float> weight(width, height), smooth_m = depth_m;
  for (std::size_t i = 0; i < depth_m.size(); ++i) weight[i] = depth_m[i] > 0 ? 1 : 0;
  for (Image<float>* image : {&weight, &smooth_m}) {
    cv::Mat pixels(height, width, CV_32FC1, image->data());
    cv::GaussianBlur(pixels, pixels, {}, kBlur_px);
  }
  for (std::size_t i = 0; i < depth_m.size(); ++i) {
    smooth_m[i] = depth_m[i] > 0 && weight[i] > kMinWeight ? smooth_m[i] / weight[i] : 0;
  }
  Image<Rgb8> relief(width, height);
  for (int v = kHalfStep_px; v + kHalfStep_px < height; ++v) {
    for (int u = kHalfStep_px; u + kHalfStep_px < width; ++u) {
      const float z = smooth_m(u, v);
      const float left = smooth_m(u - kHalfStep_px, v), right = smooth_m(u + kHalfStep_px, v);
      const float up = smooth_m(u, v - kHalfStep_px), down = smooth_m(u, v + kHalfStep_px);
      if (!(z > 0 && left > 0 && right > 0 && up > 0 && down > 0)) continue;
      const double x = surface.camera.fx * (right - left) / (2 * kHalfStep_px * z);
      const double y = surface.camera.fy * (down - up) / (2 * kHalfStep_px * z);
      const double grey = kGrey + kContrast * (x + y) / std::sqrt(1 + x * x + y * y);
      const auto value = static_cast<std::uint8_t>(std::lround(grey));
      relief(u, v) = {value, value, value};
    }
  }
  return relief;
}

std::vector<PlaceFeature> FindPlaceFeatures(const Image<Rgb8>& color, const FrameLevel& surface,
                                            int max_count) {
  const FeaturePoints found = FindFeatures(color, surface, ErrorModel(), max_count);
  std::vector<PlaceFeature> features;
  features.reserve(found.points.size());
  for (int i = 0; i < found.size(); ++i) {
    features.push_back({found.points[i].cast<float>(), found.descriptors[i]});
  }
  return features;
}

// Finest level within the maximum width, or the coarsest level.
int LevelOf(const FramePyramid& pyramid, const PlaceViewOptions& options) {
  int level = 0;
  while (level + 1 < static_cast<int>(pyramid.levels.size()) &&
         pyramid.levels[level].camera.width > options.max_width) {
    ++level;
  }
  return level;
}

}  // namespace

std::size_t PlaceView::Bytes() const {
  return depth.size() * sizeof(depth[0]) + intensity.size() * sizeof(intensity[0]) +
         features.size() * sizeof(features[0]);
}

PlaceView MakeDepthView(const FramePyramid& pyramid, const PlaceViewOptions& options) {
  Validate(options);
  PlaceView view;
  const FrameLevel& surface = pyramid.levels[LevelOf(pyramid, options)];
  view.camera = surface.camera;
  view.noise = surface.noise;
  view.depth = CompactDepth(surface.vertex.z);
  return view;
}

PlaceView MakePlaceView(const FramePyramid& pyramid, const Image<Rgb8>& color,
                        const PlaceViewOptions& options) {
  PlaceView view = MakeDepthView(pyramid, options);
  const int level = LevelOf(pyramid, options);
  const FrameLevel& surface = pyramid.levels[level];
  view.intensity = CompactIntensity(color, level);
  view.features = color.empty()
                      ? FindPlaceFeatures(ReliefOf(surface), surface, options.max_features)
                      : FindPlaceFeatures(color, pyramid.levels.front(), options.max_features);
  return view;
}

void Recalibrate(const DepthCalibration& to, PlaceView* view) {
  if (view->empty()) return;
  const DepthCalibration old = {view->camera, view->field, 0};
  const int binning = std::max(
      1, static_cast<int>(std::lround(static_cast<double>(to.camera.width) / view->camera.width)));
  const DepthCalibration changed = {to.camera.Binned(binning), to.field, 0};
  if (AreSame(old, changed)) return;
  view->camera = changed.camera;
  view->field = changed.field;
  for (int v = 0; v < view->depth.height(); ++v) {
    for (int u = 0; u < view->depth.width(); ++u) {
      view->depth(u, v) = RecalibratedDepth(view->depth(u, v), {u, v}, old, changed);
    }
  }
  std::vector<PlaceFeature> features;
  for (PlaceFeature& feature : view->features) {
    const Eigen::Vector3d point = Recalibrated(feature.point.cast<double>(), old, changed);
    if (!(point.z() > 0 && point.z() < 1 / InverseDepthField::kMinInverse)) continue;
    feature.point = point.cast<float>();
    features.push_back(feature);
  }
  view->features = std::move(features);
}

FramePyramid PyramidOf(const PlaceView& view, const PreprocessOptions& options) {
  FrameLevel finest;
  finest.camera = view.camera;
  finest.noise = view.noise;
  finest.vertex = VertexMap(DepthOf(view), view.camera);
  finest.normal = NormalMap(finest.vertex, finest.sensor(), options);
  FramePyramid pyramid = BuildPyramid(std::move(finest), options);
  if (view.intensity.empty()) return pyramid;
  pyramid.levels.front().intensity = IntensityOf(view);
  for (std::size_t i = 1; i < pyramid.levels.size(); ++i) {
    pyramid.levels[i].intensity = HalfResolution(pyramid.levels[i - 1].intensity);
  }
  return pyramid;
}

}  // namespace surfit
