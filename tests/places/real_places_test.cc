#include <gmock/gmock.h>

#include <algorithm>
#include <memory>
#include <optional>

#include "places/simulated_places.h"
#include "surfit/io/sequence.h"
#include "surfit/loop_closure/find_loops.h"
#include "testing/matchers.h"
#include "testing/shared_data.h"

namespace surfit::testing {
namespace {

constexpr char kKitchen[] = "seven_scenes_kitchen";

// Frames of the kitchen as keyframes at the poses of its ground truth.
std::vector<Keyframe> KitchenFrames(int first, int last, int stride) {
  SequenceOptions options;
  options.path = SharedData(kKitchen);
  options.first = first;
  options.last = last;
  options.stride = stride;
  const std::unique_ptr<FrameSource> source = OpenSequence(options);
  std::vector<Keyframe> keyframes;
  while (const std::optional<ReadResult> read = source->Next()) {
    const FramePyramid pyramid =
        PreprocessDepth(read->frame->depth_m, source->info().sensor(), PreprocessOptions());
    keyframes.push_back({read->index, read->stamp_s,
                         *InterpolatePose(source->info().ground_truth, read->stamp_s),
                         MakePlaceView(pyramid, read->frame->color, PlaceViewOptions())});
  }
  return keyframes;
}

// The ground truth is from another SLAM system, with errors of centimetres.
TEST(RealPlaces, VerifiesRevisitOfKitchen) {
  SURFIT_REQUIRE_SHARED_DATA(kKitchen);
  const std::vector<Keyframe> before = KitchenFrames(270, 280, 10);
  const std::vector<Keyframe> after = KitchenFrames(980, 990, 10);
  ASSERT_EQ(before.size(), after.size());
  for (std::size_t i = 0; i < before.size(); ++i) {
    const GlobalRegistrationResult verdict =
        VerifyLoop(after[i].view, before[i].view, VerifyLoopOptions());
    EXPECT_EQ(ToString(verdict.reason), "accepted");
    EXPECT_THAT(verdict.target_from_source,
                RigidNear(before[i].world_from_camera.Inverse() * after[i].world_from_camera, 0.05,
                          3 * kRadPerDeg));
  }
}

bool IsKnown(const Keyframe& frame, const std::vector<Keyframe>& keyframes) {
  return std::any_of(keyframes.begin(), keyframes.end(), [&](const Keyframe& keyframe) {
    const Rigid3d motion = keyframe.world_from_camera.Inverse() * frame.world_from_camera;
    return motion.translation.norm() < 0.3 && RotationAngle(motion.rotation) < 15 * kRadPerDeg;
  });
}

// Number of frames from the first frame of a known place to the first relocalised frame.
// std::nullopt: too few frames after a known place.
std::optional<int> FramesToRelocalize(const std::vector<Keyframe>& frames, std::size_t first,
                                      const std::vector<Keyframe>& keyframes,
                                      const PlaceIndex& index, int most) {
  while (first < frames.size() && !IsKnown(frames[first], keyframes)) ++first;
  if (first + most > frames.size()) return std::nullopt;
  for (int i = 0; i < most; ++i) {
    const Keyframe& frame = frames[first + i];
    const Relocalization found = Relocalize(frame.view, keyframes, index, RelocalizeOptions());
    if (!found.found()) continue;
    EXPECT_THAT(found.world_from_camera, RigidNear(frame.world_from_camera, 0.1, 4 * kRadPerDeg))
        << frame.frame_index << " by " << keyframes[found.keyframe].frame_index;
    return i;
  }
  return most;
}

TEST(RealPlaces, RelocalisesKidnappedCamera) {
  SURFIT_REQUIRE_SHARED_DATA(kKitchen);
  const std::vector<Keyframe> keyframes = KitchenFrames(200, 320, 15);
  const std::vector<Keyframe> later = KitchenFrames(960, 975, 1);
  const auto frames = FramesToRelocalize(later, 0, keyframes, IndexOf(keyframes), 10);
  ASSERT_TRUE(frames.has_value());
  EXPECT_LT(*frames, 10);
}

// Simulates a camera that is carried from frame 450 to a later frame.
TEST(RealPlacesSweep, RelocalisesCameraAtEveryPlace) {
  SURFIT_REQUIRE_SHARED_DATA(kKitchen);
  constexpr int kMost = 10, kStride = 25;
  const std::vector<Keyframe> keyframes = KitchenFrames(0, 450, 15);
  const std::vector<Keyframe> later = KitchenFrames(500, 999, 1);
  const PlaceIndex index = IndexOf(keyframes);
  int tried = 0, longest = 0;
  for (std::size_t first = 0; first < later.size(); first += kStride) {
    const auto frames = FramesToRelocalize(later, first, keyframes, index, kMost);
    if (!frames) continue;
    ++tried;
    longest = std::max(longest, *frames);
    EXPECT_LT(*frames, kMost) << "from frame " << later[first].frame_index;
  }
  EXPECT_GE(tried, 10);
  RecordProperty("tried", tried);
  RecordProperty("longest", longest);
}

}  // namespace
}  // namespace surfit::testing
