#pragma once

#include <deque>
#include <optional>

#include "io/openni/openni_device.h"

namespace surfit {

// Depth image with its colour image. Colour is empty if no waiting colour image is within
// kMaxBetweenImages_s (recording.h) of the depth image.
struct ImagePair {
  DeviceImage depth;
  DeviceImage color;
};

// Pairs depth and colour by timestamp as images arrive. Each depth image gets the nearest colour
// image; a colour image is used at most once, and its use discards earlier colour images. A pair is
// complete when two more depth images have arrived, or a colour image with the same or a later
// timestamp. At most eight images of each kind wait; the oldest is dropped. Not thread-safe.
class ImagePairs {
 public:
  // If not `has_color`, each depth image is a complete pair.
  explicit ImagePairs(bool has_color) : has_color_(has_color) {}

  // Call in order of arrival.
  void Add(DeviceImage image);
  // Removes the next complete pair, in order of arrival of depth; std::nullopt if there is none.
  std::optional<ImagePair> Take();
  // Discards waiting images, for example after a disconnection.
  void Clear();

 private:
  bool IsDecided() const;

  bool has_color_;
  std::deque<DeviceImage> depth_, color_;
};

}  // namespace surfit
