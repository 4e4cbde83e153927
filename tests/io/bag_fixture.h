#pragma once

#include <gmock/gmock.h>

#include <memory>
#include <string>

#include "surfit/io/sequence.h"
#include "testing/matchers.h"
#include "testing/ros_bag.h"
#include "testing/sequence_writer.h"
#include "testing/temp_folder.h"

namespace surfit::testing {

// Opens a bag that a test fills with messages.
class BagTest : public ::testing::Test {
 protected:
  static constexpr char kImage[] = "sensor_msgs/Image", kInfo[] = "sensor_msgs/CameraInfo",
                        kCompressed[] = "sensor_msgs/CompressedImage";
  static constexpr char kDepth[] = "/camera/depth/image_raw", kColor[] = "/camera/rgb/image_raw";
  static constexpr char kOptical[] = "camera_optical_frame";

  // Three frames at 10 Hz from time 5, depth as 16UC1, colour as rgb8.
  void AddDepth(const std::string& topic = kDepth, const std::string& frame = kOptical) {
    for (int i = 0; i < 3; ++i)
      bag_.Add(topic, kImage, 5 + 0.1 * i,
               RosImage{"16UC1", RawBytes(NumberedDepth(i))}.Bytes(5 + 0.1 * i, frame));
  }
  void AddColor(const std::string& topic = kColor, const std::string& frame = kOptical) {
    for (int i = 0; i < 3; ++i)
      bag_.Add(topic, kImage, 5 + 0.1 * i,
               RosImage{"rgb8", RawBytes(NumberedColor(i))}.Bytes(5 + 0.1 * i, frame));
  }
  void AddInfo(const std::string& topic, const std::string& frame = kOptical,
               const RosCameraInfo& info = {}) {
    bag_.Add(topic, kInfo, 5, info.Bytes(5, frame));
  }
  void AddInfos() {
    AddInfo("/camera/depth/camera_info");
    AddInfo("/camera/rgb/camera_info");
  }
  void AddOne(const std::string& topic, const RosImage& image) {
    bag_.Add(topic, kImage, 5, image.Bytes(5, kOptical));
  }
  void AddCompressed(const std::string& topic, const std::string& format, const std::string& data) {
    bag_.Add(topic, kCompressed, 5, RosCompressedImage(5, kOptical, format, data));
  }
  std::unique_ptr<FrameSource> Open() {
    options_.path = folder_.Write("a.bag", bag_.File());
    return OpenSequence(options_);
  }
  // The first frame, or an empty frame if the bag has none.
  RgbdFrame First() {
    const auto result = Open()->Next();
    EXPECT_TRUE(result && result->frame) << (result ? result->error : "nothing");
    return result && result->frame ? *result->frame : RgbdFrame();
  }
  void ExpectError(const ::testing::Matcher<const std::string&>& message) {
    ExpectInputError([&] { Open(); }, message);
  }

  TempFolder folder_;
  RosBagEncoder bag_;
  SequenceOptions options_;
};

}  // namespace surfit::testing
