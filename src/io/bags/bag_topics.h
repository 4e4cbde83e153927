#pragma once

#include <string>

#include "io/bags/message_log.h"

namespace surfit {

// A topic of images, with what its first message tells.
struct ImageTopic {
  const Topic* topic = nullptr;
  std::string frame;                    // the camera's, in tf
  std::uint32_t width = 0, height = 0;  // px; 0 of compressed images
};

struct BagTopics {
  ImageTopic depth;
  ImageTopic color;  // topic is null where the bag has no colour
};

// Finds depth and colour in a bag: of images that are told raw and compressed the raw ones, of
// colour and grey the colour. `depth` and `color` name topics instead where they are not empty;
// "none" is no colour. Throws InputError naming the file, its topics and the option to give where
// there is no depth, more than one, or more than one colour.
BagTopics FindTopics(const MessageLog& log, const std::string& depth, const std::string& color);

// The CameraInfo beside a topic of images, as image_transport and RealSense's recorder name it, or
// the only one of the camera's frame; null if there is none.
const Topic* FindCameraInfo(const MessageLog& log, const ImageTopic& image);

}  // namespace surfit
