#pragma once

#include <optional>

#include "surfit/geometry/rigid3.h"
#include "surfit/registration/global_registration.h"
#include "surfit/tracking/tracking.h"
#include "tracking/frame_preprocessor.h"
#include "tracking/frame_registration.h"
#include "tracking/model_views.h"
#include "tracking/tracked.h"
#include "tracking/tracking_state.h"

namespace surfit {

// Pose of a lost camera by place recognition.
struct KeyframePose {
  int keyframe = 0;  // position
  int frame_index = 0;
  Rigid3d world_from_camera;
};

// Place recognition and submaps for tracking.
class Relocalizer {
 public:
  virtual ~Relocalizer() = default;

  // Returns std::nullopt if no keyframe shows the same place.
  virtual std::optional<KeyframePose> Find(const ColoredView& view) = 0;
  // Begins a new submap after this number of consecutive lost frames. Returns the pose of the
  // camera in it, or std::nullopt if the submap is not due.
  virtual std::optional<Rigid3d> BeginSubmap(int lost_frames, const Rigid3d& world_from_last) = 0;
};

struct SearchStart {
  const TrackingState& state;
  const ReferenceView& last;  // last frame with a pose
  double seconds = 0;         // since the last frame with a pose
  // Predicted pose, std::nullopt without a motion prior.
  std::optional<Rigid3d> expected;
};

// Searches uncertain frames without a usable prediction. The map confirms each found pose.
class PoseSearch {
 public:
  // Keeps references and the pointer.
  PoseSearch(const TrackingOptions& options, const FrameRegistration& registration,
             ModelViews* views)
      : options_(options), registration_(registration), views_(views) {}

  // Null: no place recognition.
  void UseRelocalizer(Relocalizer* relocalizer) { relocalizer_ = relocalizer; }

  // Searches a frame that is lost or uncertain after registration. An uncertain result becomes a
  // tentative pose, and the frame is lost.
  Tracked Search(const PreprocessedFrame& frame, const SearchStart& start, Tracked tracked) const;

 private:
  // Global registration to the last frame with a pose. Returns std::nullopt if the pose is not
  // found, or if this frame is not searched.
  std::optional<Tracked> FromLastFrame(const PreprocessedFrame& frame,
                                       const SearchStart& start) const;
  // Relocalisation by keyframes. Returns std::nullopt in the same cases.
  std::optional<Tracked> ByKeyframes(const PreprocessedFrame& frame,
                                     const SearchStart& start) const;
  std::optional<Tracked> Confirm(const PreprocessedFrame& frame, const SearchStart& start,
                                 const Rigid3d& world_from_found) const;

  const TrackingOptions& options_;
  const FrameRegistration& registration_;
  ModelViews* views_;
  Relocalizer* relocalizer_ = nullptr;
};

}  // namespace surfit
