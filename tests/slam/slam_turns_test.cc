#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "slam/ideal_room.h"
#include "surfit/slam/slam.h"

namespace surfit {
namespace {

using testing::Blank;
using testing::IdealRoom;

// The turns of some frames: f = fused, v = with a view of its own, b = both, - = neither.
std::string TurnsOf(const SlamOptions& options, int frames) {
  Slam slam({IdealRoom().camera, {}}, options, {});
  std::string turns;
  for (int i = 0; i < frames; ++i) {
    const std::size_t before = slam.map().size();
    const FrameReport report = slam.Process(IdealRoom().frames[i]);
    turns += report.is_fused && report.has_own_view ? 'b'
             : report.is_fused                      ? 'f'
             : report.has_own_view                  ? 'v'
                                                    : '-';
    EXPECT_EQ(report.fusion.input_points > 0, report.is_fused) << i;
    if (!report.is_fused) {
      EXPECT_EQ(slam.map().size(), before) << i;
    }
  }
  return turns;
}

TEST(Slam, FusionAndViewsOfTheMapTakeTurns) {
  SlamOptions options;
  options.max_view_shift = 1e9;
  options.min_turn_eigenvalue = 0;
  options.map_period = 1;
  EXPECT_EQ(TurnsOf(options, 5), "fbbbb");
  options.map_period = 2;
  EXPECT_EQ(TurnsOf(options, 6), "fvfvfv");
  options.map_period = 4;
  EXPECT_EQ(TurnsOf(options, 10), "fv--fv--fv");
}

TEST(Slam, AViewThatShowsLittleOfWhatTheCameraSeesIsDrawnAnew) {
  SlamOptions options;
  options.map_period = 4;
  options.max_view_shift = 0;
  options.min_turn_eigenvalue = 0;
  EXPECT_EQ(TurnsOf(options, 6), "fvvvbv");
}

TEST(Slam, NothingIsSparedAfterAFrameThatHoldsADirectionPoorly) {
  SlamOptions options;
  options.map_period = 4;
  options.min_turn_eigenvalue = 1;  // more than any frame's
  EXPECT_EQ(TurnsOf(options, 5), "fvbbb");
}

TEST(Slam, TheFrameAfterALossIsFusedAndHasItsOwnView) {
  SlamOptions options;
  options.map_period = 8;
  Slam slam({IdealRoom().camera, {}}, options, {});
  for (int i = 0; i < 4; ++i) slam.Process(IdealRoom().frames[i]);
  EXPECT_EQ(slam.Process(Blank(4)).state, FrameState::kLost);
  const FrameReport next = slam.Process(IdealRoom().frames[5]);
  EXPECT_EQ(next.state, FrameState::kTracked);
  EXPECT_TRUE(next.is_fused);
  EXPECT_TRUE(next.has_own_view);
}

}  // namespace
}  // namespace surfit
