#pragma once

namespace surfit {

// Phase of the tracker between two frames.
enum class TrackingPhase {
  kNotStarted,   // no frame has had a pose
  kTracking,     // the last frame has a pose
  kRelocalised,  // the last pose was found by search; the next frame is verified by search
  kLost,         // the last frame has no pose
  kTentative,    // the last frame is lost, with a tentative pose
};

// A duplicate frame is no event.
enum class TrackingEvent {
  kPose,           // registration from the predicted pose, first frame, given pose, or new submap
  kFound,          // pose from PoseSearch, or a confirmed tentative pose
  kNoPose,         // lost frame
  kTentativePose,  // lost frame with a tentative pose
  kTentativeCompared,  // comparison of the next frame with the tentative pose
};

// Transitions. A tracker begins in kNotStarted, or in kLost if the map is given (InGivenMap()).
// Tracker::Update() makes the transition at the end of each frame, except duplicates. In
// kTentative, Tracker::Track() makes the transition kTentativeCompared first. The event of the
// first frame, of a given pose and of the first frame of a new submap is kPose. An event with a
// pose sets lost_frames to 0 and is_localised to true; an event without a pose increments
// lost_frames. "-": does not occur.
//
//                | kPose     | kFound       | kNoPose     | kTentativePose | kTentativeCompared
//   kNotStarted  | kTracking | kRelocalised | kNotStarted | -              | -
//   kTracking    | kTracking | kRelocalised | kLost       | kTentative     | -
//   kRelocalised | kTracking | kRelocalised | kLost       | kTentative     | -
//   kLost        | kTracking | kRelocalised | kLost       | kTentative     | -
//   kTentative   | kTracking | -            | -           | -              | kLost

// Properties of a registered frame that affect the next frame.
struct FrameQuality {
  bool is_weakly_constrained = false;  // see TrackingOptions::min_turn_eigenvalue
  bool is_by_newest = false;           // registered to all surfels, including unstable surfels
  bool is_first = false;               // first frame of the recording: no motion is known
};

// State of the tracker between two frames.
struct TrackingState {
  TrackingPhase phase = TrackingPhase::kNotStarted;
  int lost_frames = 0;       // consecutive frames without a pose
  bool is_localised = true;  // false: given map without a tracked frame yet
  FrameQuality last;         // of the last frame with a pose

  // Initial state with a given map: the camera pose is unknown.
  static TrackingState InGivenMap() { return {TrackingPhase::kLost, 0, false, {}}; }

  bool HasStarted() const { return phase != TrackingPhase::kNotStarted; }
  bool IsTentative() const { return phase == TrackingPhase::kTentative; }
  bool HasLastPose() const { return HasStarted() && is_localised && lost_frames == 0; }
  // The next frame is registered without subsampling to its own model view, and is fused.
  bool NeedsAllPoints() const {
    return lost_frames > 0 || last.is_weakly_constrained || last.is_by_newest;
  }
  // The pose of the next frame is searched even if its registration is accepted.
  bool NeedsSearch() const { return lost_frames > 0 || !is_localised; }
  // The pose of the next frame is searched if TrackingOptions::VerifiesBySearch() is true.
  bool NeedsVerification() const { return phase == TrackingPhase::kRelocalised; }
  // Fewer than three frames were lost. False before the first pose, in a given map, and with a
  // tentative pose.
  bool HasPredictableMotion() const;
};

// `quality` belongs to a frame with a pose. Impossible transitions ("-") are not checked.
TrackingState Next(const TrackingState& state, TrackingEvent event, FrameQuality quality = {});

}  // namespace surfit
