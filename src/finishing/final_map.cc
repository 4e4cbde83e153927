#include "finishing/final_map.h"

#include <algorithm>
#include <cstdint>
#include <memory>
#include <utility>

#include "finishing/color_registration.h"
#include "frame/rolling_shutter.h"
#include "mapping/fusion/color_average.h"
#include "mapping/map/smooth_map.h"
#include "surfit/frame/frame_pyramid.h"
#include "surfit/frame/frame_source.h"
#include "surfit/frame/rectify_frame.h"
#include "surfit/mapping/fusion.h"
#include "surfit/mapping/model_renderer.h"

namespace surfit {
namespace {

// Ratio of the surfel spacing to the spacing in tracking, where denser surfels cost time and do not
// improve poses.
constexpr float kSpacingRatio = 0.7f;
// Only every kColorStride-th frame colours the map, because consecutive frames are almost equal.
constexpr int kColorStride = 3;

FusionOptions Finer(FusionOptions options) {
  options.max_spacing_m *= kSpacingRatio;
  return options;
}

// Removes surfels that were observed about once and only at depth edges. Fusion has already removed
// such surfels, except those of the last `max_inactive_frames` frames.
void RemoveEdgeNoise(const FusionOptions& options, SurfelMap* map) {
  for (const std::int32_t id : map->Ids()) {
    const Surfel surfel = (*map)[id];
    if (surfel.at_edge && surfel.confidence < options.min_inactive_confidence) map->Mark(id);
  }
  map->RemoveMarked();
}

class SequenceFusion {
 public:
  SequenceFusion(const MapSource& of_sequence, const SequenceInfo& info)
      : source_(of_sequence), sensor_(of_sequence.known.found.Of(info.sensor())) {}

  const DepthSensor& sensor() const { return sensor_; }

  void Fuse(RgbdFrame frame, const Rigid3d& world_from_camera, Fusion* fusion, SurfelMap* map) {
    const PosedSequence& known = source_.known;
    const CameraMotion motion = MotionAt(known.trajectory, frame.stamp_s);
    known.found.Correct(&frame);
    Image<Rgb8> color = std::move(frame.color);
    frame = CorrectRollingShutter(frame, sensor_, motion);
    frame.color = std::move(color);
    frame.index += source_.first_frame;
    const FramePyramid pyramid = PreprocessDepth(frame.depth_m, sensor_, known.slam.preprocess);
    fusion->Fuse(frame, pyramid.levels.front(), world_from_camera, {motion, sensor_.readout_s},
                 map);
  }

 private:
  const MapSource& source_;
  DepthSensor sensor_;
};

class Recoloring {
 public:
  Recoloring(const PosedSequence& known, const SequenceInfo& info, const SurfelMap& map,
             ColorAverage* average)
      : known_(known), sensor_(known.found.Of(info.sensor())), map_(map), average_(average) {
    coarse_ = sensor_;
    coarse_.camera = sensor_.camera.Binned(std::max(1, sensor_.camera.width / kColumns));
  }

  void Add(RgbdFrame frame, const Rigid3d& world_from_camera) {
    if (frame.color.empty()) return;
    const CameraMotion motion = MotionAt(known_.trajectory, frame.stamp_s);
    known_.found.Correct(&frame);
    const Rigid3d expected =
        ExtrapolatePose(world_from_camera, motion, frame.color_stamp_s - frame.stamp_s);
    const BlendedView drawn = RenderDiscs(map_, coarse_, expected, &renderer_);
    const Rigid3d world_from_color = RegisterColors(frame.color, drawn, coarse_, motion, expected);
    const Image<float> measured_m = CorrectRollingShutter(frame, sensor_, motion).depth_m;
    frame.stamp_s = frame.color_stamp_s;  // colours use the pose at this time
    const PosedCamera camera(sensor_.camera, world_from_color);
    average_->Add(FrameColors(frame, camera, {motion, sensor_.readout_s}), sensor_,
                  world_from_color, {measured_m, PosedCamera(sensor_.camera, world_from_camera)});
  }

 private:
  static constexpr int kColumns = 320;

  const PosedSequence& known_;
  const DepthSensor sensor_;
  const SurfelMap& map_;
  DepthSensor coarse_;
  ModelRenderer renderer_{RenderOptions()};
  ColorAverage* average_;
};

Image<float> Within(const MapPart& part, const PinholeCamera& camera,
                    const Rigid3d& world_from_camera, Image<float> depth_m) {
  const Rigid3f pose = world_from_camera.cast<float>();
  const Eigen::Vector3f margin = Eigen::Vector3f::Constant(part.margin_m);
  const Eigen::AlignedBox3f box(part.box.min() - margin, part.box.max() + margin);
  const auto fx = static_cast<float>(camera.fx), fy = static_cast<float>(camera.fy);
  const auto cx = static_cast<float>(camera.cx), cy = static_cast<float>(camera.cy);
  for (int v = 0; v < depth_m.height(); ++v) {
    for (int u = 0; u < depth_m.width(); ++u) {
      float& z = depth_m(u, v);
      const Eigen::Vector3f ray((static_cast<float>(u) - cx) / fx,
                                (static_cast<float>(v) - cy) / fy, 1);
      if (z > 0 && !box.contains(pose * Eigen::Vector3f(z * ray))) z = 0;
    }
  }
  return depth_m;
}

// Removes surfels outside of the half-open box, so that adjacent boxes share no surfel.
void Crop(const Eigen::AlignedBox3f& box, SurfelMap* map) {
  for (const std::int32_t id : map->Ids()) {
    const Eigen::Vector3f at = (*map)[id].position_in_world;
    const bool is_in =
        (at.array() >= box.min().array()).all() && (at.array() < box.max().array()).all();
    if (!is_in) map->Mark(id);
  }
  map->RemoveMarked();
}

class FinalMap {
 public:
  FinalMap(const std::vector<MapSource>& sources, const MapPart* part,
           const std::atomic<bool>& interrupted, const FinalMapProgress& progress)
      : sources_(sources), part_(part), interrupted_(interrupted), progress_(progress) {}

  std::optional<SurfelMap> Run() {
    std::optional<DepthSensor> sensor;
    Fusion fusion(Finer(sources_.front().known.slam.fusion));
    for (const MapSource& of_sequence : sources_) {
      if (!FuseSource(of_sequence, &fusion, &sensor)) return std::nullopt;
    }
    const FusionOptions& options = sources_.front().known.slam.fusion;
    if (fused_ > options.max_inactive_frames) RemoveEdgeNoise(options, &map_);
    SmoothMap(*sensor, &map_);
    ColorAverage average(map_);
    for (const MapSource& of_sequence : sources_) {
      if (!Recolor(of_sequence, &average)) return std::nullopt;
    }
    average.WriteTo(&map_);
    if (part_) Crop(part_->box, &map_);
    progress_(fused_, map_.size());
    return std::move(map_);
  }

 private:
  // Opens the sequence only for this call, because the frame list of a long recording is large.
  bool FuseSource(const MapSource& of_sequence, Fusion* fusion,
                  std::optional<DepthSensor>* sensor) {
    const auto frames = ReopenSequence(of_sequence.known.sequence, of_sequence.frames);
    SequenceFusion sequence(of_sequence, frames->info());
    if (!*sensor) *sensor = sequence.sensor();
    return ForEach(of_sequence, frames.get(), 2, [&](RgbdFrame frame, const Rigid3d& pose) {
      if (part_) {
        frame.depth_m = Within(*part_, sequence.sensor().camera, pose, std::move(frame.depth_m));
      }
      sequence.Fuse(std::move(frame), pose, fusion, &map_);
      ++fused_;
    });
  }

  bool Recolor(const MapSource& of_sequence, ColorAverage* average) {
    SequenceOptions some = of_sequence.known.sequence;
    some.stride *= kColorStride;
    const auto frames = ReopenSequence(some, of_sequence.frames);
    Recoloring recoloring(of_sequence.known, frames->info(), map_, average);
    return ForEach(
        of_sequence, frames.get(), kColorStride,
        [&](RgbdFrame frame, const Rigid3d& pose) { recoloring.Add(std::move(frame), pose); });
  }

  // `progress`: progress of each frame, in thirds of a frame.
  template <typename Take>
  bool ForEach(const MapSource& of_sequence, FrameSource* frames, int progress, const Take& take) {
    const PosedSequence& known = of_sequence.known;
    return ReadPosedFrames(known, frames, interrupted_, [&](std::size_t pose, RgbdFrame frame) {
      if (known.left_out.count(frame.index) > 0) return;
      take(std::move(frame), known.trajectory[pose].world_from_camera);
      done_ += progress;
      progress_(std::max(1, done_ / 3), map_.size());
    });
  }

  const std::vector<MapSource>& sources_;
  const MapPart* part_;
  const std::atomic<bool>& interrupted_;
  const FinalMapProgress& progress_;
  SurfelMap map_;
  int fused_ = 0, done_ = 0;
};

}  // namespace

std::optional<SurfelMap> IntegrateFinalMap(const PosedSequence& known,
                                           const std::atomic<bool>& interrupted,
                                           const FinalMapProgress& progress) {
  const std::vector<MapSource> all = {{known, {}, 0}};
  return FinalMap(all, nullptr, interrupted, progress).Run();
}

std::optional<SurfelMap> FusePart(const MapPart& part, const std::atomic<bool>& interrupted,
                                  const FinalMapProgress& progress) {
  return FinalMap(part.sources, &part, interrupted, progress).Run();
}

}  // namespace surfit
