#include "run/final_map.h"

#include <algorithm>
#include <cstdint>
#include <memory>
#include <utility>

#include "mapping/color_average.h"
#include "mapping/smooth_map.h"
#include "run/color_registration.h"
#include "surfit/frame/frame_pyramid.h"
#include "surfit/frame/prepare_frame.h"
#include "surfit/frame/rolling_shutter.h"
#include "surfit/io/frame_source.h"
#include "surfit/mapping/fusion.h"
#include "surfit/mapping/model_renderer.h"

namespace surfit {
namespace {

// Tracking by so many surfels would take longer, and be no better.
constexpr float kSpacingShare = 0.7f;
// Of so many frames one tells the final colours: its neighbours show nearly the same.
constexpr int kColorStride = 2;

FusionOptions Finer(FusionOptions options) {
  options.max_spacing_m *= kSpacingShare;
  return options;
}

// What was seen about once goes from a map once it has not been seen for a while. Nothing comes
// after the last frames, which most of what flies is from: that lies at depth edges.
void DropFlying(const FusionOptions& options, SurfelMap* map) {
  for (const std::int32_t id : map->Ids()) {
    const Surfel surfel = (*map)[id];
    if (surfel.at_edge && surfel.confidence < options.lasting_confidence) map->Mark(id);
  }
  map->RemoveMarked();
}

class FinalMap {
 public:
  FinalMap(const KnownSequence& known, const SequenceInfo& info)
      : known_(known), sensor_(known.found.Of(info.sensor())), fusion_(Finer(known.slam.fusion)) {}

  void Fuse(RgbdFrame frame, const Rigid3d& world_from_camera) {
    const CameraMotion motion = MotionAt(known_.trajectory, frame.stamp_s);
    known_.found.Correct(&frame);
    Image<Rgb8> color = std::move(frame.color);
    frame = AtMiddleOfReadout(frame, sensor_, motion);
    frame.color = std::move(color);
    const FramePyramid pyramid = PreprocessDepth(frame.depth_m, sensor_, known_.slam.preprocess);
    fusion_.Fuse(frame, pyramid.levels.front(), world_from_camera, {motion, sensor_.readout_s},
                 &map_);
  }

  SurfelMap& map() { return map_; }

 private:
  const KnownSequence& known_;
  DepthSensor sensor_;
  Fusion fusion_;
  SurfelMap map_;
};

// The colours of a map from where each frame's were taken.
class Recoloring {
 public:
  Recoloring(const KnownSequence& known, const SequenceInfo& info, const SurfelMap& map)
      : known_(known), sensor_(known.found.Of(info.sensor())), map_(map), average_(map) {
    coarse_ = sensor_;
    coarse_.camera = sensor_.camera.Binned(std::max(1, sensor_.camera.width / kColumns));
  }

  void Add(RgbdFrame frame, const Rigid3d& world_from_camera) {
    if (frame.color.empty()) return;
    const CameraMotion motion = MotionAt(known_.trajectory, frame.stamp_s);
    known_.found.Correct(&frame);
    const Rigid3d expected =
        PoseAfter(world_from_camera, motion, frame.color_stamp_s - frame.stamp_s);
    const BlendedView drawn = DrawDiscs(map_, coarse_, expected, &renderer_);
    const PosedCamera camera(sensor_.camera,
                             RegisterColors(frame.color, drawn, coarse_, motion, expected));
    const Image<float> measured_m = Coarse(AtMiddleOfReadout(frame, sensor_, motion).depth_m);
    frame.stamp_s = frame.color_stamp_s;  // the camera is where it was then
    average_.Add(FrameColors(frame, camera, {motion, sensor_.readout_s}), camera,
                 {drawn.depth_m, PosedCamera(coarse_.camera, expected)},
                 {measured_m, PosedCamera(coarse_.camera, world_from_camera)});
  }

  void WriteTo(SurfelMap* map) const { average_.WriteTo(map); }

 private:
  static constexpr int kColumns = 320;  // of the pictures that frames are registered to, about

  // The nearest of each block of pixels; 0 where one is missing.
  Image<float> Coarse(const Image<float>& depth_m) const {
    Image<float> coarse_m(coarse_.camera.width, coarse_.camera.height);
    const int step = depth_m.width() / coarse_m.width();
    for (int v = 0; v < coarse_m.height(); ++v) {
      for (int u = 0; u < coarse_m.width(); ++u) {
        float nearest_m = depth_m(u * step, v * step);
        for (int i = 1; i < step * step; ++i) {
          nearest_m = std::min(nearest_m, depth_m(u * step + i % step, v * step + i / step));
        }
        coarse_m(u, v) = nearest_m;
      }
    }
    return coarse_m;
  }

  const KnownSequence& known_;
  const DepthSensor sensor_;
  const SurfelMap& map_;
  DepthSensor coarse_;
  ModelRenderer renderer_{RenderOptions()};
  ColorAverage average_;
};

// Leaves out what a frame sees outside of the part and its margin.
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

// Each point of space is in one of the boxes that stand side by side.
void Crop(const Eigen::AlignedBox3f& box, SurfelMap* map) {
  for (const std::int32_t id : map->Ids()) {
    const Eigen::Vector3f at = (*map)[id].position_in_world;
    const bool is_in =
        (at.array() >= box.min().array()).all() && (at.array() < box.max().array()).all();
    if (!is_in) map->Mark(id);
  }
  map->RemoveMarked();
}

std::optional<SurfelMap> Fuse(const KnownSequence& known, const MapPart* part,
                              const std::atomic<bool>& interrupted,
                              const FinalMapProgress& progress) {
  const std::vector<FrameRange> ranges = part ? part->frames : std::vector<FrameRange>();
  auto source = OpenAgain(known.sequence, ranges);
  FinalMap final_map(known, source->info());
  SurfelMap& map = final_map.map();
  const DepthSensor sensor = known.found.Of(source->info().sensor());
  int fused = 0, done = 0;  // frames, and what is done of them: a third of it is recolouring
  const auto for_each = [&](FrameSource* frames, const auto& take) {
    return ReadKnownFrames(known, frames, interrupted, [&](std::size_t pose, RgbdFrame frame) {
      if (known.left_out.count(frame.index) > 0) return;
      take(std::move(frame), known.trajectory[pose].world_from_camera);
      done += 2;
      progress(std::max(1, done / 3), map.size());
    });
  };
  const bool is_fused = for_each(source.get(), [&](RgbdFrame frame, const Rigid3d& pose) {
    if (part) frame.depth_m = Within(*part, sensor.camera, pose, std::move(frame.depth_m));
    final_map.Fuse(std::move(frame), pose);
    ++fused;
  });
  if (!is_fused) return std::nullopt;
  const FusionOptions& fusion = known.slam.fusion;
  if (fused > fusion.max_dormant_frames) DropFlying(fusion, &map);
  SmoothMap(sensor, &map);
  source.reset();  // of a long recording its list of frames is large
  SequenceOptions some = known.sequence;
  some.stride *= kColorStride;
  const auto again = OpenAgain(some, ranges);
  Recoloring recoloring(known, again->info(), map);
  const bool is_colored = for_each(again.get(), [&](RgbdFrame frame, const Rigid3d& pose) {
    recoloring.Add(std::move(frame), pose);
  });
  if (!is_colored) return std::nullopt;
  recoloring.WriteTo(&map);
  if (part) Crop(part->box, &map);
  progress(fused, map.size());
  return std::move(map);
}

}  // namespace

std::optional<SurfelMap> FuseAnew(const KnownSequence& known, const std::atomic<bool>& interrupted,
                                  const FinalMapProgress& progress) {
  return Fuse(known, nullptr, interrupted, progress);
}

std::optional<SurfelMap> FusePart(const KnownSequence& known, const MapPart& part,
                                  const std::atomic<bool>& interrupted,
                                  const FinalMapProgress& progress) {
  return Fuse(known, &part, interrupted, progress);
}

}  // namespace surfit
