#include <gmock/gmock.h>
#include <sys/resource.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <future>
#include <set>
#include <thread>
#include <vector>

#include "core/background_task.h"
#include "surfit/core/error.h"
#include "testing/busy_machine.h"
#include "testing/matchers.h"

namespace surfit::testing {
namespace {

using Clock = std::chrono::steady_clock;

std::set<std::thread::id> ThreadsOfLoop() {
  std::set<std::thread::id> ids;  // no lock: the blocks run one after another
  ParallelFor(0, 64, 1, [&](int, int) {
    ids.insert(std::this_thread::get_id());
    std::this_thread::sleep_for(std::chrono::microseconds(100));
  });
  return ids;
}

TEST(LowPriorityScope, RunsLoopBlocksSequentiallyOnOneOtherThread) {
  ThreadLimit limit(4);
  LowPriorityScope spare_time;
  std::thread([&] {
    std::set<std::thread::id> ids;
    spare_time.Run([&] { ids = ThreadsOfLoop(); });
    EXPECT_EQ(ids.size(), 1u);
    EXPECT_EQ(ids.count(std::this_thread::get_id()), 0u);
  }).join();
}

TEST(LowPriorityScope, RunsNestedLoops) {
  ThreadLimit limit(2);
  LowPriorityScope spare_time;
  std::atomic<int> count = 0;
  spare_time.Run([&] {
    ParallelFor(0, 8, 1, [&](int, int) { ParallelFor(0, 8, 1, [&](int, int) { ++count; }); });
  });
  EXPECT_EQ(count, 64);
}

#ifdef __linux__
TEST(LowPriorityScope, LowersPriorityInsideLoopsOnly) {
  ThreadLimit limit(2);
  const int before = getpriority(PRIO_PROCESS, 0);
  std::thread([&] {
    LowPriorityScope spare_time;
    int of_task = -1, after = -1;
    std::set<int> of_loop;
    spare_time.Run([&] {
      of_task = getpriority(PRIO_PROCESS, 0);
      ParallelFor(0, 8, 1, [&](int, int) { of_loop.insert(getpriority(PRIO_PROCESS, 0)); });
      after = getpriority(PRIO_PROCESS, 0);
    });
    EXPECT_EQ(of_task, before);
    EXPECT_THAT(of_loop, ElementsAre(19));
    EXPECT_EQ(after, before);
  }).join();
}

TEST(LowPriorityScope, AwaitRestoresPriorityOfLoops) {
  ThreadLimit limit(2);
  const int before = getpriority(PRIO_PROCESS, 0);
  LowPriorityScope spare_time;
  std::promise<void> in_loop;
  std::vector<int> of_loop(64), of_next_loop(64);
  auto task = std::async(std::launch::async, [&] {
    spare_time.Run([&] {
      ParallelFor(0, 64, 1, [&](int i, int) {
        if (i == 0) in_loop.set_value();
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
        of_loop[i] = getpriority(PRIO_PROCESS, 0);
      });
      ParallelFor(0, 64, 1, [&](int i, int) { of_next_loop[i] = getpriority(PRIO_PROCESS, 0); });
    });
  });
  in_loop.get_future().wait();
  spare_time.Await();
  task.get();
  EXPECT_EQ(of_loop.front(), 19);
  EXPECT_EQ(of_loop.back(), before);
  EXPECT_THAT(of_next_loop, Each(before));
}
#endif

// A thread of the lowest priority gets 1/70 of the time of a normal thread. A caller that waited
// for it would wait 70 times longer than for a normal thread.
TEST(BackgroundTask, TakeDoesNotWaitAtLowestPriorityOnBusyMachine) {
  ThreadLimit limit(2);
  const auto work = [] {
    for (int loop = 0; loop < 20; ++loop) ParallelFor(0, 20, 1, [](int, int) { Compute(0.5); });
    return 0;
  };
  const auto seconds = [&](const auto& run) {
    const auto start = Clock::now();
    run();
    return std::chrono::duration<double>(Clock::now() - start).count();
  };
  const BusyMachine busy;
  const double own_s = seconds([&] { std::async(std::launch::async, work).get(); });
  const double waited_s = seconds([&] {
    BackgroundTask<int> task;
    task.Start(1, work);
    task.Take();
  });
  EXPECT_LT(waited_s, 5 * own_s + 1);
}

TEST(LowPriorityScope, RethrowsExceptionOfTask) {
  ThreadLimit limit(2);
  EXPECT_THROW(LowPriorityScope().Run([] { throw InputError("bad"); }), InputError);
  EXPECT_THROW(LowPriorityScope().Run([] {
    ParallelFor(0, 8, 1, [](int i, int) {
      if (i == 3) throw InputError("bad");
    });
  }),
               InputError);
}

TEST(BackgroundTask, DestructorWaitsForTask) {
  ThreadLimit limit(2);
  std::atomic<bool> done = false;
  {
    BackgroundTask<int> task;
    task.Start(1, [&] {
      ParallelFor(0, 8, 1,
                  [](int, int) { std::this_thread::sleep_for(std::chrono::milliseconds(1)); });
      done = true;
      return 0;
    });
  }
  EXPECT_TRUE(done);
}

TEST(BackgroundTask, IsDueAfterItsStepsAtAnyNumberOfThreads) {
  for (const int threads : {1, 2}) {
    ThreadLimit limit(threads);
    BackgroundTask<int> task;
    EXPECT_FALSE(task.IsDueAfterStep());
    task.Start(2, [] { return 7; });
    EXPECT_TRUE(task.IsPending());
    EXPECT_FALSE(task.IsDueAfterStep());
    EXPECT_TRUE(task.IsDueAfterStep());
    EXPECT_EQ(task.Take(), 7);
    EXPECT_FALSE(task.IsPending() || task.IsDueAfterStep());
  }
}

TEST(BackgroundTask, RunsInBackgroundWithTwoThreads) {
  ThreadLimit limit(2);
  std::promise<void> go_on;
  BackgroundTask<std::thread::id> task;
  task.Start(1, [&] {
    go_on.get_future().wait();
    return std::this_thread::get_id();
  });
  EXPECT_TRUE(task.IsAtWork());
  go_on.set_value();
  task.Wait();
  EXPECT_FALSE(task.IsAtWork());
  EXPECT_NE(task.Take(), std::this_thread::get_id());
}

TEST(BackgroundTask, RunsInTakeWithOneThread) {
  ThreadLimit limit(1);
  BackgroundTask<std::thread::id> task;
  task.Start(1, [] { return std::this_thread::get_id(); });
  EXPECT_FALSE(task.IsAtWork());
  EXPECT_EQ(task.Take(), std::this_thread::get_id());
}

TEST(BackgroundTask, RunsInBackgroundWithOneThreadIfAlwaysBeside) {
  ThreadLimit limit(1);
  BackgroundTask<std::thread::id> task(/*always_in_background=*/true);
  task.Start(1, [] {
    ParallelFor(0, 8, 1, [](int, int) { Compute(0.5); });
    return std::this_thread::get_id();
  });
  EXPECT_NE(task.Take(), std::this_thread::get_id());
}

TEST(BackgroundTask, LateResultIsThereAfterTaskEnds) {
  for (const int threads : {1, 2}) {
    ThreadLimit limit(threads);
    std::promise<void> go_on;
    BackgroundTask<int> task(/*always_in_background=*/true);
    EXPECT_FALSE(task.IsReady() || task.IsReadyAfterStep());
    task.Start(2, [&] {
      go_on.get_future().wait();
      ParallelFor(0, 8, 1, [](int, int) { Compute(0.5); });
      return 7;
    });
    for (int i = 0; i < 5; ++i) EXPECT_FALSE(task.IsReady() || task.IsReadyAfterStep());
    go_on.set_value();
    task.Wait();
    EXPECT_TRUE(task.IsReady() && task.IsReadyAfterStep());
    EXPECT_EQ(task.Take(), 7);
  }
}

TEST(BackgroundTask, ResultIsNotThereBeforeItsSteps) {
  BackgroundTask<int> task(/*always_in_background=*/true);
  task.Start(2, [] { return 7; });
  task.Wait();
  EXPECT_FALSE(task.IsReadyAfterStep());
  EXPECT_TRUE(task.IsReadyAfterStep());
}

TEST(BackgroundTask, RethrowsExceptionOfTask) {
  BackgroundTask<int> task;
  task.Start(1, []() -> int { throw InputError("bad"); });
  EXPECT_THROW(task.Take(), InputError);
}

}  // namespace
}  // namespace surfit::testing
