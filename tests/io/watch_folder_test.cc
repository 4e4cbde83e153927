#include <thread>

#include "surfit/io/sequence.h"
#include "testing/matchers.h"
#include "testing/sequence_writer.h"

namespace surfit::testing {
namespace {

class WatchTest : public ::testing::Test {
 protected:
  WatchTest() {
    folder_.Write("camera.yaml", SmallCameraYaml());
    std::filesystem::create_directory(folder_ / "depth");
    std::filesystem::create_directory(folder_ / "color");
    options_.path = folder_.path();
    options_.format = "watch";
  }
  std::string DepthPath(int i) { return folder_ / Format("depth/%06d.png", i); }
  std::string ColorPath(int i) { return folder_ / Format("color/%06d.png", i); }
  void WriteFrame(int i) {
    WriteColor(ColorPath(i), NumberedColor(i));
    WriteDepth(DepthPath(i), NumberedDepth(i));
  }
  std::vector<ReadResult> ReadToTheEnd() { return ReadAll(WatchFolder(options_, stop_).get()); }
  TempFolder folder_;
  SequenceOptions options_;
  std::atomic<bool> stop_{false};
};

// Each frame is written after the previous frame has been read.
TEST_F(WatchTest, ReturnsFramesInOrderOfArrival) {
  WriteFrame(0);
  const auto source = WatchFolder(options_, stop_);
  EXPECT_EQ(source->info().frame_count, -1);
  EXPECT_EQ(source->info().pinhole.width, 32);
  for (const int i : {0, 1, 3}) {
    if (i > 0) WriteFrame(i);
    const auto result = source->Next();
    ASSERT_TRUE(result && result->frame) << result->error;
    EXPECT_EQ(result->frame->color, NumberedColor(i));
    EXPECT_FLOAT_EQ(result->frame->depth_m(1, 0), 1.001f + 0.01f * i);
    EXPECT_DOUBLE_EQ(result->stamp_s, i / 30.);
    EXPECT_EQ(result->index, i == 3 ? 2 : i);
  }
  folder_.Write("done", "");
  EXPECT_FALSE(source->Next());
}

// The colour file is written in two pieces after depth. Frame 1 is then written at once.
TEST_F(WatchTest, WaitsForIncompleteFiles) {
  WriteFrame(0);
  const std::string bytes = ReadBytes(ColorPath(0));
  WriteBytes(ColorPath(0), bytes.substr(0, 40));
  std::thread writer([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    WriteFrame(1);
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    WriteBytes(ColorPath(0), bytes);
    folder_.Write("done", "");
  });
  const auto results = ReadToTheEnd();
  writer.join();
  ASSERT_EQ(results.size(), 2u);
  for (int i = 0; i < 2; ++i) {
    ASSERT_TRUE(results[i].frame) << results[i].error;
    EXPECT_EQ(results[i].frame->color, NumberedColor(i));
  }
}

TEST_F(WatchTest, SkipsFramesThatStayDamaged) {
  for (const int i : {0, 2, 4}) WriteFrame(i);
  std::filesystem::remove(ColorPath(2));
  const auto source = WatchFolder(options_, stop_);
  EXPECT_TRUE(source->Next()->frame);
  const auto broken = source->Next();  // after a timeout of 2 s
  EXPECT_THAT(broken->error, Names("color/000002.png"));
  EXPECT_TRUE(source->Next()->frame);
  WriteFrame(3);
  EXPECT_THAT(source->Next()->error, Names("depth/000003.png", 4));
}

TEST_F(WatchTest, AppliesFirstLastAndStride) {
  for (int i = 0; i < 6; ++i) WriteFrame(10 * i);
  folder_.Write("done", "");
  options_.first = 1;
  options_.stride = 2;
  options_.last = 4;
  const auto results = ReadToTheEnd();
  ASSERT_EQ(results.size(), 2u);
  EXPECT_EQ(results[0].index, 1);
  EXPECT_EQ(results[1].frame->color, NumberedColor(30));
}

TEST_F(WatchTest, ReadsDepthWithoutAColourFolder) {
  std::filesystem::remove(folder_ / "color");
  WriteDepth(DepthPath(0), NumberedDepth(0));
  folder_.Write("done", "");
  const auto results = ReadToTheEnd();
  ASSERT_EQ(results.size(), 1u);
  EXPECT_TRUE(results[0].frame->color.empty());
}

TEST_F(WatchTest, StopsOnRequest) {
  WriteFrame(0);
  const auto source = WatchFolder(options_, stop_);
  EXPECT_TRUE(source->Next());
  std::thread stopper([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    stop_ = true;
  });
  EXPECT_FALSE(source->Next());
  stopper.join();
}

TEST_F(WatchTest, RejectsFoldersWithoutFrames) {
  folder_.Write("done", "");
  ExpectInputError([&] { ReadToTheEnd(); }, Names(folder_.path()));
  WriteBytes(DepthPath(0), "broken");
  WriteColor(ColorPath(0), NumberedColor(0));
  ExpectInputError([&] { ReadToTheEnd(); }, Names("depth/000000.png"));
  ExpectInputError([&] { OpenSequence(options_); }, Names("watch"));
  options_.path = "/nowhere";
  ExpectInputError([&] { ReadToTheEnd(); }, Names("/nowhere"));
}

}  // namespace
}  // namespace surfit::testing
