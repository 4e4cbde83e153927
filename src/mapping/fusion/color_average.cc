#include "mapping/fusion/color_average.h"

#include <algorithm>
#include <cstdint>

#include "mapping/rendering/bands.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

constexpr int kColumns = 200;
constexpr float kHiddenBehind = 1.05f;

// Camera with rays to the samples of call `index`. Images of fewer than kColumns columns have
// several samples per pixel.
PinholeCamera CameraOfSamples(PinholeCamera camera, int index) {
  const int ratio = (kColumns + camera.width - 1) / camera.width;
  if (ratio > 1) {
    camera.width *= ratio;
    camera.height *= ratio;
    camera.fx *= ratio;
    camera.fy *= ratio;
    camera.cx = ratio * (camera.cx + 0.5) - 0.5;
    camera.cy = ratio * (camera.cy + 0.5) - 0.5;
    return camera;
  }
  const int step = camera.width / kColumns, u = index % step, v = index / step % step;
  camera.width -= u;
  camera.height -= v;
  camera.cx -= u;
  camera.cy -= v;
  return camera.Subsampled(step);
}

class MeasuredOcclusion {
 public:
  MeasuredOcclusion(const DepthPicture& measured, const Rigid3d& world_from_view)
      : measured_(measured) {
    const Rigid3f pose = world_from_view.cast<float>();
    rotation_ = measured.camera.rotation * pose.rotation.toRotationMatrix();
    translation_ = measured.camera.rotation * pose.translation + measured.camera.translation;
  }

  // True for points outside of the image or at a pixel without depth.
  bool Hides(const Eigen::Vector3f& point_in_view) const {
    const PosedCamera& camera = measured_.camera;
    const Image<float>& depth_m = measured_.depth_m;
    const Eigen::Vector3f p = rotation_ * point_in_view + translation_;
    if (!(p.z() > kMinDepth)) return true;
    const float u = camera.fx * p.x() / p.z() + camera.cx + 0.5f;
    const float v = camera.fy * p.y() / p.z() + camera.cy + 0.5f;
    if (!(u >= 0 && v >= 0 && u < static_cast<float>(depth_m.width()) &&
          v < static_cast<float>(depth_m.height()))) {
      return true;
    }
    const int at_u = static_cast<int>(u), at_v = static_cast<int>(v);
    if (!(depth_m(at_u, at_v) > 0)) return true;
    for (int y = std::max(0, at_v - 1); y <= std::min(depth_m.height() - 1, at_v + 1); ++y) {
      for (int x = std::max(0, at_u - 1); x <= std::min(depth_m.width() - 1, at_u + 1); ++x) {
        if (depth_m(x, y) > 0 && p.z() > kHiddenBehind * depth_m(x, y)) return true;
      }
    }
    return false;
  }

 private:
  const DepthPicture& measured_;
  Eigen::Matrix3f rotation_;  // camera of the depth from camera of the view
  Eigen::Vector3f translation_;
};

// Colour of a pixel in a band.
struct PixelColor {
  int pixel;
  Eigen::Vector3f color;
};

class BandColors {
 public:
  BandColors(const std::vector<BlendShares>& bands, const PinholeCamera& camera,
             const FrameColors& colors, const MeasuredOcclusion& measured)
      : bands_(bands), camera_(camera), colors_(colors), measured_(measured) {}

  // Colours of the pixels of a band that show the map.
  std::vector<PixelColor> Of(int band) const {
    std::vector<PixelColor> found;
    std::vector<int> pixels;
    ColorBatch batch;
    const auto look_up = [&] {
      colors_.LookUp(&batch);
      for (int i = 0; i < batch.count; ++i) {
        const SeenColor seen = batch.Seen(i);
        if (seen.weight > 0) found.push_back({pixels[i], seen.color});
      }
      pixels.clear();
      batch.count = 0;
    };
    const auto count = static_cast<int>(bands_[band].depth_m.size());
    for (int i = 0; i < count; ++i) {
      const float z = bands_[band].depth_m[i];
      const int u = i % camera_.width, v = band * kBandRows + i / camera_.width;
      if (!(z > 0) || IsBesideOccluder(u, v, z)) continue;
      const Eigen::Vector3f ray = camera_.Ray(u, v).cast<float>();
      if (measured_.Hides(z * ray)) continue;
      batch.Add(z * ray, -ray.normalized());
      pixels.push_back(i);
      if (batch.count == ColorBatch::kCapacity) look_up();
    }
    look_up();
    return found;
  }

 private:
  float DepthAt(int u, int v) const {
    return bands_[v / kBandRows].depth_m[v % kBandRows * camera_.width + u];
  }

  bool IsBesideOccluder(int u, int v, float z) const {
    for (int y = std::max(0, v - 1); y <= std::min(camera_.height - 1, v + 1); ++y) {
      for (int x = std::max(0, u - 1); x <= std::min(camera_.width - 1, u + 1); ++x) {
        if (DepthAt(x, y) > 0 && z > kHiddenBehind * DepthAt(x, y)) return true;
      }
    }
    return false;
  }

  const std::vector<BlendShares>& bands_;
  const PinholeCamera& camera_;
  const FrameColors& colors_;
  const MeasuredOcclusion& measured_;
};

}  // namespace

ColorAverage::ColorAverage(const SurfelMap& map) : map_(map), sums_(map.id_end()) {}

void ColorAverage::Add(const FrameColors& colors, const DepthSensor& sensor,
                       const Rigid3d& world_from_camera, const DepthPicture& measured) {
  DepthSensor samples = sensor;
  samples.camera = CameraOfSamples(sensor.camera, added_++);
  const std::vector<BlendShares> bands = FindBlendShares(map_, samples, world_from_camera);
  const MeasuredOcclusion occlusion(measured, world_from_camera);
  const BandColors band_colors(bands, samples.camera, colors, occlusion);
  const auto band_count = static_cast<int>(bands.size());
  std::vector<std::vector<PixelColor>> found(band_count);
  ParallelFor(0, band_count, 1, [&](int band, int) { found[band] = band_colors.Of(band); });
  for (int band = 0; band < band_count; ++band) {
    for (const PixelColor& pixel : found[band]) {
      const std::uint32_t end = bands[band].first[pixel.pixel + 1];
      for (std::uint32_t i = bands[band].first[pixel.pixel]; i < end; ++i) {
        const BlendShares::Share& share = bands[band].shares[i];
        Sum& sum = sums_[share.surfel];
        sum.color += share.weight * pixel.color;
        sum.weight += share.weight;
      }
    }
  }
}

void ColorAverage::WriteTo(SurfelMap* map) const {
  for (const std::int32_t id : map->Ids()) {
    const Sum& sum = sums_[id];
    if (!(sum.weight > 0)) continue;
    map->block(id / SurfelBlock::kCapacity)
        .SetColor(id % SurfelBlock::kCapacity, sum.color / sum.weight, sum.weight);
  }
}

}  // namespace surfit
