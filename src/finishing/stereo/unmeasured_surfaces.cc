#include "finishing/stereo/unmeasured_surfaces.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "finishing/stereo/semi_global.h"
#include "finishing/stereo/stereo_depth.h"
#include "surfit/core/parallel.h"
#include "surfit/frame/preprocess.h"
#include "surfit/mapping/model_renderer.h"

namespace surfit {
namespace {

constexpr std::size_t kMatchedViews = 6, kComparedViews = 16;
constexpr int kMinAgreeing = 3;    // other keyframes
constexpr float kAgreement = 3;    // labels
constexpr float kNearMap = 0.08f;  // relative difference of depth
constexpr float kMinFused = 1;     // confidence
constexpr int kMaxFreeViews = 2;   // compared views that measure a surface behind a depth
constexpr float kMaxFreeRatio = 0.25f;
// Ratio of the baseline to the median depth.
constexpr double kNearParallax = 0.1, kDistantParallax = 0.3, kMinParallax = 0.02,
                 kMaxParallax = 0.5;
constexpr double kMaxTurn_rad = 0.6, kTurnScale_rad = 0.2;
// Labels reach from a quarter of the least inverse depth to 1.6 times the greatest.
constexpr double kNearest = 0.005, kFarthest = 0.995;  // percentiles of the measured depth
constexpr float kBeyondNearest = 1.6f, kBeyondFarthest = 0.25f;
constexpr float kMinViewDepth_m = 0.05f;
constexpr std::size_t kDepthStep = 7;  // of the sampled pixels
// A measured depth is clearly behind a point beyond this distance.
constexpr float kFreeSpace_m = 0.05f, kFreeSpaceRatio = 0.03f;

float Percentile(std::vector<float>* values, double ratio) {
  const auto at = static_cast<std::ptrdiff_t>(ratio * static_cast<double>(values->size() - 1));
  std::nth_element(values->begin(), values->begin() + at, values->end());
  return (*values)[at];
}

std::vector<float> MeasuredDepths(const StereoKeyframe& keyframe) {
  std::vector<float> depths;
  for (std::size_t i = 0; i < keyframe.measured_m.size(); i += kDepthStep) {
    if (keyframe.measured_m[i] > 0) depths.push_back(keyframe.measured_m[i]);
  }
  return depths;
}

struct SeenPoint {
  Eigen::Vector3f in_camera;  // m
  int u, v;                   // pixel
};

// Camera with its pose, in single precision.
class View {
 public:
  View(const PinholeCamera& camera, const Rigid3d& world_from_camera)
      : camera_(camera),
        rotation_(world_from_camera.rotation.toRotationMatrix().cast<float>()),
        centre_(world_from_camera.translation.cast<float>()) {}

  Eigen::Vector3f InWorld(const Eigen::Vector3f& in_camera) const {
    return rotation_ * in_camera + centre_;
  }
  Eigen::Vector3f InCamera(const Eigen::Vector3f& in_world) const {
    return rotation_.transpose() * (in_world - centre_);
  }
  // std::nullopt: outside of the image.
  std::optional<SeenPoint> Find(const Eigen::Vector3f& in_world) const {
    const Eigen::Vector3f p = InCamera(in_world);
    if (!(p.z() > kMinViewDepth_m)) return std::nullopt;
    const Eigen::Vector2d pixel = camera_.Project(p.cast<double>()).array() + 0.5;
    if (!(pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() < camera_.width &&
          pixel.y() < camera_.height)) {
      return std::nullopt;
    }
    return SeenPoint{p, static_cast<int>(pixel.x()), static_cast<int>(pixel.y())};
  }

 private:
  PinholeCamera camera_;
  Eigen::Matrix3f rotation_;  // world from camera
  Eigen::Vector3f centre_;    // in the world, m
};

// Keyframe with depth by stereo.
class StereoView {
 public:
  StereoView(const StereoKeyframe& keyframe, Image<float> stereo_m)
      : view_(keyframe.camera, keyframe.world_from_camera),
        measured_m_(keyframe.measured_m),
        stereo_m_(std::move(stereo_m)) {}

  const View& view() const { return view_; }
  float StereoDepth_m(int u, int v) const { return stereo_m_(u, v); }
  bool IsMeasured(int u, int v) const { return measured_m_(u, v) > 0; }
  // Measured depth, or depth by stereo.
  float Depth_m(int u, int v) const {
    return IsMeasured(u, v) ? measured_m_(u, v) : stereo_m_(u, v);
  }

  // True if all 3 x 3 pixels around the point have measured depth that is clearly behind it.
  bool IsInFreeSpace(const SeenPoint& point) const {
    if (point.u < 1 || point.v < 1 || point.u >= measured_m_.width() - 1 ||
        point.v >= measured_m_.height() - 1) {
      return false;
    }
    const float limit_m = point.in_camera.z() * (1 + kFreeSpaceRatio) + kFreeSpace_m;
    for (int v = point.v - 1; v <= point.v + 1; ++v) {
      for (int u = point.u - 1; u <= point.u + 1; ++u) {
        if (!(measured_m_(u, v) > limit_m)) return false;
      }
    }
    return true;
  }

 private:
  View view_;
  const Image<float>& measured_m_;
  Image<float> stereo_m_;
};

// Depth of the unmeasured pixels of a keyframe; 0: unknown.
struct CheckedDepth {
  Image<float> added_m;  // not in the map
  Image<float> shown_m;  // these, and the depth of the map where stereo agrees with it
};

class SurfaceFinder {
 public:
  SurfaceFinder(const std::vector<StereoKeyframe>& keyframes, const SurfelMap& map,
                const DepthSensor& sensor, const FusionOptions& fusion,
                const std::atomic<bool>& interrupted)
      : keyframes_(keyframes),
        map_(map),
        sensor_(sensor),
        fusion_options_(fusion),
        interrupted_(interrupted) {}

  std::optional<UnmeasuredSurfaces> Run() {
    UnmeasuredSurfaces found;
    if (!FindLabels()) return found;
    const int count = static_cast<int>(keyframes_.size());
    for (int i = 0; i < count; ++i) near_.push_back(SimilarViews(i, kNearParallax, kComparedViews));
    if (!Match()) return std::nullopt;
    std::vector<CheckedDepth> checked(count);
    ParallelFor(0, count, 1, [&](int i, int) {
      if (!interrupted_) checked[i] = Check(i);
    });
    if (interrupted_) return std::nullopt;
    std::optional<SurfelMap> fused = Fuse(checked);
    if (!fused) return std::nullopt;
    found.surfels = Reliable(*fused);
    for (CheckedDepth& depth : checked) found.depth_m.push_back(std::move(depth.shown_m));
    return found;
  }

 private:
  // Returns false without measured depth.
  bool FindLabels() {
    std::vector<float> all;
    for (const StereoKeyframe& keyframe : keyframes_) {
      std::vector<float> depths = MeasuredDepths(keyframe);
      all.insert(all.end(), depths.begin(), depths.end());
      median_m_.push_back(depths.empty() ? 0 : Percentile(&depths, 0.5));
    }
    if (all.empty()) return false;
    labels_.least = kBeyondFarthest / Percentile(&all, kFarthest);
    const float most = kBeyondNearest / Percentile(&all, kNearest);
    labels_.step = (most - labels_.least) / (CostVolume::kLabels - 1);
    return true;
  }

  // Other keyframes with a similar view and about this parallax, the best first.
  std::vector<std::size_t> SimilarViews(std::size_t i, double best_parallax,
                                        std::size_t max_count) const {
    if (!(median_m_[i] > 0)) return {};
    std::vector<std::pair<double, std::size_t>> found;
    for (std::size_t j = 0; j < keyframes_.size(); ++j) {
      const Rigid3d pose =
          keyframes_[i].world_from_camera.Inverse() * keyframes_[j].world_from_camera;
      const double turn_rad = Eigen::AngleAxisd(pose.rotation).angle();
      const double parallax = pose.translation.norm() / median_m_[i];
      if (turn_rad > kMaxTurn_rad || parallax < kMinParallax || parallax > kMaxParallax) continue;
      found.emplace_back(std::abs(std::log(parallax / best_parallax)) + turn_rad / kTurnScale_rad,
                         j);
    }
    std::sort(found.begin(), found.end());
    std::vector<std::size_t> views;
    for (std::size_t k = 0; k < std::min(found.size(), max_count); ++k) {
      views.push_back(found[k].second);
    }
    return views;
  }

  // Returns false if interrupted.
  bool Match() {
    const int count = static_cast<int>(keyframes_.size());
    std::vector<std::optional<MatchedImage>> images(count);
    ParallelFor(0, count, 1, [&](int i, int) { images[i].emplace(keyframes_[i]); });
    std::vector<Image<float>> depths(count);
    ParallelFor(0, count, 1, [&](int i, int) {
      if (interrupted_) return;
      StereoNeighbours neighbours;
      for (const std::size_t j : near_[i]) {
        if (neighbours.matched.size() < kMatchedViews) neighbours.matched.push_back(&*images[j]);
      }
      for (const std::size_t j : SimilarViews(i, kDistantParallax, kMatchedViews)) {
        neighbours.distant.push_back(&*images[j]);
      }
      depths[i] = MatchDepth(keyframes_[i], labels_, *images[i], neighbours);
    });
    if (interrupted_) return false;
    for (int i = 0; i < count; ++i) views_.emplace_back(keyframes_[i], std::move(depths[i]));
    return true;
  }

  CheckedDepth Check(std::size_t i) const {
    const StereoKeyframe& keyframe = keyframes_[i];
    const int width = keyframe.camera.width, height = keyframe.camera.height;
    ModelRenderer renderer{RenderOptions()};
    const ModelView model = renderer.Render(map_, SensorOf(keyframe), keyframe.world_from_camera);
    CheckedDepth checked = {Image<float>(width, height, 0.f), Image<float>(width, height, 0.f)};
    for (int v = 0; v < height; ++v) {
      for (int u = 0; u < width; ++u) {
        const float z = views_[i].StereoDepth_m(u, v), in_map_m = model.surface.vertex.z(u, v);
        if (!(z > 0)) continue;
        if (in_map_m > 0 && std::abs(z / in_map_m - 1) < kNearMap) {
          checked.shown_m(u, v) = in_map_m;
        } else {
          const Eigen::Vector3f ray = keyframe.camera.Ray(u, v).cast<float>();
          checked.added_m(u, v) = checked.shown_m(u, v) = AgreedDepth_m(i, ray, z);
        }
      }
    }
    return checked;
  }

  // Mean of the inverse depths that agree, as depth. 0: too few agree, or measured depth is behind.
  float AgreedDepth_m(std::size_t i, const Eigen::Vector3f& ray, float z) const {
    const View& view = views_[i].view();
    const Eigen::Vector3f in_world = view.InWorld(z * ray);
    int agreeing = 0, free = 0;
    float sum = 1 / z;
    for (const std::size_t j : near_[i]) {
      const StereoView& other = views_[j];
      const std::optional<SeenPoint> seen = other.view().Find(in_world);
      if (!seen) continue;
      if (other.IsInFreeSpace(*seen) && ++free > kMaxFreeViews) return 0;
      const float other_m = other.Depth_m(seen->u, seen->v), expected_m = seen->in_camera.z();
      if (!(other_m > 0) ||
          !(std::abs(1 / other_m - 1 / expected_m) <= kAgreement * labels_.step)) {
        continue;
      }
      const Eigen::Vector3f point = other.view().InWorld(seen->in_camera * (other_m / expected_m));
      const float in_view_m = view.InCamera(point).z();
      if (!(in_view_m > 0)) continue;
      sum += 1 / in_view_m;
      ++agreeing;
    }
    return agreeing < kMinAgreeing ? 0 : static_cast<float>(agreeing + 1) / sum;
  }

  std::optional<SurfelMap> Fuse(const std::vector<CheckedDepth>& checked) const {
    Fusion fusion(fusion_options_);
    SurfelMap fused;
    for (std::size_t i = 0; i < views_.size(); ++i) {
      if (interrupted_) return std::nullopt;
      const StereoKeyframe& keyframe = keyframes_[i];
      RgbdFrame frame;
      frame.index = keyframe.index;
      frame.depth_m = checked[i].added_m;
      frame.color = keyframe.color;
      // Normals need neighbours, so all depth is used for them.
      Image<float> dense_m = frame.depth_m;
      for (int v = 0; v < dense_m.height(); ++v) {
        for (int u = 0; u < dense_m.width(); ++u) {
          if (!(dense_m(u, v) > 0)) dense_m(u, v) = views_[i].Depth_m(u, v);
        }
      }
      DepthSensor stereo = SensorOf(keyframe);
      stereo.noise.inverse_depth_sigma =
          std::max<double>(stereo.noise.inverse_depth_sigma, labels_.step);
      const FramePyramid pyramid = PreprocessDepth(dense_m, stereo, PreprocessOptions());
      fusion.Fuse(frame, pyramid.levels.front(), keyframe.world_from_camera, &fused);
    }
    return fused;
  }

  DepthSensor SensorOf(const StereoKeyframe& keyframe) const {
    DepthSensor sensor = sensor_;
    sensor.camera = keyframe.camera;
    sensor.readout_s = 0;
    return sensor;
  }

  std::vector<Surfel> Reliable(const SurfelMap& fused) const {
    std::vector<Surfel> surfels;
    for (const std::int32_t id : fused.Ids()) {
      Surfel surfel = fused[id];
      if (surfel.confidence < kMinFused || surfel.at_edge || IsContradicted(surfel)) continue;
      surfel.from_stereo = true;
      surfels.push_back(surfel);
    }
    return surfels;
  }

  // True if many keyframes measure a surface behind the surfel, compared to the keyframes without
  // depth at its pixel.
  bool IsContradicted(const Surfel& surfel) const {
    int free = 0, unmeasured = 0;
    for (const StereoView& of_keyframe : views_) {
      const std::optional<SeenPoint> seen = of_keyframe.view().Find(surfel.position_in_world);
      if (!seen) continue;
      if (of_keyframe.IsInFreeSpace(*seen)) ++free;
      if (!of_keyframe.IsMeasured(seen->u, seen->v)) ++unmeasured;
    }
    return static_cast<float>(free) > kMaxFreeRatio * static_cast<float>(unmeasured);
  }

  const std::vector<StereoKeyframe>& keyframes_;
  const SurfelMap& map_;
  const DepthSensor& sensor_;
  const FusionOptions fusion_options_;
  const std::atomic<bool>& interrupted_;
  std::vector<float> median_m_;  // of the measured depth, by keyframe; 0: none
  LabelRange labels_;
  std::vector<std::vector<std::size_t>> near_;  // SimilarViews() by keyframe
  std::vector<StereoView> views_;               // by keyframe
};

}  // namespace

std::optional<UnmeasuredSurfaces> FindUnmeasuredSurfaces(
    const std::vector<StereoKeyframe>& keyframes, const SurfelMap& map, const DepthSensor& sensor,
    const FusionOptions& fusion, const std::atomic<bool>& interrupted) {
  return SurfaceFinder(keyframes, map, sensor, fusion, interrupted).Run();
}

}  // namespace surfit
