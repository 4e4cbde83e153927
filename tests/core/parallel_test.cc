#include "surfit/core/parallel.h"

#include <gmock/gmock.h>

#include <atomic>
#include <chrono>
#include <future>
#include <memory>
#include <numeric>
#include <opencv2/core/utility.hpp>
#include <random>
#include <thread>

#include "surfit/core/error.h"
#include "testing/matchers.h"
#include "testing/threads.h"

namespace surfit::testing {
namespace {

std::vector<float> RandomNumbers(int count) {
  std::mt19937_64 rng(1);
  std::normal_distribution<float> normal(0.f, 1e3f);
  std::vector<float> numbers(count);
  for (float& number : numbers) number = normal(rng);
  return numbers;
}

TEST(ParallelFor, CoversRangeOnceInBlocksOfGrainSize) {
  ThreadLimit limit(4);
  std::vector<int> visits(1003, 0);
  ParallelFor(3, 1003, 64, [&](int begin, int end) {
    EXPECT_EQ((begin - 3) % 64, 0);
    EXPECT_LE(end - begin, 64);
    for (int i = begin; i < end; ++i) ++visits[i];
  });
  EXPECT_EQ(std::accumulate(visits.begin(), visits.begin() + 3, 0), 0);
  EXPECT_THAT(std::vector<int>(visits.begin() + 3, visits.end()), Each(1));
}

TEST(ParallelFor, SkipsEmptyRange) {
  ParallelFor(5, 5, 1, [](int, int) { FAIL(); });
}

TEST(ParallelSum, IsBitwiseIdenticalAtAnyNumberOfThreads) {
  const std::vector<float> numbers = RandomNumbers(100003);
  const auto sums = AtThreads({1, 2, 4}, [&] {
    return ParallelSum(0, 100003, 100, 0.f, [&](int begin, int end) {
      return std::accumulate(numbers.begin() + begin, numbers.begin() + end, 0.f);
    });
  });
  EXPECT_EQ(sums[0], sums[1]);
  EXPECT_EQ(sums[0], sums[2]);
}

TEST(ThreadLimit, LimitsThreadsOfLoop) {
  ThreadLimit limit(2);
  EXPECT_EQ(ThreadCount(), 2);
  std::atomic<int> running = 0, most = 0;
  ParallelFor(0, 64, 1, [&](int, int) {
    const int now = ++running;
    int seen = most;
    while (now > seen && !most.compare_exchange_weak(seen, now)) {
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    --running;
  });
  EXPECT_LE(most, 2);
}

TEST(ThreadLimit, LimitsOpenCvToOneThreadAndRestoresItsNumber) {
  cv::setNumThreads(2);
  ASSERT_EQ(cv::getNumThreads(), 2);
  auto first = std::make_unique<ThreadLimit>(2), second = std::make_unique<ThreadLimit>(1);
  EXPECT_EQ(cv::getNumThreads(), 1);
  first.reset();
  EXPECT_EQ(cv::getNumThreads(), 1);
  second.reset();
  EXPECT_EQ(cv::getNumThreads(), 2);
  EXPECT_THROW(ThreadLimit(0), InputError);
  EXPECT_EQ(cv::getNumThreads(), 2);
}

TEST(ThreadLimit, RejectsInvalidThreadCount) {
  EXPECT_THROW(ThreadLimit(0), InputError);
  EXPECT_THROW(ThreadLimit(-3), InputError);
  EXPECT_THROW(ThreadLimit(100000), InputError);
}

TEST(RunInBackground, RunsOnAnotherThread) {
  ThreadLimit limit(2);
  std::promise<std::thread::id> id;
  RunInBackground([&] { id.set_value(std::this_thread::get_id()); });
  EXPECT_NE(id.get_future().get(), std::this_thread::get_id());
}

}  // namespace
}  // namespace surfit::testing
