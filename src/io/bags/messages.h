#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "io/bags/message_log.h"
#include "surfit/geometry/rigid3.h"

namespace surfit {

// ROS messages of images and cameras (docs.ros.org: sensor_msgs, geometry_msgs, tf2_msgs). All
// readers throw InputError with `name` for invalid bytes, and for CDR that is not plain
// little-endian. `name` names the message in errors. `topic` gives serialization (not kOther) and
// type.

// std_msgs/Header.
struct MessageHeader {
  std::int64_t stamp_ns = 0;  // timestamp of the driver; 0: not set
  std::string frame;          // without a leading slash
};

// MessageHeader::stamp_ns from the first bytes of a message.
std::int64_t StampOf(const MessageLocation& place, const Topic& topic, const std::string& name);

// sensor_msgs/Image or sensor_msgs/CompressedImage. For compressed images, `encoding` is the field
// `format`, and size and step are 0.
struct ImageMessage {
  MessageHeader header;
  std::uint32_t width = 0, height = 0;  // px
  std::string encoding;                 // for example 16UC1, rgb8; see message_images.h
  bool is_big_endian = false;
  std::uint32_t step = 0;  // bytes per row
  std::string data;
  bool is_compressed = false;
};
// `bytes`: result of MessageLog::Read().
ImageMessage ReadImageMessage(const std::string& bytes, const Topic& topic,
                              const std::string& name);

// sensor_msgs/CameraInfo.
struct CameraInfo {
  MessageHeader header;
  std::uint32_t width = 0, height = 0;  // px
  std::string distortion_model;
  std::vector<double> distortion;       // coefficients of distortion_model; may be empty
  std::array<double, 9> intrinsics{};   // K of the raw image, row-major
  std::array<double, 12> projection{};  // P of the rectified image, row-major
  // Binning, then the region of interest in px of the full image. Size 0: full image.
  std::uint32_t binning_x = 0, binning_y = 0;  // full pixels per image pixel; 0: 1
  std::uint32_t roi_x = 0, roi_y = 0, roi_width = 0, roi_height = 0;
};
CameraInfo ReadCameraInfo(const std::string& bytes, const Topic& topic, const std::string& name);

// std_msgs/Float32.
float ReadFloat(const std::string& bytes, const Topic& topic, const std::string& name);

// sensor_msgs/Imu without orientation and covariances.
struct ImuMessage {
  MessageHeader header;
  Eigen::Vector3d gyro_rad_per_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d accel_m_per_s2 = Eigen::Vector3d::Zero();
};
// Also throws InputError for numbers that are not finite.
ImuMessage ReadImuMessage(const std::string& bytes, const Topic& topic, const std::string& name);

// geometry_msgs/TransformStamped.
struct FrameTransform {
  std::string parent, child;  // tf frames without a leading slash
  Rigid3d parent_from_child;  // m; maps coordinates of the child frame to the parent frame
};
// Transforms of a tf2_msgs/TFMessage or tf/tfMessage. Omits transforms that RigidFromNumbers()
// rejects.
std::vector<FrameTransform> ReadTransforms(const std::string& bytes, const Topic& topic,
                                           const std::string& name);

}  // namespace surfit
