#include "finishing/final_map.h"

#include <algorithm>
#include <cstdint>
#include <memory>
#include <utility>

#include "finishing/frame_poses.h"
#include "frame/rolling_shutter.h"
#include "mapping/fusion/color_average.h"
#include "mapping/map/smooth_map.h"
#include "surfit/frame/frame_pyramid.h"
#include "surfit/frame/frame_source.h"
#include "surfit/frame/rectify_frame.h"
#include "surfit/mapping/fusion.h"

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

// Registers frames to the map, and colours the map.
class Recoloring {
 public:
  Recoloring(const PosedSequence& known, const SequenceInfo& info, const SurfelMap& map,
             ColorAverage* average)
      : known_(known),
        sensor_(known.found.Of(info.sensor())),
        poses_(known, sensor_, map),
        average_(average) {}

  // Registers a frame with a new colour image. Returns std::nullopt for other frames.
  std::optional<FinalPose> Add(RgbdFrame frame, const Rigid3d& world_from_camera, bool colors) {
    if (frame.color.empty() || frame.color == last_color_) return std::nullopt;
    last_color_ = frame.color;
    const CameraMotion motion = MotionAt(known_.trajectory, frame.stamp_s);
    known_.found.Correct(&frame);
    const Image<float> measured_m = CorrectRollingShutter(frame, sensor_, motion).depth_m;
    const FinalPose pose = poses_.Register({frame, measured_m, motion, world_from_camera});
    if (!colors) return pose;
    frame.stamp_s = frame.color_stamp_s;  // colours use the pose at this time
    const PosedCamera camera(sensor_.camera, pose.world_from_color);
    average_->Add(FrameColors(frame, camera, {motion, sensor_.readout_s}), sensor_,
                  pose.world_from_color,
                  {measured_m, PosedCamera(sensor_.camera, pose.world_from_camera)});
    return pose;
  }

 private:
  const PosedSequence& known_;
  const DepthSensor sensor_;
  FramePoses poses_;
  Image<Rgb8> last_color_;
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

class FinalMapFusion {
 public:
  FinalMapFusion(const std::vector<MapSource>& sources, const MapPart* part,
                 const std::atomic<bool>& interrupted, const FinalMapProgress& progress)
      : sources_(sources), part_(part), interrupted_(interrupted), progress_(progress) {}

  // `poses`: final poses of the first source, by position in its trajectory; nullptr: none.
  std::optional<SurfelMap> Run(std::vector<std::optional<FinalPose>>* poses) {
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
      if (!Recolor(of_sequence, &average, poses)) return std::nullopt;
      poses = nullptr;
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
    const PosedSequence& known = of_sequence.known;
    const auto frames = ReopenSequence(known.sequence, of_sequence.frames);
    SequenceFusion sequence(of_sequence, frames->info());
    if (!*sensor) *sensor = sequence.sensor();
    return ReadPosedFrames(known, frames.get(), interrupted_, [&](std::size_t i, RgbdFrame frame) {
      if (known.left_out.count(frame.index) > 0) return;
      const Rigid3d& pose = known.trajectory[i].world_from_camera;
      if (part_) {
        frame.depth_m = Within(*part_, sequence.sensor().camera, pose, std::move(frame.depth_m));
      }
      sequence.Fuse(std::move(frame), pose, fusion, &map_);
      ++fused_;
      Advance(2);
    });
  }

  // Colours the map from every kColorStride-th frame. With `poses`, registers all frames.
  bool Recolor(const MapSource& of_sequence, ColorAverage* average,
               std::vector<std::optional<FinalPose>>* poses) {
    const PosedSequence& known = of_sequence.known;
    SequenceOptions some = known.sequence;
    some.stride *= kColorStride;
    const auto frames = ReopenSequence(poses ? known.sequence : some, of_sequence.frames);
    Recoloring recoloring(known, frames->info(), map_, average);
    return ReadPosedFrames(known, frames.get(), interrupted_, [&](std::size_t i, RgbdFrame frame) {
      const bool colors =
          known.left_out.count(frame.index) == 0 && (frame.index - some.first) % some.stride == 0;
      if (!colors && !poses) return;
      const std::optional<FinalPose> pose =
          recoloring.Add(std::move(frame), known.trajectory[i].world_from_camera, colors);
      if (poses) (*poses)[i] = pose;
      Advance(poses ? 1 : kColorStride);
    });
  }

  // `progress`: in thirds of a frame.
  void Advance(int progress) {
    done_ += progress;
    progress_(std::max(1, done_ / 3), map_.size());
  }

  const std::vector<MapSource>& sources_;
  const MapPart* part_;
  const std::atomic<bool>& interrupted_;
  const FinalMapProgress& progress_;
  SurfelMap map_;
  int fused_ = 0, done_ = 0;
};

}  // namespace

std::optional<FinalMap> IntegrateFinalMap(const PosedSequence& known, bool refine_poses,
                                          const std::atomic<bool>& interrupted,
                                          const FinalMapProgress& progress) {
  const std::vector<MapSource> all = {{known, {}, 0}};
  std::vector<std::optional<FinalPose>> poses(known.trajectory.size());
  std::optional<SurfelMap> map =
      FinalMapFusion(all, nullptr, interrupted, progress).Run(refine_poses ? &poses : nullptr);
  if (!map) return std::nullopt;
  return FinalMap{*std::move(map), WithFinalPoses(known.trajectory, poses)};
}

std::optional<SurfelMap> FusePart(const MapPart& part, const std::atomic<bool>& interrupted,
                                  const FinalMapProgress& progress) {
  return FinalMapFusion(part.sources, &part, interrupted, progress).Run(nullptr);
}

}  // namespace surfit
