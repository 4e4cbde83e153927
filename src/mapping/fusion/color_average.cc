#include "mapping/fusion/color_average.h"

#include <algorithm>
#include <array>
#include <cstdint>

#include "mapping/rendering/bands.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

constexpr int kColumns = 240;
constexpr float kHiddenBehind = 1.05f;
constexpr float kNoColor = -1;
constexpr int kBandsAtOnce = 2;  // bounds the memory of the shares

// Camera with rays to the samples of call `index`.
PinholeCamera CameraOfSamples(PinholeCamera camera, int index) {
  const int step = std::max(1, camera.width / kColumns);
  const int u = index % step, v = index / step % step;
  camera.width -= u;
  camera.height -= v;
  camera.cx -= u;
  camera.cy -= v;
  return camera.Subsampled(step);
}

class Occlusion {
 public:
  Occlusion(const DepthPicture& shown, const Rigid3d& world_from_view) : shown_(shown) {
    const Rigid3f pose = world_from_view.cast<float>();
    rotation_ = shown.camera.rotation * pose.rotation.toRotationMatrix();
    translation_ = shown.camera.rotation * pose.translation + shown.camera.translation;
  }

  // True for points outside of the image or at a pixel without depth.
  bool Hides(const Eigen::Vector3f& point_in_view) const {
    const PosedCamera& camera = shown_.camera;
    const Image<float>& depth_m = shown_.depth_m;
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
  const DepthPicture& shown_;
  Eigen::Matrix3f rotation_;  // camera of the depth from camera of the view
  Eigen::Vector3f translation_;
};

// Colours of the samples of an image that show the map.
class SampleColors {
 public:
  SampleColors(const Image<float>& depth_m, const PinholeCamera& camera, const FrameColors& colors,
               const std::vector<Occlusion>& occlusions)
      : depth_m_(depth_m), camera_(camera), colors_(colors), occlusions_(occlusions) {}

  // Writes the colours of a band of kBandRows rows. Other samples keep their values.
  void Write(int band, Image<Eigen::Vector3f>* found) const {
    std::vector<std::size_t> pixels;
    ColorBatch batch;
    const auto look_up = [&] {
      colors_.LookUp(&batch);
      for (int i = 0; i < batch.count; ++i) {
        const SeenColor seen = batch.Seen(i);
        if (seen.weight > 0) (*found)[pixels[i]] = seen.color;
      }
      pixels.clear();
      batch.count = 0;
    };
    const int end = std::min(camera_.height, (band + 1) * kBandRows);
    for (int v = band * kBandRows; v < end; ++v) {
      for (int u = 0; u < camera_.width; ++u) {
        const float z = depth_m_(u, v);
        if (!(z > 0) || IsBesideOccluder(u, v, z)) continue;
        const Eigen::Vector3f ray = camera_.Ray(u, v).cast<float>();
        if (!IsShown(z * ray)) continue;
        batch.Add(z * ray, -ray.normalized());
        pixels.push_back(static_cast<std::size_t>(v) * camera_.width + u);
        if (batch.count == ColorBatch::kCapacity) look_up();
      }
    }
    look_up();
  }

 private:
  bool IsShown(const Eigen::Vector3f& point_in_view) const {
    return std::any_of(occlusions_.begin(), occlusions_.end(),
                       [&](const Occlusion& o) { return !o.Hides(point_in_view); });
  }

  bool IsBesideOccluder(int u, int v, float z) const {
    for (int y = std::max(0, v - 1); y <= std::min(camera_.height - 1, v + 1); ++y) {
      for (int x = std::max(0, u - 1); x <= std::min(camera_.width - 1, u + 1); ++x) {
        if (depth_m_(x, y) > 0 && z > kHiddenBehind * depth_m_(x, y)) return true;
      }
    }
    return false;
  }

  const Image<float>& depth_m_;
  const PinholeCamera& camera_;
  const FrameColors& colors_;
  const std::vector<Occlusion>& occlusions_;
};

}  // namespace

ColorAverage::ColorAverage(const SurfelMap& map) : map_(map), sums_(map.id_end()) {}

void ColorAverage::Add(const FrameColors& colors, const DepthSensor& sensor,
                       const Rigid3d& world_from_camera, const std::vector<DepthPicture>& shown) {
  DepthSensor samples = sensor;
  samples.camera = CameraOfSamples(sensor.camera, added_++);
  const BlendedDepth view(map_, samples, world_from_camera);
  std::vector<Occlusion> occlusions;
  occlusions.reserve(shown.size());
  for (const DepthPicture& picture : shown) occlusions.emplace_back(picture, world_from_camera);
  const SampleColors sample_colors(view.depth_m(), samples.camera, colors, occlusions);
  const int bands = BandCount(samples.camera.height);
  Image<Eigen::Vector3f> found(samples.camera.width, samples.camera.height,
                               Eigen::Vector3f::Constant(kNoColor));
  ParallelFor(0, bands, 1, [&](int band, int) { sample_colors.Write(band, &found); });
  std::array<std::vector<BlendShare>, kBandsAtOnce> shares;
  for (int begin = 0; begin < bands; begin += kBandsAtOnce) {
    const int end = std::min(bands, begin + kBandsAtOnce);
    ParallelFor(begin, end, 1, [&](int band, int) { shares[band - begin] = view.SharesOf(band); });
    for (int band = begin; band < end; ++band) {
      for (const BlendShare& share : shares[band - begin]) {
        const Eigen::Vector3f& color = found[share.pixel];
        if (color.x() == kNoColor) continue;
        Sum& sum = sums_[share.surfel];
        sum.color += share.weight * color;
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
