// When is a pose called tracked? Over recordings read with strides, cameras that are suddenly
// somewhere else, and things that move before them: few of those that are believed may be wrong,
// and few of those that are right may be called lost. What is printed is the table of
// docs/understand.md.
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

// Of ten thousand that are believed one may be wrong, of a hundred that are right one lost; of
// those that see things move more are.
constexpr double kCalledRight = 0.99, kCalledRightWhereThingsMove = 0.85;

void ExpectFewMistakes(const Verdicts& verdicts, double least_called_right) {
  EXPECT_LE(verdicts.wrong, 1e-4 * verdicts.believed);
  EXPECT_GE(verdicts.CalledRight(), least_called_right);
}

Verdicts Row(const std::string& name, const Recording& recording,
             const SlamOptions& options = DefaultSlam()) {
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

TEST_P(BeliefSweep, SomethingBeforeTheCamera) {
  SURFIT_REQUIRE_SHARED_DATA(GetParam());
  const std::string name = GetParam();
  const Recording part = Joined(Recorded(name), {{0, 100}});
  Verdicts sum;
  for (const double share : {0.2, 0.4, 0.55, 0.7}) {
    sum += Row(name + " hidden " + std::to_string(share), Hidden(part, share, 30));
  }
  Print(name + ": something before the camera", sum);
  ExpectFewMistakes(sum, kCalledRightWhereThingsMove);
}

// What is there from the first frame on may be taken for the scene. Where poses are wrong for it,
// the images speak against them and that is told, or most frames are lost and the run fails.
TEST_P(BeliefSweep, SomethingBeforeTheCameraFromTheFirstFrameOn) {
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

// Somebody who walks before the camera, up to 0.27 s from frame to frame.
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

// A camera that is carried into a room that looks like the one before, and back: what is found then
// counts once the next frame agrees.
TEST(BeliefSweepRooms, AreToldApart) {
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
