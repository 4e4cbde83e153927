#include "run/final_map.h"

#include <cstdint>
#include <memory>
#include <utility>

#include "mapping/smooth_map.h"
#include "surfit/frame/frame_pyramid.h"
#include "surfit/frame/prepare_frame.h"
#include "surfit/frame/rolling_shutter.h"
#include "surfit/io/frame_source.h"
#include "surfit/mapping/fusion.h"

namespace surfit {
namespace {

// Tracking by so many surfels would take longer, and be no better.
constexpr float kSpacingShare = 0.7f;

FusionOptions Finer(FusionOptions options) {
  options.max_spacing_m *= kSpacingShare;
  return options;
}

// What was seen about once goes from a map once it has not been seen for a while. Nothing comes
// after the last frames, which most of what flies is from.
void DropSeenOnce(const FusionOptions& options, SurfelMap* map) {
  for (const std::int32_t id : map->Ids()) {
    if ((*map)[id].confidence < options.lasting_confidence) map->Mark(id);
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

}  // namespace

std::optional<SurfelMap> FuseAnew(const KnownSequence& known, const std::atomic<bool>& interrupted,
                                  const FinalMapProgress& progress) {
  const auto source = OpenAgain(known.sequence);
  FinalMap final_map(known, source->info());
  int frames = 0;
  const bool all =
      ReadKnownFrames(known, source.get(), interrupted, [&](std::size_t pose, RgbdFrame frame) {
        if (known.left_out.count(frame.index) > 0) return;
        final_map.Fuse(std::move(frame), known.trajectory[pose].world_from_camera);
        progress(++frames, final_map.map().size());
      });
  if (!all) return std::nullopt;
  const FusionOptions& fusion = known.slam.fusion;
  if (frames > fusion.max_dormant_frames) DropSeenOnce(fusion, &final_map.map());
  SmoothMap(known.found.Of(source->info().sensor()), &final_map.map());
  return std::move(final_map.map());
}

}  // namespace surfit
