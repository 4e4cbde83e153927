#pragma once

#include <string>

#include "io/bags/message_log.h"

namespace surfit {

// Image topic, with properties of its first message.
struct ImageTopic {
  const Topic* topic = nullptr;         // null: none
  std::string frame;                    // tf frame of the camera
  std::uint32_t width = 0, height = 0;  // px; compressed images: 0
};

// Topics of a recording.
struct BagTopics {
  ImageTopic depth;
  ImageTopic color;  // without colour, `topic` is null
};

// Prefers raw to compressed images of one topic, and colour to grey. `depth`, `color`: topic names;
// empty: automatic; `color` "none": no colour. Throws InputError with path, topics and option if a
// named topic does not exist, there is no depth topic, or several topics are possible. The topics
// refer to `log`. Topics without messages or of an unknown serialization are ignored. Reads the
// first message of each image topic, and throws InputError if it is unreadable.
BagTopics FindTopics(const MessageLog& log, const std::string& depth, const std::string& color);

// CameraInfo topic of an image topic, by the names of image_transport and of the RealSense
// recorder. Otherwise the only CameraInfo topic with the same tf frame; null if there are none or
// several. Refers to `log`. `image.topic` must not be null. Throws InputError for an unreadable
// message.
const Topic* FindCameraInfo(const MessageLog& log, const ImageTopic& image);

// Topic with the depth unit of a depth topic, in m per count, as the recorder of RealSense writes
// it: /device_0/sensor_0/option/Depth_Units/value for /device_0/sensor_0/Depth_0/image/data. Null
// if there is none. Refers to `log`. `depth.topic` must not be null.
const Topic* FindDepthUnit(const MessageLog& log, const ImageTopic& depth);

}  // namespace surfit
