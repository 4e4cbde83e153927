// Cameras and recordings of OpenNI2, with the real library and a virtual camera.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <fstream>
#include <memory>
#include <thread>

#include "io/sequences/record.h"
#include "surfit/io/sequence.h"
#include "testing/matchers.h"
#include "testing/openni/virtual_camera.h"
#include "testing/sequence_writer.h"
#include "testing/temp_folder.h"

namespace surfit::testing {
namespace {

std::vector<FilmFrame> NumberedFilm(int count) {
  std::vector<FilmFrame> film;
  for (int i = 0; i < count; ++i)
    film.push_back(FilmFrameOf(i, NumberedDepth(i), NumberedColor(i)));
  return film;
}

SequenceOptions CameraOptions() {
  SequenceOptions options = OptionsOf("any");
  options.format = "openni2";
  options.device_width = 32;
  options.device_height = 24;
  options.openni2_library = VirtualCamera::library();
  return options;
}

SequenceOptions OniOptions(const std::string& path) {
  SequenceOptions options = OptionsOf(path);
  options.openni2_library = VirtualCamera::library();
  return options;
}

// Frame number from the timestamp. Also valid without colour.
int NumberByStamp(const ReadResult& result) {
  return static_cast<int>(std::lround(30 * result.stamp_s));
}

// Frame number from the red value of NumberedColor().
int NumberOf(const ReadResult& result) { return result.frame->color[0].r; }

class OpenNiCamera : public ::testing::Test {
 protected:
  std::unique_ptr<FrameSource> Open(const SequenceOptions& options, int capacity = 1000) {
    return OpenLive(options, capacity, stop_);
  }
  std::atomic<bool> stop_{false};
};

TEST_F(OpenNiCamera, ReturnsFramesAndFieldOfView) {
  std::vector<FilmFrame> film = NumberedFilm(60);
  for (FilmFrame& frame : film) frame.color_us += 4000;
  CameraScript script;
  script.horizontal_fov_rad = 1.1F;
  script.vertical_fov_rad = 0.7F;
  script.period_us = 20000;
  const VirtualCamera camera(script, film);
  SequenceOptions options = CameraOptions();
  options.last = 18;
  const auto source = Open(options);
  EXPECT_EQ(source->info().frame_count, -1);
  EXPECT_TRUE(source->info().has_clock);
  EXPECT_NEAR(source->info().pinhole.fx, 16 / std::tan(0.55), 1e-5);  // the angle is a float
  EXPECT_NEAR(source->info().pinhole.fy, 12 / std::tan(0.35), 1e-5);
  EXPECT_EQ(source->info().pinhole.cx, 15.5);
  EXPECT_FALSE(source->info().camera_is_guessed);
  int expected = -1, first = 0;  // dropped frames are counted
  while (const auto result = source->Next()) {
    ASSERT_TRUE(result->frame) << result->error;
    if (expected < 0) {
      expected = NumberOf(*result) - result->dropped_before;
      first = NumberOf(*result) - result->index;
    }
    expected += result->dropped_before;
    EXPECT_EQ(result->index, expected - first);
    EXPECT_EQ(NumberOf(*result), expected);
    EXPECT_DOUBLE_EQ(result->stamp_s, 1e-6 * static_cast<double>(film[expected].depth_us));
    EXPECT_NEAR(result->frame->color_stamp_s - result->stamp_s, 0.004, 1e-9);
    EXPECT_NEAR(result->frame->depth_m[3], 1e-3 * film[expected].depth[3], 1e-6);
    ++expected;
  }
  EXPECT_EQ(expected, first + 19);
}

TEST_F(OpenNiCamera, AppliesTheOptions) {
  CameraScript script;
  script.period_us = 1000;
  const VirtualCamera camera(script, NumberedFilm(400));
  SequenceOptions options = CameraOptions();
  options.device_lock_exposure = true;
  options.last = 300;  // 60 images before the lock, plus a margin for dropped frames
  ReadAll(Open(options).get());
  // Properties: 7 mirroring, 100 automatic white balance, 101 automatic exposure.
  EXPECT_THAT(camera.Log(), Names("32x24", "registration 1", "property 7 = 0", "property 100 = 0",
                                  "property 101 = 0"));
}

TEST_F(OpenNiCamera, DoesNotLockExposureByDefault) {
  CameraScript script;
  script.period_us = 1000;
  const VirtualCamera camera(script, NumberedFilm(120));
  SequenceOptions options = CameraOptions();
  options.last = 78;
  ReadAll(Open(options).get());
  EXPECT_THAT(camera.Log(), Not(Names("property 101")));
}

TEST_F(OpenNiCamera, DropsAndCountsLateFrames) {
  constexpr int kFrames = 60;  // plus a margin: a slow machine may drop the last frames
  const VirtualCamera camera({}, NumberedFilm(kFrames + 40));
  SequenceOptions options = CameraOptions();
  options.last = kFrames - 1;
  const auto source = Open(options, /*capacity=*/2);
  int taken = 0, dropped = 0, next = -1;
  while (const auto result = source->Next()) {
    if (next < 0) next = NumberByStamp(*result) - result->dropped_before;
    next += result->dropped_before;
    EXPECT_EQ(NumberByStamp(*result), next++);
    if (result->frame) {  // a slow machine may drop colour images
      EXPECT_EQ(NumberOf(*result), next - 1);
    }
    ++taken;
    dropped += result->dropped_before;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  EXPECT_GT(dropped, 0);
  EXPECT_GT(taken, 2);
}

TEST_F(OpenNiCamera, ContinuesAfterReconnection) {
  CameraScript script;
  script.unplugged_at = 10;
  script.away_ms = 400;
  script.period_us = 10000;
  const VirtualCamera camera(script, NumberedFilm(60));
  SequenceOptions options = CameraOptions();
  options.last = 29;
  const auto source = Open(options);
  double last_s = -1, paused_s = 0, jump_s = 0;
  int after = 0;
  while (const auto result = source->Next()) {
    ASSERT_TRUE(result->frame) << result->error;
    EXPECT_GT(result->stamp_s, last_s);
    if (result->paused_before_s > 0) {
      paused_s = result->paused_before_s;
      jump_s = result->stamp_s - last_s;
    }
    last_s = result->stamp_s;
    after += NumberOf(*result) >= 10;
  }
  EXPECT_GE(paused_s, 0.4);
  EXPECT_NEAR(jump_s, paused_s, 0.05);  // a few frames of 10 ms may be in transit
  EXPECT_GE(after, 5);
}

TEST_F(OpenNiCamera, StopsWhileDisconnected) {
  CameraScript script;
  script.unplugged_at = 5;
  script.away_ms = -1;
  const VirtualCamera camera(script, NumberedFilm(10));
  const auto source = Open(CameraOptions());
  std::thread stopper([this] {
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    stop_ = true;
  });
  EXPECT_LE(ReadAll(source.get()).size(), 5U);
  stopper.join();
}

TEST_F(OpenNiCamera, ReportsDepthWithoutColourAsError) {
  std::vector<FilmFrame> film = NumberedFilm(80);
  const auto is_alone = [](int number) { return number % 10 == 5; };
  // The colour image is more than 20 ms away, and no other depth image is closer.
  for (int i = 0; i < 80; ++i) film[i].color_us -= is_alone(i) ? 25000 : 0;
  CameraScript script;
  script.period_us = 20000;
  const VirtualCamera camera(script, film);
  SequenceOptions options = CameraOptions();
  options.last = 39;
  int errors = 0;
  for (const ReadResult& result : ReadAll(Open(options).get())) {
    const int number = NumberByStamp(result);
    EXPECT_EQ(!result.frame, is_alone(number)) << number;
    if (result.frame) continue;
    ++errors;
    EXPECT_THAT(result.error, Names(0.02));
  }
  EXPECT_GE(errors, 1);  // of four: a slow machine may drop some
}

TEST_F(OpenNiCamera, RejectsBadOptions) {
  CameraScript script;
  script.can_register = 0;
  const VirtualCamera camera(script, NumberedFilm(3));
  SequenceOptions options = CameraOptions();
  options.path = "1d27/0601@1/2";
  ExpectInputError([&] { Open(options); }, Names("1d27/0601@1/2", "test://1", "Surfit", "Virtual"));
  options = CameraOptions();
  options.device_width = 640;
  ExpectInputError([&] { Open(options); }, Names(32, 24, 30));
  ExpectInputError([&] { Open(CameraOptions()); }, Names("color_from_depth"));
  options = CameraOptions();
  options.openni2_library = "libNowhere.so";
  ExpectInputError([&] { Open(options); },
                   Names("libNowhere.so", "libopenni2-0", "openni2_library"));
  ExpectInputError([&] { OpenSequence(CameraOptions()); }, Names("openni2"));
}

TEST_F(OpenNiCamera, RejectsMissingCamera) {
  ExpectInputError([&] { Open(CameraOptions()); }, Names("any", "OpenNI2"));
}

class OniRecordingTest : public ::testing::Test {
 protected:
  // Writes a recording with `count` numbered frames, and a TUM folder with the same frames.
  void Record(int count, const CameraScript& script = {}) {
    const VirtualCamera camera(script, NumberedFilm(count));
    RecordOni(path());
    std::string rgb, depth;
    for (int i = 0; i < count; ++i) {
      const std::string stamp = Format("0.%06d", 33333 * i);
      WriteColor(folder_ / Format("tum/rgb/%d.png", i), NumberedColor(i));
      WriteDepth(folder_ / Format("tum/depth/%d.png", i), NumberedDepth(i));
      rgb += stamp + Format(" rgb/%d.png\n", i);
      depth += stamp + Format(" depth/%d.png\n", i);
    }
    folder_.Write("tum/rgb.txt", rgb);
    folder_.Write("tum/depth.txt", depth);
    folder_.Write("tum/camera.yaml", SmallCameraYaml());
  }

  std::string path() const { return folder_ / "camera.oni"; }

  SequenceOptions TumOptions() const {
    SequenceOptions options = OptionsOf(folder_ / "tum");
    options.format = "tum";
    return options;
  }

  TempFolder folder_;
};

void ExpectSameFrames(const std::vector<ReadResult>& a, const std::vector<ReadResult>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    ASSERT_TRUE(a[i].frame) << a[i].error;
    ASSERT_TRUE(b[i].frame) << b[i].error;
    EXPECT_EQ(a[i].stamp_s, b[i].stamp_s);
    EXPECT_EQ(a[i].frame->color_stamp_s, b[i].frame->color_stamp_s);
    EXPECT_TRUE(std::equal(a[i].frame->depth_m.begin(), a[i].frame->depth_m.end(),
                           b[i].frame->depth_m.begin()));
    EXPECT_TRUE(
        std::equal(a[i].frame->color.begin(), a[i].frame->color.end(), b[i].frame->color.begin()));
  }
}

TEST_F(OniRecordingTest, MatchesAFolderWithTheSameFrames) {
  Record(24);  // mirrored: the default of OpenNI2 cameras
  const auto recorded = OpenSequence(OniOptions(path()));
  EXPECT_EQ(recorded->info().format, "oni");
  EXPECT_EQ(recorded->info().frame_count, 24);
  EXPECT_NEAR(recorded->info().pinhole.fx, 16 / std::tan(0.5), 1e-5);
  ExpectSameFrames(ReadAll(recorded.get()), ReadAll(OpenSequence(TumOptions()).get()));
}

TEST_F(OniRecordingTest, ReadsPartsRepeatedly) {
  Record(24);
  SequenceOptions part = OniOptions(path()), same = TumOptions();
  part.first = same.first = 7;
  part.last = same.last = 18;
  part.stride = same.stride = 3;
  for (int i = 0; i < 2; ++i)
    ExpectSameFrames(ReadAll(OpenSequence(part).get()), ReadAll(OpenSequence(same).get()));
}

TEST_F(OniRecordingTest, ReadsRecordingsWithoutColour) {
  CameraScript script;
  script.has_color = 0;
  Record(6, script);
  const auto results = ReadAll(OpenSequence(OniOptions(path())).get());
  ASSERT_EQ(results.size(), 6U);
  EXPECT_TRUE(results[0].frame->color.empty());
}

TEST_F(OniRecordingTest, RejectsOtherFiles) {
  folder_.Write("camera.oni", "this is no recording");
  ExpectInputError([&] { OpenSequence(OniOptions(path())); }, Names("camera.oni"));
}

TEST_F(OniRecordingTest, ConvertsToAFolderBitwise) {
  Record(12);
  RecordOptions options;
  options.sequence = OniOptions(path());
  options.output = folder_ / "copy";
  const RecordSummary summary =
      RecordSequence(options, std::atomic<bool>(false), [](const RecordSummary&) {});
  EXPECT_EQ(summary.frames_written, 12);
  const auto copy = OpenSequence(OptionsOf(options.output));
  const auto recorded = OpenSequence(options.sequence);
  EXPECT_EQ(copy->info().pinhole.fx, recorded->info().pinhole.fx);
  ExpectSameFrames(ReadAll(copy.get()), ReadAll(recorded.get()));
}

}  // namespace
}  // namespace surfit::testing
