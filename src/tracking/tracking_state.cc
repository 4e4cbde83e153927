#include "tracking/tracking_state.h"

namespace surfit {
namespace {

// Number of consecutive lost frames with a predictable motion.
constexpr int kSteadyFrames = 3;

}  // namespace

bool TrackingState::HasPredictableMotion() const {
  return HasStarted() && is_localised && !IsTentative() && lost_frames < kSteadyFrames;
}

TrackingState Next(const TrackingState& state, TrackingEvent event, FrameQuality quality) {
  TrackingState next = state;
  switch (event) {
    case TrackingEvent::kPose:
      return {TrackingPhase::kTracking, 0, true, quality};
    case TrackingEvent::kFound:
      return {TrackingPhase::kRelocalised, 0, true, quality};
    case TrackingEvent::kNoPose:
      ++next.lost_frames;
      if (state.HasStarted()) next.phase = TrackingPhase::kLost;
      return next;
    case TrackingEvent::kTentativePose:
      ++next.lost_frames;
      next.phase = TrackingPhase::kTentative;
      return next;
    case TrackingEvent::kTentativeCompared:
      next.phase = TrackingPhase::kLost;
      return next;
  }
  return next;
}

}  // namespace surfit
