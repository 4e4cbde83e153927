#include "core/trace.h"

#include <gtest/gtest.h>

#include <thread>

#include "testing/matchers.h"
#include "testing/temp_folder.h"
#include "testing/trace_slices.h"

namespace surfit::testing {
namespace {

TEST(Trace, ContainsSlicesOfEachThread) {
  const TempFolder folder;
  const std::string path = folder / "trace.json";
  {
    const TraceRecorder recorder(path);
    const TraceSlice outer("outer", 7);
    { const TraceSlice inner("inner", 7); }
    std::thread([] { const TraceSlice other("other"); }).join();
  }
  const std::vector<Slice> slices = ReadSlices(path);
  ASSERT_EQ(slices.size(), 3u);
  const Slice &inner = slices[0], &other = slices[1], &outer = slices[2];
  EXPECT_EQ(inner.name, "inner");
  EXPECT_EQ(inner.frame, 7);
  EXPECT_EQ(inner.thread, outer.thread);
  EXPECT_EQ(other.name, "other");
  EXPECT_EQ(other.frame, TraceSlice::kNoFrame);
  EXPECT_NE(other.thread, outer.thread);
  EXPECT_EQ(outer.name, "outer");
  EXPECT_LE(outer.begin_ns, inner.begin_ns);
  EXPECT_LE(inner.end_ns, other.begin_ns);
  EXPECT_LE(other.end_ns, outer.end_ns);
  ExpectNesting(slices);
}

TEST(Trace, RecordsOnlyBetweenConstructionAndClose) {
  const TempFolder folder;
  const std::string path = folder / "trace.json";
  { const TraceSlice before("before"); }
  TraceRecorder recorder(path);
  { const TraceSlice within("within"); }
  recorder.Close();
  { const TraceSlice after("after"); }
  const std::vector<Slice> slices = ReadSlices(path);
  ASSERT_EQ(slices.size(), 1u);
  EXPECT_EQ(slices[0].name, "within");
}

TEST(Trace, RecordsAllSlicesOfManyThreads) {
  const TempFolder folder;
  const std::string path = folder / "trace.json";
  {
    const TraceRecorder recorder(path);
    std::vector<std::thread> threads;
    threads.reserve(4);
    for (int i = 0; i < 4; ++i) {
      threads.emplace_back([] {
        for (int frame = 0; frame < 100; ++frame) const TraceSlice slice("slice", frame);
      });
    }
    for (std::thread& thread : threads) thread.join();
  }
  const std::vector<Slice> slices = ReadSlices(path);
  EXPECT_EQ(slices.size(), 400u);
  ExpectNesting(slices);
}

TEST(Trace, RejectsFileThatCannotBeWritten) {
  ExpectInputError([] { const TraceRecorder recorder("/dev/null/trace.json"); },
                   Names("/dev/null/trace.json"));
  // After a failed recorder, a new recorder can start.
  const TempFolder folder;
  const TraceRecorder recorder(folder / "trace.json");
}

TEST(StageTimer, AddsTimeWithoutRecorder) {
  double sum_ms = 5;
  {
    const StageTimer timer("stage", 0, &sum_ms);
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  EXPECT_GE(sum_ms, 7);
}

}  // namespace
}  // namespace surfit::testing
