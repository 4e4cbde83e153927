#include <atomic>
#include <chrono>
#include <stdexcept>
#include <thread>

#include "surfit/core/parallel.h"
#include "surfit/frame/frame_source.h"
#include "surfit/io/sequence.h"
#include "testing/matchers.h"
#include "testing/sequence_writer.h"

namespace surfit::testing {
namespace {

using Clock = std::chrono::steady_clock;

TEST(ReadAhead, ReturnsTheSameFramesAtAnyNumberOfThreads) {
  TempFolder folder;
  WriteTumSequence(folder, 20);
  WriteBytes(folder / "depth/007.png", "broken");
  const SequenceOptions options = Options(folder);
  const auto expected = ReadAll(OpenSequence(options).get());
  for (const int threads : {1, 2, 4}) {
    ThreadLimit limit(threads);
    for (const int capacity : {1, 3, 100}) {
      const auto source = ReadAhead(OpenSequence(options), capacity);
      EXPECT_EQ(source->info().frame_count, 20);
      const auto results = ReadAll(source.get());
      ASSERT_EQ(results.size(), expected.size());
      for (std::size_t i = 0; i < results.size(); ++i) {
        EXPECT_EQ(results[i].index, expected[i].index);
        EXPECT_EQ(results[i].stamp_s, expected[i].stamp_s);
        EXPECT_EQ(results[i].error, expected[i].error);
        ASSERT_EQ(results[i].frame.has_value(), expected[i].frame.has_value());
        if (!results[i].frame) continue;
        EXPECT_EQ(results[i].frame->depth_m, expected[i].frame->depth_m);
        EXPECT_EQ(results[i].frame->color, expected[i].frame->color);
      }
      EXPECT_FALSE(source->Next());
    }
  }
}

TEST(OpenLive, RejectsAnEmptyQueue) {
  const TempFolder folder;
  SequenceOptions options = Options(folder);
  const std::atomic<bool> stop{true};
  for (const char* const format : {"watch", "openni2"}) {
    options.format = format;
    for (const int capacity : {0, -1}) {
      ExpectInputError([&] { OpenLive(options, capacity, stop); },
                       HasSubstr(Concat("capacity is ", capacity, ", must be at least 1")));
    }
  }
}

// Counts the calls of Next(). It fails on concurrent calls, and throws at frame `bad`.
class CountingSource : public FrameSource {
 public:
  CountingSource(int count, int bad, std::atomic<int>* reads)
      : count_(count), bad_(bad), reads_(reads) {}
  const SequenceInfo& info() const override { return info_; }
  std::optional<ReadResult> Next() override {
    EXPECT_FALSE(busy_.exchange(true));
    std::this_thread::sleep_for(std::chrono::microseconds(200));
    busy_ = false;
    if (next_ == count_) return std::nullopt;
    ++*reads_;
    if (next_ == bad_) throw std::runtime_error("disk on fire");
    ReadResult result;
    result.index = next_++;
    return result;
  }

 private:
  SequenceInfo info_;
  int count_, bad_, next_ = 0;
  std::atomic<bool> busy_ = false;
  std::atomic<int>* reads_;
};

TEST(ReadAhead, RethrowsAnExceptionAtItsFrame) {
  for (const int threads : {1, 2, 4}) {
    ThreadLimit limit(threads);
    std::atomic<int> reads = 0;
    const auto source = ReadAhead(std::make_unique<CountingSource>(10, 3, &reads), 5);
    for (int i = 0; i < 3; ++i) EXPECT_EQ(source->Next()->index, i);
    EXPECT_THROW(source->Next(), std::runtime_error);
    EXPECT_FALSE(source->Next());
    EXPECT_EQ(reads, 4);
  }
}

void WaitUntil(const std::atomic<int>& reads, int count) {
  const auto limit = std::chrono::steady_clock::now() + std::chrono::seconds(10);
  while (reads < count && std::chrono::steady_clock::now() < limit) std::this_thread::yield();
}

TEST(ReadAhead, ReadsAtMostItsCapacityAhead) {
  ThreadLimit limit(2);
  std::atomic<int> reads = 0;
  const auto source = ReadAhead(std::make_unique<CountingSource>(100, -1, &reads), 4);
  EXPECT_EQ(reads, 0);  // no frame is read before the first call
  source->Next();
  WaitUntil(reads, 5);
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_EQ(reads, 5);  // one frame returned, four buffered
  source->Next();
  WaitUntil(reads, 6);
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_EQ(reads, 6);
}

TEST(ReadAhead, WithOneThreadReadsOnDemand) {
  ThreadLimit limit(1);
  std::atomic<int> reads = 0;
  const auto source = ReadAhead(std::make_unique<CountingSource>(100, -1, &reads), 4);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(source->Next()->index, i);
    EXPECT_EQ(reads, i + 1);
  }
}

TEST(ReadAhead, CanBeDestroyedAtAnyTime) {
  ThreadLimit limit(2);
  for (int taken = 0; taken < 50; ++taken) {
    std::atomic<int> reads = 0;
    const auto source = ReadAhead(std::make_unique<CountingSource>(20, -1, &reads), 3);
    for (int i = 0; i < taken % 25; ++i) source->Next();
  }
}

TEST(ReadAhead, RejectsZeroCapacity) {
  std::atomic<int> reads = 0;
  ExpectInputError([&] { ReadAhead(std::make_unique<CountingSource>(1, -1, &reads), 0); },
                   Names(0));
}

constexpr int kCount = 12;
constexpr double kFps = 100;

class NumberedSource final : public FrameSource {
 public:
  NumberedSource() { info_.frame_count = kCount; }
  const SequenceInfo& info() const override { return info_; }
  std::optional<ReadResult> Next() override {
    if (next_ == kCount) return std::nullopt;
    ReadResult result;
    result.index = next_++;
    return result;
  }

 private:
  SequenceInfo info_;
  int next_ = 0;
};

std::unique_ptr<FrameSource> Offer(int capacity, double fps = kFps) {
  return OfferFrames(std::make_unique<NumberedSource>(), fps, capacity);
}

double SecondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

TEST(OfferFrames, ReturnsNoFrameBeforeItsTime) {
  const auto source = Offer(kCount);
  const Clock::time_point start = Clock::now();
  for (int i = 0; i < kCount; ++i) {
    const auto result = source->Next();
    ASSERT_TRUE(result);
    EXPECT_EQ(result->index, i);
    EXPECT_EQ(result->dropped_before, 0);
    EXPECT_GE(SecondsSince(start), i / kFps);
    EXPECT_GE(result->queued_ms, 0);
  }
  EXPECT_FALSE(source->Next());
}

// The memory does not depend on the number of frames.
TEST(OfferFrames, ReadsAtMostThirtyFramesAhead) {
  ThreadLimit limit(2);
  std::atomic<int> reads = 0;
  const auto source = OfferFrames(std::make_unique<CountingSource>(200, -1, &reads), kFps, 1000);
  EXPECT_EQ(source->Next()->index, 0);
  WaitUntil(reads, 31);
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_EQ(reads, 31);  // one frame returned, thirty buffered
}

TEST(OfferFrames, ReportsEarlyAndLateReaders) {
  constexpr double kSlowly = 10;  // early even on a slow machine
  const auto source = Offer(kCount, kSlowly);
  source->Next();
  EXPECT_GT(source->Next()->waited_ms, 0);
  std::this_thread::sleep_for(std::chrono::duration<double>(2.5 / kSlowly));
  const auto late = source->Next();
  EXPECT_EQ(late->waited_ms, 0);
  EXPECT_GE(late->queued_ms, 1e3 * 1.4 / kSlowly);
}

// Every frame is returned or counted as dropped, and the newest frames are kept, at any machine
// speed.
TEST(OfferFrames, DropsLateFrames) {
  constexpr int kCapacity = 3;
  const auto source = Offer(kCapacity);
  EXPECT_EQ(source->Next()->index, 0);
  std::this_thread::sleep_for(std::chrono::duration<double>(7.5 / kFps));
  auto result = source->Next();
  ASSERT_TRUE(result);
  EXPECT_GE(result->dropped_before, 7 - kCapacity);
  int next = 1;
  for (; result; result = source->Next()) {
    next += result->dropped_before;
    EXPECT_EQ(result->index, next++);
  }
  EXPECT_EQ(next, kCount);
}

TEST(OfferFrames, KeepsTheLastFrames) {
  constexpr int kCapacity = 3;
  const auto source = Offer(kCapacity);
  source->Next();
  std::this_thread::sleep_for(std::chrono::duration<double>(2 * kCount / kFps));
  EXPECT_EQ(source->Next()->index, kCount - kCapacity);
  EXPECT_EQ(ReadAll(source.get()).size(), kCapacity - 1u);
}

TEST(OfferFrames, RejectsBadRateAndCapacity) {
  const auto offer = [](double fps, int capacity) {
    OfferFrames(std::make_unique<NumberedSource>(), fps, capacity);
  };
  ExpectInputError([&] { offer(0, 4); }, Names("frames_per_second", 0));
  ExpectInputError([&] { offer(30, 0); }, Names(0, 1));
}

}  // namespace
}  // namespace surfit::testing
