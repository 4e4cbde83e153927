#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "io/bags/message_log.h"
#include "surfit/geometry/rigid3.h"

namespace surfit {

// The messages of ROS that tell of images (docs.ros.org: sensor_msgs, geometry_msgs, tf2_msgs).
// All readers throw InputError naming `name` if the bytes are not such a message.

// std_msgs/Header.
struct MessageHeader {
  std::int64_t stamp_ns = 0;
  std::string frame;  // without the slash that old ones begin with
};

// The stamp that a message's first bytes tell; 0 where it is not set.
std::int64_t StampOf(const MessagePlace& place, const Topic& topic, const std::string& name);

// sensor_msgs/Image, or sensor_msgs/CompressedImage, whose format is its encoding and which has
// neither size nor step.
struct ImageMessage {
  MessageHeader header;
  std::uint32_t width = 0, height = 0;  // px
  std::string encoding;
  bool is_big_endian = false;
  std::uint32_t step = 0;  // bytes from row to row
  std::string data;
  bool is_compressed = false;
};
ImageMessage ReadImageMessage(const std::string& bytes, const Topic& topic,
                              const std::string& name);

// sensor_msgs/CameraInfo.
struct CameraInfo {
  MessageHeader header;
  std::uint32_t width = 0, height = 0;  // px
  std::string distortion_model;
  std::vector<double> distortion;
  std::array<double, 9> intrinsics{};   // K, row by row, of the image as the camera gives it
  std::array<double, 12> projection{};  // P, likewise, of the rectified one
};
CameraInfo ReadCameraInfo(const std::string& bytes, const Topic& topic, const std::string& name);

// geometry_msgs/TransformStamped.
struct FrameTransform {
  std::string parent, child;
  Rigid3d parent_from_child;
};
// Those of a tf2_msgs/TFMessage or tf/tfMessage; without what is no rigid transform.
std::vector<FrameTransform> ReadTransforms(const std::string& bytes, const Topic& topic,
                                           const std::string& name);

}  // namespace surfit
