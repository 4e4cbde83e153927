#include "tracking/tracking_state.h"

#include <gtest/gtest.h>

#include <vector>

namespace surfit {
namespace {

using Event = TrackingEvent;
using Phase = TrackingPhase;

TEST(TrackingState, FollowsTransitionTable) {
  struct Transition {
    Phase from;
    Event event;
    Phase to;
  };
  for (const Transition& t : std::vector<Transition>{
           {Phase::kNotStarted, Event::kPose, Phase::kTracking},
           {Phase::kNotStarted, Event::kFound, Phase::kRelocalised},
           {Phase::kNotStarted, Event::kNoPose, Phase::kNotStarted},
           {Phase::kTracking, Event::kPose, Phase::kTracking},
           {Phase::kTracking, Event::kFound, Phase::kRelocalised},
           {Phase::kTracking, Event::kNoPose, Phase::kLost},
           {Phase::kTracking, Event::kTentativePose, Phase::kTentative},
           {Phase::kRelocalised, Event::kPose, Phase::kTracking},
           {Phase::kRelocalised, Event::kFound, Phase::kRelocalised},
           {Phase::kRelocalised, Event::kNoPose, Phase::kLost},
           {Phase::kRelocalised, Event::kTentativePose, Phase::kTentative},
           {Phase::kLost, Event::kPose, Phase::kTracking},
           {Phase::kLost, Event::kFound, Phase::kRelocalised},
           {Phase::kLost, Event::kNoPose, Phase::kLost},
           {Phase::kLost, Event::kTentativePose, Phase::kTentative},
           {Phase::kTentative, Event::kPose, Phase::kTracking},
           {Phase::kTentative, Event::kTentativeCompared, Phase::kLost},
       }) {
    TrackingState state;
    state.phase = t.from;
    EXPECT_EQ(Next(state, t.event).phase, t.to)
        << static_cast<int>(t.from) << ", " << static_cast<int>(t.event);
  }
}

TEST(TrackingState, CountsLostFramesUntilAPose) {
  TrackingState state = Next({}, Event::kPose);
  EXPECT_TRUE(state.HasLastPose());
  EXPECT_FALSE(state.NeedsSearch());
  EXPECT_FALSE(state.NeedsAllPoints());
  state = Next(Next(state, Event::kNoPose), Event::kTentativePose);
  EXPECT_EQ(state.lost_frames, 2);
  EXPECT_TRUE(state.NeedsSearch());
  EXPECT_TRUE(state.NeedsAllPoints());
  EXPECT_EQ(Next(state, Event::kTentativeCompared).lost_frames, 2);
  state = Next(state, Event::kFound);
  EXPECT_EQ(state.lost_frames, 0);
  EXPECT_TRUE(state.NeedsVerification());
  EXPECT_FALSE(Next(state, Event::kPose).NeedsVerification());
}

TEST(TrackingState, ContinuesMotionOverTwoLostFrames) {
  TrackingState state;
  EXPECT_FALSE(state.HasPredictableMotion());
  state = Next(Next(Next(state, Event::kPose), Event::kNoPose), Event::kNoPose);
  EXPECT_TRUE(state.HasPredictableMotion());
  EXPECT_FALSE(Next(state, Event::kNoPose).HasPredictableMotion());
  EXPECT_FALSE(Next(state, Event::kTentativePose).HasPredictableMotion());
}

TEST(TrackingState, NeedsAllPointsAfterWeakFrame) {
  EXPECT_TRUE(Next({}, Event::kPose, {true, false}).NeedsAllPoints());
  EXPECT_TRUE(Next({}, Event::kPose, {false, true}).NeedsAllPoints());
  const TrackingState lost = Next(Next({}, Event::kPose, {true, false}), Event::kNoPose);
  EXPECT_TRUE(lost.last.is_weakly_constrained);
}

TEST(TrackingState, SearchesInGivenMapUntilPose) {
  TrackingState state = TrackingState::InGivenMap();
  EXPECT_TRUE(state.HasStarted());
  EXPECT_TRUE(state.NeedsSearch());
  EXPECT_FALSE(state.HasLastPose());
  EXPECT_FALSE(state.HasPredictableMotion());
  state = Next(Next(state, Event::kTentativePose), Event::kTentativeCompared);
  EXPECT_FALSE(state.is_localised);
  EXPECT_TRUE(Next(state, Event::kFound).HasLastPose());
}

}  // namespace
}  // namespace surfit
