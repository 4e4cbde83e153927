#include "apps/live/live_run.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <utility>

#include "live/live_fixture.h"

namespace surfit {
namespace {

// Counts the calls of the run, and calls a function during pauses.
class CountingViewer : public RunViewer {
 public:
  struct Counts {
    int shown = 0, waited = 0, work = 0, kept = 0, stayed = 0;
  };
  CountingViewer(Counts* counts, std::function<void()> wait)
      : counts_(*counts), wait_(std::move(wait)) {}

  void Show(const SlamRunFrame&) override { ++counts_.shown; }
  void Wait(const SlamRunFrame&, int) override {
    ++counts_.waited;
    wait_();
  }
  void ShowWork() override { ++counts_.work; }
  void Keep(const SlamRunResult&) override { ++counts_.kept; }
  void Stay() override { ++counts_.stayed; }

 private:
  Counts& counts_;
  std::function<void()> wait_;
};

class LiveRunTest : public testing::Test {
 protected:
  LiveRunTest() {
    run_.Add(std::make_unique<CountingViewer>(&counts_, [this] { wait_(); }));
  }

  LiveFixture live_;
  int interruptions_ = 0;
  LiveRun run_{live_.interrupted_, [this] {
                 ++interruptions_;
                 live_.interrupted_ = true;
               }};
  CountingViewer::Counts counts_;
  std::function<void()> wait_ = [] {};
};

TEST_F(LiveRunTest, ReportsEachFrameToViewersAndContinues) {
  for (int i = 0; i < 5; ++i) live_.Tell(&run_);
  EXPECT_EQ(counts_.shown, 5);
  EXPECT_EQ(counts_.waited, 0);
  EXPECT_EQ(run_.path().size(), 5u);
  EXPECT_EQ(run_.progress().frames_done, 5);
  EXPECT_THAT(run_.Status(), testing::ContainsRegex("5/100 .*tracked"));
}

TEST_F(LiveRunTest, PausesUntilContinued) {
  run_.Pause();
  wait_ = [this] {
    EXPECT_TRUE(run_.is_paused());
    if (counts_.waited == 3) run_.GoOn();
  };
  live_.Tell(&run_);
  EXPECT_EQ(counts_.waited, 3);
  live_.Tell(&run_);
  EXPECT_EQ(counts_.waited, 3);
}

TEST_F(LiveRunTest, StepsOneFrame) {
  run_.Pause();
  wait_ = [this] { run_.Step(); };
  live_.Tell(&run_);
  EXPECT_EQ(counts_.waited, 1);
  EXPECT_TRUE(run_.is_paused());
  live_.Tell(&run_);
  EXPECT_EQ(counts_.waited, 2);
}

TEST_F(LiveRunTest, StopsOnceAndEndsAPause) {
  run_.Pause();
  wait_ = [this] {
    run_.Stop();
    run_.Stop();
  };
  live_.Tell(&run_);
  EXPECT_EQ(interruptions_, 1);
  run_.Stop();
  EXPECT_EQ(interruptions_, 1);
}

TEST_F(LiveRunTest, DoesNotStopAnInterruptedRun) {
  live_.interrupted_ = true;
  run_.Stop();
  EXPECT_EQ(interruptions_, 0);
}

TEST_F(LiveRunTest, StoresTheLastPose) {
  live_.Tell(&run_);
  live_.report_.state = FrameState::kLost;
  live_.frame_.color = Image<Rgb8>(160, 120, Rgb8{});
  live_.Tell(&run_);
  EXPECT_TRUE(run_.is_lost());
  EXPECT_EQ(run_.path().size(), 1u);
  EXPECT_EQ(run_.last_good()[0], (Rgb8{200, 120, 40}));
  EXPECT_EQ(run_.advice().at(0).kind, "lost");
}

TEST_F(LiveRunTest, KeepsTheResultAndWaits) {
  live_.Tell(&run_);
  SlamRunProgress progress = live_.Progress(nullptr);
  progress.frames_reintegrated = 1;
  run_.Update(progress);
  EXPECT_EQ(counts_.work, 1);
  EXPECT_TRUE(run_.is_at_result());
  run_.Pause();
  EXPECT_FALSE(run_.is_paused());
  run_.Stay();
  EXPECT_EQ(counts_.stayed, 0);
  run_.Keep({live_.map_, {{0, Rigid3d()}, {1, Rigid3d()}}});
  run_.Stay();
  EXPECT_EQ(counts_.kept, 1);
  EXPECT_EQ(counts_.stayed, 1);
  EXPECT_EQ(run_.path().size(), 2u);
  EXPECT_EQ(run_.Status(), "done");
}

TEST(RateLimiter, ActsAtOnceAndThenAtMostAtItsRate) {
  RateLimiter pace(1000, 0.5);
  int acts = 0;
  for (int i = 0; i < 3; ++i) pace.ActIfDue(false, [&] { ++acts; });
  EXPECT_EQ(acts, 1);
  pace.ActIfDue(true, [&] { ++acts; });
  EXPECT_EQ(acts, 2);
}

// A slow task is repeated after a pause that keeps its ratio of time.
TEST(RateLimiter, UsesAtMostItsRatioOfTime) {
  using Clock = std::chrono::steady_clock;
  RateLimiter pace(0, 0.1);
  std::vector<Clock::time_point> begins;
  std::vector<Clock::duration> took;
  while (begins.size() < 4) {
    pace.ActIfDue(false, [&] {
      begins.push_back(Clock::now());
      while (Clock::now() - begins.back() < std::chrono::milliseconds(3)) {
      }
      took.push_back(Clock::now() - begins.back());
    });
  }
  for (std::size_t i = 1; i < begins.size(); ++i) {
    EXPECT_GE(begins[i] - begins[i - 1], 99 * took[i - 1] / 10);
  }
}

}  // namespace
}  // namespace surfit
