#include "run/map_period.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace surfit {
namespace {

constexpr double kGap_ms = 1000. / 30;

// Result of frames at sensor rate, with fixed times for tracking and fusion of a frame.
struct Offered {
  double longest_wait_ms = 0;
  int last_period = 0;
  int changes = 0;
};
Offered Offer(int frames, double track_ms, double fuse_ms, MapPeriod* period, double* free_at_ms) {
  Offered result;
  int unfused = 0;
  for (int i = 0; i < frames; ++i) {
    const double offered_ms = i * kGap_ms, waited_ms = std::max(0., *free_at_ms - offered_ms);
    const int now = period->For(waited_ms);
    if (i > 0 && now != result.last_period) ++result.changes;
    result.last_period = now;
    result.longest_wait_ms = std::max(result.longest_wait_ms, waited_ms);
    const bool fuses = ++unfused >= now;
    if (fuses) unfused = 0;
    *free_at_ms = offered_ms + waited_ms + track_ms + (fuses ? fuse_ms : 0);
  }
  *free_at_ms -= frames * kGap_ms;
  return result;
}

TEST(MapPeriod, IsConstantWhileFramesAreInTime) {
  MapPeriod period(2);
  double free_at_ms = 0;
  EXPECT_EQ(Offer(1000, 15, 30, &period, &free_at_ms).changes, 0);
  EXPECT_EQ(period.frames_with_longer_map_period(), 0);
  EXPECT_EQ(period.longest(), 2);
}

// One slow frame, for example with a map correction, does not change the period.
TEST(MapPeriod, IsConstantAfterOneLateFrame) {
  MapPeriod period(2);
  for (int i = 0; i < 20; ++i) {
    for (double waited_ms : {0., 90., 68., 35., 5., 0., 0.}) EXPECT_EQ(period.For(waited_ms), 2);
  }
}

TEST(MapPeriod, ReturnsToTheInitialPeriodDespiteSomeSlowFrames) {
  MapPeriod period(2);
  for (int i = 0; i < 10; ++i) period.For(200);
  EXPECT_GT(period.For(200), 2);
  int last = 0;
  for (int i = 0; i < 900; ++i) last = period.For(i % 40 < 2 ? 90 : 0);
  EXPECT_EQ(last, 2);
}

// The queue holds eight frames.
TEST(MapPeriod, IncreasesBeforeAFrameIsDropped) {
  MapPeriod period(2);
  double free_at_ms = 0;
  const Offered offered = Offer(3000, 25, 50, &period, &free_at_ms);
  EXPECT_LT(offered.longest_wait_ms, 8 * kGap_ms);
  EXPECT_GE(period.longest(), 8);
  EXPECT_GT(period.frames_with_longer_map_period(), 2700);
  EXPECT_LT(offered.changes, 60);  // no oscillation
}

TEST(MapPeriod, ReturnsToTheInitialPeriodWhenFramesAreFast) {
  MapPeriod period(2);
  double free_at_ms = 0;
  EXPECT_GT(Offer(300, 25, 50, &period, &free_at_ms).last_period, 2);
  EXPECT_EQ(Offer(3000, 10, 20, &period, &free_at_ms).last_period, 2);
}

TEST(MapPeriod, IncreasesAtMostEightfold) {
  MapPeriod period(3);
  for (int i = 0; i < 1000; ++i) period.For(1000);
  EXPECT_EQ(period.longest(), 24);
}

}  // namespace
}  // namespace surfit
