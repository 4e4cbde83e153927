#pragma once

namespace surfit {

// Phase of the tracker between two frames.
enum class TrackingPhase {
  kNotStarted,   // no frame has a pose
  kTracking,     // the last frame has a pose
  kRelocalised,  // the last frame was found after a jump or a loss: search verifies the next frame
  kLost,         // the last frame has no pose
  kTentative,    // the last frame has no pose, but a tentative pose for the next frame to confirm
};

// Event that changes the state. A duplicate frame is no event.
enum class TrackingEvent {
  kPose,               // the frame was registered from the predicted pose, or its pose is given
  kFound,              // the frame was found by search
  kNoPose,             // the frame is lost
  kTentativePose,      // the frame is lost, and search has found a tentative pose
  kTentativeCompared,  // the next frame has confirmed or rejected the tentative pose
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

// Properties of a registered frame that its successor depends on.
struct FrameQuality {
  bool is_weakly_constrained = false;  // by shapes: TrackingOptions::min_turn_eigenvalue
  bool is_by_newest = false;           // accepted by surfels that are not stable yet
};

struct TrackingState {
  TrackingPhase phase = TrackingPhase::kNotStarted;
  int lost_frames = 0;       // consecutive frames without a pose
  bool is_localised = true;  // false: the map is given, and no frame has a pose in it yet
  FrameQuality last;         // last frame with a pose

  // The map is given, and the camera pose in it is unknown.
  static TrackingState InGivenMap() { return {TrackingPhase::kLost, 0, false, {}}; }

  bool HasStarted() const { return phase != TrackingPhase::kNotStarted; }
  bool IsTentative() const { return phase == TrackingPhase::kTentative; }
  // The last frame has a pose: its motion predicts the next pose.
  bool HasLastPose() const { return HasStarted() && is_localised && lost_frames == 0; }
  // The next frame is registered without subsampling, to its own view, and is fused.
  bool NeedsAllPoints() const {
    return lost_frames > 0 || last.is_weakly_constrained || last.is_by_newest;
  }
  // The next frame is searched even if its registration is accepted.
  bool NeedsSearch() const { return lost_frames > 0 || !is_localised; }
  // The next frame is searched if TrackingOptions::VerifiesBySearch().
  bool NeedsVerification() const { return phase == TrackingPhase::kRelocalised; }
  // The camera continues its motion despite few lost frames.
  bool HasPredictableMotion() const;
};

// State after an event. `quality` belongs to a frame with a pose.
TrackingState Next(const TrackingState& state, TrackingEvent event, FrameQuality quality = {});

}  // namespace surfit
