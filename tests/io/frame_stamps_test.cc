// Capture times of frames: timestamps minus the sensor latency.
#include "io/sequences/klg_writer.h"
#include "surfit/io/camera_files.h"
#include "surfit/io/sequence.h"
#include "testing/matchers.h"
#include "testing/recordings.h"
#include "testing/sequence_writer.h"

namespace surfit::testing {
namespace {

// Frame 1 of a folder or file.
RgbdFrame SecondFrame(const SequenceOptions& options) {
  return *ReadAll(OpenSequence(options).get()).at(1).frame;
}

TEST(FrameStamps, AreDepthStampsMinusTheLatency) {
  const TempFolder folder;
  WriteTumSequence(folder, 3);
  SequenceOptions options = Options(folder);
  options.latency_s = 0.02;
  const auto source = OpenSequence(options);
  EXPECT_EQ(source->info().camera.latency_s, 0.02);
  EXPECT_EQ(source->info().ground_truth[1].stamp_s,
            5.1);  // timestamps of the reference have no latency
  const auto results = ReadAll(source.get());
  EXPECT_DOUBLE_EQ(results[1].stamp_s, 5.083);
  EXPECT_EQ(results[1].frame->stamp_s, results[1].stamp_s);
  EXPECT_DOUBLE_EQ(results[1].frame->color_stamp_s, 5.08);
}

TEST(FrameStamps, UseTheLatencyOfTheCameraFileUnlessOverridden) {
  const TempFolder folder;
  WriteTumSequence(folder, 3);
  RgbdCamera camera = ReadCameraYaml(folder / "camera.yaml");
  camera.latency_s = 0.05;
  WriteCameraYaml(camera, folder / "camera.yaml");
  SequenceOptions options = Options(folder);
  EXPECT_DOUBLE_EQ(SecondFrame(options).stamp_s, 5.053);
  options.latency_s = 0;
  EXPECT_DOUBLE_EQ(SecondFrame(options).stamp_s, 5.103);
}

TEST(FrameStamps, OfColorAlsoSubtractTheColorLatency) {
  const TempFolder folder;
  WriteTumSequence(folder, 3);
  SequenceOptions options;
  options.path = folder.path();
  options.latency_s = 0.02;
  options.color_latency_s = 0.007;
  EXPECT_DOUBLE_EQ(SecondFrame(options).stamp_s, 5.083);
  EXPECT_DOUBLE_EQ(SecondFrame(options).color_stamp_s, 5.073);
}

TEST(FrameStamps, AlsoSubtractTheLatencyForUnreadableFrames) {
  const TempFolder folder;
  WriteTumSequence(folder, 3);
  std::filesystem::remove(folder / "depth/001.png");
  SequenceOptions options = Options(folder);
  options.latency_s = 0.02;
  const auto results = ReadAll(OpenSequence(options).get());
  EXPECT_FALSE(results[1].frame);
  EXPECT_DOUBLE_EQ(results[1].stamp_s, 5.083);
}

// Poses of such sequences belong to frame numbers and keep them bitwise.
TEST(FrameStamps, RejectLatencyIfTheyAreFrameNumbers) {
  const TempFolder folder;
  for (int i = 0; i < 3; ++i) {
    const std::string stem = Format("frame-%06d", i);
    WriteColor(folder / (stem + ".color.png"), NumberedColor(i));
    WriteDepth(folder / (stem + ".depth.png"), NumberedDepth(i));
    folder.Write(stem + ".pose.txt", "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n");
  }
  SequenceOptions options = Options(folder);
  options.camera = "tum_fr1";
  options.intrinsics = {31, 30, 15.5, 11.5};
  options.depth_units_per_metre = 1000;
  const auto source = OpenSequence(options);
  EXPECT_EQ(source->info().camera.latency_s, 0);
  for (const ReadResult& result : ReadAll(source.get())) {
    EXPECT_EQ(result.stamp_s, source->info().ground_truth[result.index].stamp_s);
    EXPECT_EQ(result.frame->color_stamp_s, result.stamp_s);
  }
  options.latency_s = 0.02;
  ExpectInputError([&] { OpenSequence(options); }, Names("latency_s", 0.02, folder.path()));
  options.latency_s = 0;
  EXPECT_NO_THROW(OpenSequence(options));
}

TEST(FrameStamps, OfScanNetFilesAreDepthStampsForPosesToo) {
  const TempFolder folder;
  SensEncoder encoder;
  encoder.registered = true;
  encoder.depth_delay_us = 7000;
  const SequenceOptions options = OptionsOf(folder.Write("a.sens", encoder.File(3)));
  const RgbdFrame frame = SecondFrame(options);
  EXPECT_DOUBLE_EQ(frame.stamp_s, 5.107);
  EXPECT_DOUBLE_EQ(frame.color_stamp_s, 5.1);
  EXPECT_EQ(OpenSequence(options)->info().ground_truth[1].stamp_s, frame.stamp_s);
}

// Conversion to .klg subtracts the latency, so the .klg file has latency 0.
TEST(FrameStamps, OfConvertedKlgFilesSubtractTheLatencyOnce) {
  const TempFolder folder;
  WriteTumSequence(folder, 3);
  SequenceOptions options = Options(folder);
  options.latency_s = 0.02;
  WriteKlg(OpenSequence(options).get(), folder / "a.klg");
  SequenceOptions converted = OptionsOf(folder / "a.klg");
  EXPECT_DOUBLE_EQ(SecondFrame(converted).stamp_s, 5.083);
  EXPECT_DOUBLE_EQ(SecondFrame(converted).color_stamp_s, 5.083);
  converted.latency_s = 0.01;
  EXPECT_DOUBLE_EQ(SecondFrame(converted).stamp_s, 5.073);
}

}  // namespace
}  // namespace surfit::testing
