#include "surfit/io/offered_frames.h"

#include <chrono>
#include <thread>

#include "testing/expect_input_error.h"
#include "testing/read_all.h"

namespace surfit {
namespace {

using testing::ExpectInputError;
using ::testing::HasSubstr;
using Clock = std::chrono::steady_clock;

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

TEST(OfferFrames, GivesNoneBeforeItsTime) {
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

TEST(OfferFrames, ReadsAllBeforeTheFirst) {
  auto recording = std::make_unique<NumberedSource>();
  NumberedSource* const read = recording.get();
  const auto source = OfferFrames(std::move(recording), kFps, kCount);
  EXPECT_EQ(source->Next()->index, 0);
  EXPECT_FALSE(read->Next());
}

TEST(OfferFrames, TellsWhetherTheReaderWasEarlyOrLate) {
  constexpr double kSlowly = 10;  // so that a busy machine is early, too
  const auto source = Offer(kCount, kSlowly);
  source->Next();
  EXPECT_GT(source->Next()->waited_ms, 0);
  std::this_thread::sleep_for(std::chrono::duration<double>(2.5 / kSlowly));
  const auto late = source->Next();
  EXPECT_EQ(late->waited_ms, 0);
  EXPECT_GE(late->queued_ms, 1e3 * 1.4 / kSlowly);
}

// However slow the machine is: every frame is taken or counted, and the newest are kept.
TEST(OfferFrames, DropsWhatIsNotTakenInTime) {
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
  EXPECT_EQ(testing::ReadAll(source.get()).size(), kCapacity - 1u);
}

TEST(OfferFrames, RefusesNonsense) {
  const auto offer = [](double fps, int capacity) {
    OfferFrames(std::make_unique<NumberedSource>(), fps, capacity);
  };
  ExpectInputError([&] { offer(0, 4); }, HasSubstr("frames_per_second is 0, must be positive"));
  ExpectInputError([&] { offer(30, 0); }, HasSubstr("is 0, must be at least 1"));
}

}  // namespace
}  // namespace surfit
