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

// Pose of a lost camera by relocalisation, and the matching keyframe.
struct KeyframePose {
  int keyframe = 0;  // position in the list of keyframes
  int frame_index = 0;
  int submap = 0;             // of the keyframe
  Rigid3d world_from_camera;  // of the lost camera
};

// Place recognition for lost frames. Functions run on the tracking thread.
class Relocalizer {
 public:
  virtual ~Relocalizer() = default;

  // Verifies one similar keyframe: `rank` counts by descending similarity, modulo the number of
  // similar keyframes. Returns std::nullopt if the keyframe does not match.
  virtual std::optional<KeyframePose> Find(const ColoredView& view, int rank) = 0;
  // Returns earlier_from_view, or std::nullopt if the registration is not accepted.
  virtual std::optional<Rigid3d> RegisterTo(const ColoredView& earlier,
                                            const ColoredView& view) = 0;
  // Begins a new submap if `lost_frames` lost frames with enough depth are enough. Returns its
  // number, or std::nullopt if no submap was begun. The submap has a world frame of its own.
  virtual std::optional<int> BeginSubmap(int lost_frames) = 0;
};

// Situation before the searched frame. References must be valid during the search.
struct SearchStart {
  const TrackingState& state;
  // Last frame with a pose. `view` is set if tracking is frame-to-frame, and unless
  // TrackingOptions::initialize is "identity".
  const ReferenceView& last;
  double seconds = 0;   // since the last frame with a pose
  int submap = 0;       // of the last pose
  int lost_frames = 0;  // lost frames with enough depth since the last pose
  // Predicted pose; std::nullopt without a motion prior.
  std::optional<Rigid3d> expected;
};

// Estimates poses of lost or uncertain frames by features, global registration and relocalisation.
// Each pose is verified by registration to the map. These searches run for every fifth lost frame,
// and for each of the first five with TrackingOptions::VerifiesBySearch(). Frames with too little
// depth do not count.
//
// With a Relocalizer, features register a small view to the last frame with a pose, which takes
// about as long as tracking. If they do not confirm the pose of the first uncertain or lost frame,
// global registration follows, which takes ten times as long. It is left out without
// VerifiesBySearch(), for example in real time. Each lost frame is also verified against one
// similar keyframe, in turns.
class PoseSearch {
 public:
  // Keeps references and the pointer.
  PoseSearch(const TrackingOptions& options, const FrameRegistration& registration,
             MovingRegions* regions, ModelViews* views)
      : options_(options), registration_(registration), regions_(regions), views_(views) {}

  // Null: no place recognition.
  void UseRelocalizer(Relocalizer* relocalizer) { relocalizer_ = relocalizer; }

  // Searches the pose of a frame. `tracked`: outcome of its registration from the predicted pose. A
  // pose that needs confirmation becomes tentative, and the frame is lost. An uncertain frame
  // without a search result is lost. Changes only the model views: ActivateAround(), and
  // UseSubmap() for a pose in another submap, which also forgets the moving regions.
  Tracked Search(const PreprocessedFrame& frame, const SearchStart& start, Tracked tracked) const;

 private:
  // Search from the last frame with a pose. Returns `tracked` if the result agrees closely with its
  // pose, else the pose that the map confirms. Returns std::nullopt if the search fails or is not
  // due.
  std::optional<Tracked> FromLastFrame(const PreprocessedFrame& frame, const SearchStart& start,
                                       const Tracked& tracked) const;
  // Whether features register small views, see Relocalizer::RegisterTo().
  bool HasFeatures() const;
  // Pose world_from_camera by features, without the moving cells of `tracked`. Returns std::nullopt
  // without HasFeatures(), or if the registration is not accepted.
  std::optional<Rigid3d> ByFeatures(const PreprocessedFrame& frame, const SearchStart& start,
                                    const Tracked& tracked) const;
  // Global registration without the moving cells of `tracked`, and within PossibleMotion(). Results
  // are those of FromLastFrame().
  std::optional<Tracked> Globally(const PreprocessedFrame& frame, const SearchStart& start,
                                  const Tracked& tracked) const;
  // Returns whether a search from the last frame is due.
  bool IsDue(const PreprocessedFrame& frame, const SearchStart& start) const;
  // Returns whether a registration to the last frame confirms the pose of an uncertain frame with
  // moving objects or few inliers.
  bool StaticPartAgrees(const PreprocessedFrame& frame, const SearchStart& start,
                        const Tracked& tracked) const;
  // Returns std::nullopt if the keyframe of this frame does not match.
  std::optional<Tracked> ByKeyframes(const PreprocessedFrame& frame,
                                     const SearchStart& start) const;
  std::optional<Tracked> Confirm(const PreprocessedFrame& frame, const SearchStart& start,
                                 const Rigid3d& world_from_found) const;

  const TrackingOptions& options_;
  const FrameRegistration& registration_;
  MovingRegions* regions_;
  ModelViews* views_;
  Relocalizer* relocalizer_ = nullptr;
};

}  // namespace surfit
