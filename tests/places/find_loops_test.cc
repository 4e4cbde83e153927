#include "surfit/loop_closure/find_loops.h"

#include <gmock/gmock.h>

#include "places/simulated_places.h"
#include "surfit/core/options.h"
#include "testing/matchers.h"

namespace surfit::testing {
namespace {

Rigid3d SmallMotion() {
  return Rigid3d(QuaternionExp<double>({0.03, 0.1, -0.05}), {0.1, 0.04, 0.1});
}

// Keyframes of a room. The last keyframe revisits keyframe kTarget, and its estimated pose has a
// drift error.
struct Return {
  std::vector<Keyframe> keyframes;
  PlaceIndex index;
  int source;
  Rigid3d target_from_source;
  static constexpr int kTarget = 5;

  explicit Return(double drift_m) {
    const RoomOfKeyframes& room = MakeRoomOfKeyframes(1);
    keyframes = room.keyframes;
    source = static_cast<int>(keyframes.size());
    index = IndexOf(keyframes);
    target_from_source = SmallMotion();
    Keyframe back;
    back.frame_index = 1000;
    back.view = SeeNearby(room, kTarget, SmallMotion()).view;
    back.world_from_camera = Rigid3d(Eigen::Quaterniond::Identity(), {drift_m, 0, 0}) *
                             keyframes[kTarget].world_from_camera * SmallMotion();
    keyframes.push_back(back);
  }
};

const LoopVerification* AttemptAt(const std::vector<LoopVerification>& attempts, int target) {
  for (const LoopVerification& attempt : attempts) {
    if (attempt.proposal.target == target) return &attempt;
  }
  return nullptr;
}

TEST(FindLoops, FindsRevisitAtSmallAndLargeDrift) {
  for (const double drift_m : {0.05, 10.}) {
    const Return back(drift_m);
    const auto attempts = FindLoops(back.source, back.keyframes, back.index, FindLoopsOptions());
    const LoopVerification* const attempt = AttemptAt(attempts, Return::kTarget);
    ASSERT_NE(attempt, nullptr);
    EXPECT_GT(attempt->proposal.similarity, 0);
    EXPECT_EQ(attempt->proposal.target_from_source_prior.has_value(), drift_m < 1);
    EXPECT_EQ(ToString(attempt->verdict.reason), "accepted");
    EXPECT_THAT(attempt->verdict.target_from_source,
                RigidNear(back.target_from_source, 0.02, 0.5 * kRadPerDeg));
  }
}

TEST(ProposeLoopCandidates, ProposesNearestKeyframeWithoutFeatures) {
  Return back(0.05);
  back.keyframes[back.source].view.features.clear();
  FindLoopsOptions options;
  options.max_near = 1;
  const auto proposals = ProposeLoopCandidates(back.source, back.keyframes, back.index, options);
  ASSERT_EQ(proposals.size(), 1);
  EXPECT_EQ(proposals[0].similarity, 0);
  ASSERT_TRUE(proposals[0].target_from_source_prior.has_value());
  for (int i = 0; i < back.source; ++i) {
    const Rigid3d motion = back.keyframes[i].world_from_camera.Inverse() *
                           back.keyframes[back.source].world_from_camera;
    const Rigid3d& nearest = *proposals[0].target_from_source_prior;
    EXPECT_GE(std::max(motion.translation.norm() / FindLoopsOptions::kMaxNear_m,
                       RotationAngle(motion.rotation) / FindLoopsOptions::kMaxNear_rad) +
                  1e-9,
              std::max(nearest.translation.norm() / FindLoopsOptions::kMaxNear_m,
                       RotationAngle(nearest.rotation) / FindLoopsOptions::kMaxNear_rad));
  }
}

TEST(ProposeLoopCandidates, IgnoresRecentKeyframesAndKeyframesWithoutViews) {
  Return back(0.05);
  FindLoopsOptions options;
  options.min_gap = 1000;
  for (const LoopCandidate& p :
       ProposeLoopCandidates(back.source, back.keyframes, back.index, options)) {
    EXPECT_EQ(back.keyframes[p.target].frame_index, 0);
  }
  options.min_gap = 100;
  for (int i = 0; i < back.source; ++i) back.keyframes[i].view = PlaceView();
  EXPECT_TRUE(ProposeLoopCandidates(back.source, back.keyframes, back.index, options).empty());
}

// Poses of different pieces are not comparable. Only place recognition proposes candidates there,
// and recent keyframes are candidates as well.
TEST(ProposeLoopCandidates, UsesNoPosesAndNoGapBetweenPieces) {
  Return back(0.05);
  back.keyframes[back.source].piece = 1;
  FindLoopsOptions options;
  options.min_gap = 100000;
  const auto proposals = ProposeLoopCandidates(back.source, back.keyframes, back.index, options);
  ASSERT_FALSE(proposals.empty());
  for (const LoopCandidate& p : proposals) {
    EXPECT_GT(p.similarity, 0);
    EXPECT_FALSE(p.target_from_source_prior.has_value());
  }
}

Keyframe WithoutColor(const Scene& scene, const Rigid3d& pose, int index) {
  RgbdFrame frame = SeenFrom(scene, pose, index);
  frame.color = {};
  return KeyframeOf(frame, pose);
}

std::vector<Keyframe> KeyframesWithoutColor(const RoomOfKeyframes& room) {
  std::vector<Keyframe> keyframes;
  for (const Keyframe& keyframe : room.keyframes) {
    keyframes.push_back(WithoutColor(room.scene, keyframe.world_from_camera, keyframe.frame_index));
  }
  return keyframes;
}

TEST(Relocalize, FindsCameraByDepthAlone) {
  const RoomOfKeyframes& room = MakeRoomOfKeyframes(1);
  const std::vector<Keyframe> keyframes = KeyframesWithoutColor(room);
  const PlaceIndex index = IndexOf(keyframes);
  int tried = 0, found = 0;
  for (int first = 5; first + 10 < static_cast<int>(room.path.size()); first += 40, ++tried) {
    for (int i = 0; i < 10; ++i) {
      const Rigid3d pose = room.path[first + i].world_from_camera * SmallMotion();
      const Relocalization result =
          Relocalize(WithoutColor(room.scene, pose, i).view, keyframes, index, RelocalizeOptions());
      if (!result.found()) continue;
      EXPECT_THAT(result.world_from_camera, RigidNear(pose, 0.03, 0.8 * kRadPerDeg));
      ++found;
      break;
    }
  }
  EXPECT_GE(found, tried - 1);
}

TEST(Relocalize, FindsNothingInAnotherRoomByDepthAlone) {
  const std::vector<Keyframe> keyframes = KeyframesWithoutColor(MakeRoomOfKeyframes(1));
  const PlaceIndex index = IndexOf(keyframes);
  for (const Keyframe& other : KeyframesWithoutColor(MakeRoomOfKeyframes(2))) {
    EXPECT_FALSE(Relocalize(other.view, keyframes, index, RelocalizeOptions()).found());
  }
}

// Number of frames of a path near the path of the room until relocalisation succeeds.
int FramesToRelocalize(const RoomOfKeyframes& room, const PlaceIndex& index, int first, int most) {
  for (int i = 0; i < most; ++i) {
    const Rigid3d pose = room.path[first + i].world_from_camera * SmallMotion();
    const PlaceView view = KeyframeOf(SeenFrom(room.scene, pose, i), pose).view;
    const Relocalization result = Relocalize(view, room.keyframes, index, RelocalizeOptions());
    if (!result.found()) continue;
    EXPECT_TRUE(result.attempts.back().verdict.accepted());
    EXPECT_THAT(result.world_from_camera, RigidNear(pose, 0.03, 0.8 * kRadPerDeg));
    return i;
  }
  return most;
}

TEST(Relocalize, FindsKidnappedCameraWithinTenFrames) {
  for (const std::uint64_t seed : {1, 2}) {
    const RoomOfKeyframes& room = MakeRoomOfKeyframes(seed);
    const PlaceIndex index = IndexOf(room.keyframes);
    for (int first = 5; first + 10 < static_cast<int>(room.path.size()); first += 40) {
      EXPECT_LT(FramesToRelocalize(room, index, first, 10), 10) << seed << ' ' << first;
    }
  }
}

TEST(Relocalize, FindsNothingInAnotherRoom) {
  const RoomOfKeyframes &room = MakeRoomOfKeyframes(1), &other = MakeRoomOfKeyframes(2);
  const PlaceIndex index = IndexOf(room.keyframes);
  for (int i = 0; i < 30; i += 3) {
    EXPECT_FALSE(
        Relocalize(other.keyframes[i].view, room.keyframes, index, RelocalizeOptions()).found());
  }
}

TEST(FindLoopsOptions, RejectInvalidValues) {
  const auto expect_refused = ExpectOptionsRefused<FindLoopsOptions>;
  expect_refused([](auto& o) { o.min_gap = 0; }, "min_gap", "0");
  ExpectOptionsRefused<RelocalizeOptions>([](auto& o) { o.max_candidates = 0; }, "max_candidates",
                                          "0");
}

}  // namespace
}  // namespace surfit::testing
