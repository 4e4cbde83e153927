// False positives and false negatives of pose verification: recordings with strides, camera jumps,
// and objects that move in front of the camera. Prints the table of docs/understand.md.
#include <gtest/gtest.h>

#include "run/belief_cases.h"

namespace surfit::testing {
namespace {

constexpr int kStrides[] = {1, 2, 3, 5, 8, 10, 15, 20};

SlamOptions WithLoops() {
  SlamOptions options;
  options.loops.enabled = true;
  return options;
}

// At most 1 of 10,000 accepted poses may be wrong. At most 1 of 100 correct poses may be lost, or
// more with moving objects.
constexpr double kCalledRight = 0.99, kCalledRightWhereThingsMove = 0.85;

void ExpectFewMistakes(const Verdicts& verdicts, double least_called_right) {
  EXPECT_LE(verdicts.wrong, 1e-4 * verdicts.believed);
  EXPECT_GE(verdicts.CalledRight(), least_called_right);
}

Verdicts Row(const std::string& name, const Recording& recording, const SlamOptions& options = {}) {
  const Verdicts verdicts = Judge(recording, options);
  Print(name, verdicts);
  return verdicts;
}

class BeliefSweep : public ::testing::TestWithParam<const char*> {};

TEST_P(BeliefSweep, EveryNthFrame) {
  SURFIT_REQUIRE_SHARED_DATA(GetParam());
  const std::string name = GetParam();
  const Recording all = Recorded(name);
  Verdicts sum;
  for (const int stride : kStrides) {
    sum += Row(name + " every " + std::to_string(stride), Every(all, stride));
  }
  for (const int stride : {8, 15}) {
    sum += Row(name + " loops, every " + std::to_string(stride), Every(all, stride), WithLoops());
  }
  sum += Row(name + " whole images, every 10", Recorded(name, 1, 10));
  Print(name + ": every n-th frame", sum);
  EXPECT_EQ(sum.apart, 0);
  ExpectFewMistakes(sum, kCalledRight);
}

TEST_P(BeliefSweep, KidnappedCameras) {
  SURFIT_REQUIRE_SHARED_DATA(GetParam());
  const std::string name = GetParam();
  const Recording all = Recorded(name);
  const int n = static_cast<int>(all.frames.size()), part = n / 8;
  Verdicts sum;
  for (int to = 2; to < 8; ++to) {
    const std::vector<std::pair<int, int>> parts = {
        {0, part}, {to * part, to * part + part / 2}, {part / 2, part}};
    sum += Row(name + " to " + std::to_string(to), Joined(all, parts));
    if (to % 3 == 0) {
      sum += Row(name + " to " + std::to_string(to) + ", loops", Joined(all, parts), WithLoops());
    }
  }
  Print(name + ": kidnapped", sum);
  ExpectFewMistakes(sum, kCalledRight);
}

TEST_P(BeliefSweep, MovingObjectInFrontOfTheCamera) {
  SURFIT_REQUIRE_SHARED_DATA(GetParam());
  const std::string name = GetParam();
  const Recording part = Joined(Recorded(name), {{0, 100}});
  Verdicts sum;
  for (const double share : {0.2, 0.4, 0.55, 0.7}) {
    sum += Row(name + " hidden " + std::to_string(share), Hidden(part, share, 30));
  }
  Print(name + ": object in front of the camera", sum);
  ExpectFewMistakes(sum, kCalledRightWhereThingsMove);
}

// An object that is present in the first frame may be mapped as the scene. If poses are wrong then,
// two motions are reported, or most frames are lost and the run fails.
TEST_P(BeliefSweep, MovingObjectSinceTheFirstFrame) {
  SURFIT_REQUIRE_SHARED_DATA(GetParam());
  const std::string name = GetParam();
  const Recording part = Joined(Recorded(name), {{0, 100}});
  for (const double share : {0.2, 0.4}) {
    const Verdicts verdicts =
        Row(name + " hidden from the first " + std::to_string(share), Hidden(part, share, 0));
    const bool fails = 2 * verdicts.believed < verdicts.frames;
    EXPECT_TRUE(verdicts.apart > 0 || fails || verdicts.wrong == 0) << share;
  }
}

INSTANTIATE_TEST_SUITE_P(Recordings, BeliefSweep,
                         ::testing::Values("tum_fr1_desk", "seven_scenes_kitchen", "icl_office",
                                           "icl_office_kinect"));

// A person walks in front of the camera, with up to 0.27 s between frames.
TEST(BeliefSweepPeople, WalkBeforeTheCamera) {
  Verdicts sum;
  for (const int seed : {2, 3}) {
    const Recording room = Simulated(seed, 120, 30);
    for (const int stride : {1, 3, 8}) {
      sum += Row("people " + std::to_string(seed) + " every " + std::to_string(stride),
                 Every(room, stride));
    }
  }
  Print("people", sum);
  ExpectFewMistakes(sum, kCalledRightWhereThingsMove);
}

// An object hides 30 % of the view and moves with the camera. The camera jumps to another place,
// where a new submap begins without the object.
TEST(Belief, NewSubmapLeavesOutMovingObject) {
  const Recording room = Simulated(2, 120, 120, 2);
  const Verdicts verdicts = Judge(Hidden(Joined(room, {{0, 25}, {35, 60}}), 0.3, 15));
  EXPECT_EQ(verdicts.wrong, 0);
  EXPECT_GE(verdicts.believed, 40);
}

// The camera moves into a similar room and back. A relocalised pose is accepted after confirmation
// by the next frame.
TEST(BeliefSweepRooms, AreDistinguished) {
  Verdicts sum;
  for (const int seed : {2, 3, 4, 5}) {
    for (const int other : {seed + 1, seed + 5}) {
      const std::string name = "room " + std::to_string(seed) + " and " + std::to_string(other);
      const Verdicts verdicts = Row(name, InTwoRooms(seed, other));
      EXPECT_EQ(verdicts.wrong, 0) << name;
      EXPECT_LE(verdicts.missed, 1) << name;
      sum += verdicts;
    }
  }
  Print("rooms", sum);
}

}  // namespace
}  // namespace surfit::testing
