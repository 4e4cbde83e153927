#include "finishing/final_map.h"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "finishing/frame_poses.h"
#include "finishing/stereo/stereo_keyframe.h"
#include "finishing/stereo/unmeasured_surfaces.h"
#include "frame/rolling_shutter.h"
#include "mapping/fusion/color_average.h"
#include "mapping/map/smooth_map.h"
#include "surfit/frame/frame_pyramid.h"
#include "surfit/frame/frame_source.h"
#include "surfit/frame/rectify_frame.h"
#include "surfit/mapping/fusion.h"
#include "surfit/optimization/keyframes.h"

namespace surfit {
namespace {

// Ratio of the surfel spacing to the spacing in tracking, where denser surfels cost time and do not
// improve poses.
constexpr float kSpacingRatio = 0.7f;
// Only every kColorStride-th frame colours the map, because consecutive frames are almost equal.
constexpr int kColorStride = 3;
// Keyframes for stereo. Both thresholds grow until there are at most kMaxStereoKeyframes.
constexpr double kStereoTranslation_m = 0.03, kStereoRotation_rad = 0.08;
constexpr std::size_t kMaxStereoKeyframes = 200;

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

// Frames of a sequence that are registered to the map.
struct RegisteredFrames {
  std::vector<std::optional<FinalPose>> poses;  // by position in the trajectory
  std::vector<StereoKeyframe> keyframes;        // ascending indices
  std::vector<Image<float>> stereo_m;           // UnmeasuredSurfaces::depth_m of the keyframes
};

// Registers the frames with a new colour image. Frames that colour the map and have a new view can
// become keyframes.
class FrameRegistration {
 public:
  FrameRegistration(const PosedSequence& known, const SequenceInfo& info, const SurfelMap& map,
                    bool with_keyframes)
      : known_(known), sensor_(known.found.Of(info.sensor())), poses_(known, sensor_, map) {
    found_.poses.resize(known.trajectory.size());
    if (with_keyframes) {
      chosen_ = ChooseKeyframes(known.trajectory, kStereoTranslation_m, kStereoRotation_rad,
                                kMaxStereoKeyframes);
    }
  }

  // `i`: position in the trajectory. `colors`: the frame colours the map.
  void Add(std::size_t i, RgbdFrame frame, bool colors) {
    if (frame.color.empty() || frame.color == last_color_) return;
    last_color_ = frame.color;
    const CameraMotion motion = MotionAt(known_.trajectory, frame.stamp_s);
    known_.found.Correct(&frame);
    const Image<float> measured_m = CorrectRollingShutter(frame, sensor_, motion).depth_m;
    const FinalPose pose =
        poses_.Register({frame, measured_m, motion, known_.trajectory[i].world_from_camera});
    found_.poses[i] = pose;
    if (!colors || next_ == chosen_.size() || i < chosen_[next_]) return;
    while (next_ < chosen_.size() && chosen_[next_] <= i) ++next_;
    if (!IsNewView(pose.world_from_color)) return;
    found_.keyframes.push_back(MakeStereoKeyframe(frame, measured_m, sensor_, motion,
                                                  pose.world_from_camera, pose.world_from_color));
  }

  RegisteredFrames Found() && { return std::move(found_); }

 private:
  // A camera that returns to a place needs no more keyframes there.
  bool IsNewView(const Rigid3d& world_from_color) const {
    return std::all_of(found_.keyframes.begin(), found_.keyframes.end(), [&](const auto& other) {
      return HasMoved(other.world_from_camera, world_from_color, kStereoTranslation_m,
                      kStereoRotation_rad);
    });
  }

  const PosedSequence& known_;
  const DepthSensor sensor_;
  FramePoses poses_;
  Image<Rgb8> last_color_;
  std::vector<std::size_t> chosen_;  // positions in the trajectory, ascending
  std::size_t next_ = 0;             // first chosen position without a keyframe
  RegisteredFrames found_;
};

// Adds the colours of registered frames to an average.
class Recoloring {
 public:
  Recoloring(const PosedSequence& known, const SequenceInfo& info,
             const RegisteredFrames& registered, ColorAverage* average)
      : known_(known),
        sensor_(known.found.Of(info.sensor())),
        registered_(registered),
        average_(average) {}

  // Frames in ascending order. `i`: position in the trajectory.
  void Add(std::size_t i, RgbdFrame frame) {
    const std::optional<FinalPose>& pose = registered_.poses[i];
    if (!pose) return;
    const CameraMotion motion = MotionAt(known_.trajectory, frame.stamp_s);
    known_.found.Correct(&frame);
    const Image<float> measured_m = CorrectRollingShutter(frame, sensor_, motion).depth_m;
    const PosedCamera measured_from(sensor_.camera, pose->world_from_camera);
    std::vector<DepthPicture> shown = {{measured_m, measured_from}};
    std::optional<PosedCamera> stereo_from;
    const std::vector<StereoKeyframe>& keyframes = registered_.keyframes;
    while (keyframe_ < keyframes.size() && keyframes[keyframe_].index < frame.index) ++keyframe_;
    if (keyframe_ < registered_.stereo_m.size() && keyframes[keyframe_].index == frame.index) {
      stereo_from.emplace(keyframes[keyframe_].camera, keyframes[keyframe_].world_from_camera);
      shown.push_back({registered_.stereo_m[keyframe_], *stereo_from});
    }
    frame.stamp_s = frame.color_stamp_s;  // colours use the pose at this time
    const PosedCamera camera(sensor_.camera, pose->world_from_color);
    average_->Add(FrameColors(frame, camera, {motion, sensor_.readout_s}), sensor_,
                  pose->world_from_color, shown);
  }

 private:
  const PosedSequence& known_;
  const DepthSensor sensor_;
  const RegisteredFrames& registered_;
  ColorAverage* average_;
  std::size_t keyframe_ = 0;  // first keyframe that is not before the frame
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
                 const FinalMapSteps& steps, const std::atomic<bool>& interrupted,
                 const FinalMapProgress& progress)
      : sources_(sources),
        part_(part),
        steps_(steps),
        interrupted_(interrupted),
        progress_(progress) {}

  std::optional<SurfelMap> Run() {
    Fusion fusion(Finer(options()));
    for (const MapSource& of_sequence : sources_) {
      if (!FuseSource(of_sequence, &fusion)) return std::nullopt;
    }
    if (fused_ > options().max_inactive_frames) RemoveEdgeNoise(options(), &map_);
    SmoothMap(*sensor_, &map_);
    for (const MapSource& of_sequence : sources_) {
      if (!Register(of_sequence)) return std::nullopt;
    }
    if (steps_.stereo && !AddUnmeasuredSurfaces(&registered_.front())) return std::nullopt;
    ColorAverage average(map_);
    for (std::size_t i = 0; i < sources_.size(); ++i) {
      if (!Recolor(sources_[i], registered_[i], &average)) return std::nullopt;
    }
    average.WriteTo(&map_);
    if (part_) Crop(part_->box, &map_);
    progress_(fused_, map_.size());
    return std::move(map_);
  }

  // Final poses of the first source, by position in its trajectory. std::nullopt: not registered.
  const std::vector<std::optional<FinalPose>>& poses() const { return registered_.front().poses; }

 private:
  const FusionOptions& options() const { return sources_.front().known.slam.fusion; }

  // Opens the sequence only for this call, because the frame list of a long recording is large.
  bool FuseSource(const MapSource& of_sequence, Fusion* fusion) {
    const PosedSequence& known = of_sequence.known;
    const auto frames = ReopenSequence(known.sequence, of_sequence.frames);
    SequenceFusion sequence(of_sequence, frames->info());
    if (!sensor_) sensor_ = sequence.sensor();
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

  // Registers all frames, or those that colour the map.
  bool Register(const MapSource& of_sequence) {
    const PosedSequence& known = of_sequence.known;
    const SequenceOptions some = ColoringFrames(known);
    const auto frames =
        ReopenSequence(steps_.refine_poses ? known.sequence : some, of_sequence.frames);
    FrameRegistration registration(known, frames->info(), map_, steps_.stereo);
    const bool is_complete =
        ReadPosedFrames(known, frames.get(), interrupted_, [&](std::size_t i, RgbdFrame frame) {
          const bool colors = known.left_out.count(frame.index) == 0 &&
                              (frame.index - some.first) % some.stride == 0;
          if (!colors && !steps_.refine_poses) return;
          registration.Add(i, std::move(frame), colors);
          Advance(steps_.refine_poses ? 1 : kColorStride);
        });
    registered_.push_back(std::move(registration).Found());
    return is_complete;
  }

  // Returns false if interrupted.
  bool AddUnmeasuredSurfaces(RegisteredFrames* registered) {
    std::optional<UnmeasuredSurfaces> found = FindUnmeasuredSurfaces(
        registered->keyframes, map_, *sensor_, Finer(options()), interrupted_);
    if (!found) return false;
    map_.Append(found->surfels);
    registered->stereo_m = std::move(found->depth_m);
    return true;
  }

  bool Recolor(const MapSource& of_sequence, const RegisteredFrames& registered,
               ColorAverage* average) {
    const PosedSequence& known = of_sequence.known;
    const auto frames = ReopenSequence(ColoringFrames(known), of_sequence.frames);
    Recoloring recoloring(known, frames->info(), registered, average);
    return ReadPosedFrames(known, frames.get(), interrupted_, [&](std::size_t i, RgbdFrame frame) {
      if (known.left_out.count(frame.index) > 0) return;
      recoloring.Add(i, std::move(frame));
      Advance(kColorStride);
    });
  }

  static SequenceOptions ColoringFrames(const PosedSequence& known) {
    SequenceOptions some = known.sequence;
    some.stride *= kColorStride;
    return some;
  }

  // `progress`: in quarters of a frame.
  void Advance(int progress) {
    done_ += progress;
    progress_(std::clamp(done_ / 4, 1, std::max(1, fused_)), map_.size());
  }

  const std::vector<MapSource>& sources_;
  const MapPart* part_;
  const FinalMapSteps steps_;
  const std::atomic<bool>& interrupted_;
  const FinalMapProgress& progress_;
  SurfelMap map_;
  std::optional<DepthSensor> sensor_;  // of the first source
  std::vector<RegisteredFrames> registered_;
  int fused_ = 0, done_ = 0;
};

}  // namespace

std::optional<FinalMap> IntegrateFinalMap(const PosedSequence& known, const FinalMapSteps& steps,
                                          const std::atomic<bool>& interrupted,
                                          const FinalMapProgress& progress) {
  const std::vector<MapSource> all = {{known, {}, 0}};
  FinalMapFusion fusion(all, nullptr, steps, interrupted, progress);
  std::optional<SurfelMap> map = fusion.Run();
  if (!map) return std::nullopt;
  return FinalMap{*std::move(map), steps.refine_poses
                                       ? WithFinalPoses(known.trajectory, fusion.poses())
                                       : known.trajectory};
}

SurfelMap WithoutStereo(SurfelMap map) {
  for (const std::int32_t id : map.Ids()) {
    if (map[id].from_stereo) map.Mark(id);
  }
  map.RemoveMarked();
  return map;
}

std::optional<SurfelMap> FusePart(const MapPart& part, const std::atomic<bool>& interrupted,
                                  const FinalMapProgress& progress) {
  return FinalMapFusion(part.sources, &part, {}, interrupted, progress).Run();
}

}  // namespace surfit
