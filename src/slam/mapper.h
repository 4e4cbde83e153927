#pragma once

#include <cstddef>
#include <vector>

#include "slam/tracker.h"
#include "surfit/mapping/fusion.h"
#include "surfit/mapping/model_renderer.h"
#include "surfit/slam/slam.h"

namespace surfit {

// How far a motion moves the middle of an image of what the level shows, as a share of its width.
double ImageShift(const Rigid3d& motion, const FrameLevel& level);

// Keeps the map: fuses frames into it, draws the views that frames are registered to, in turns,
// and moves it where loops have been closed.
class Mapper {
 public:
  // Keeps a reference to the options, whose fusion.active_frames is that of loops where these are
  // closed.
  Mapper(const DepthSensor& sensor, const SlamOptions& options);

  // Takes up a map, as another one has left it after these frames, by a camera that is seen so now.
  void GoOnFrom(SurfelMap map, const std::vector<int>& fused_frames, const DepthSensor& sensor);

  const SurfelMap& map() const { return map_; }
  // Surfels that became part of others when the map was moved, in all.
  std::size_t merged_doubles() const { return merged_doubles_; }
  // How often surfels have changed that no frame was fused to.
  int corrections() const { return corrections_; }

  // As the camera is seen now.
  const DepthSensor& sensor() const { return sensor_; }

  // What the map shows from a pose.
  ReferenceView Draw(const Rigid3d& world_from_view, bool with_intensities) {
    return DrawBy(&renderer_, world_from_view, with_intensities);
  }
  // The same, but what has just come into sight hides what is behind it although it is not stable
  // yet, as the side of a doorway does while the camera passes it.
  ReferenceView DrawNewest(const Rigid3d& world_from_view, bool with_intensities) {
    return DrawBy(&newest_renderer_, world_from_view, with_intensities);
  }
  // What it showed when a view was drawn last for frames to be registered to.
  const ReferenceView& view() const { return view_; }
  // Draws view() anew for a frame where it must have its own, where it is its turn, or where
  // view() shows little of what the frame is expected to see; not if it was drawn for that frame
  // ahead. Returns whether the frame has its own.
  bool UpdateView(const Rigid3d& world_from_predicted, bool must, bool with_intensities);

  // Of so many frames that are held one has its turn to be fused, of SlamOptions::map_period at
  // first.
  void SetPeriod(int frames) { period_ = frames; }
  bool is_hurried() const { return period_ > options_.map_period; }
  // Also one that sees much that the last did not.
  bool IsTurnToFuse(const PreparedFrame& frame, const Rigid3d& world_from_camera) const;
  FusionReport Fuse(const PreparedFrame& frame, const Rigid3d& world_from_camera,
                    const CameraMotion& motion);
  void Skip() { ++unfused_count_; }

  void Correct(const WorldCorrection& correction, int frame_index);
  // Makes those surfels active, as of frame `now`, that were last seen at about this frame.
  void WakeAround(int frame_index, int now);

 private:
  ReferenceView DrawBy(ModelRenderer* renderer, const Rigid3d& world_from_view,
                       bool with_intensities);

  const SlamOptions& options_;
  DepthSensor sensor_;
  ModelRenderer renderer_;
  ModelRenderer newest_renderer_;  // for which all surfels are stable
  Fusion fusion_;
  SurfelMap map_;
  ReferenceView view_;
  bool has_view_ = false;     // of today's camera
  bool is_view_new_ = false;  // the map has not changed since it was drawn
  int period_;
  int unfused_count_ = 0;     // frames that were held since the last one that was fused
  Rigid3d world_from_fused_;  // of that one
  std::size_t merged_doubles_ = 0;
  int corrections_ = 0;
  int merged_until_ = 0;  // frame before which all doubles of the map are merged
};

}  // namespace surfit
