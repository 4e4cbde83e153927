#pragma once

#include <deque>
#include <optional>

#include "io/openni/openni_device.h"

namespace surfit {

// Depth with the colour that belongs to it; colour is empty where none is within
// kMaxBetweenImages_s.
struct ImagePair {
  DeviceImage depth;
  DeviceImage color;
};

// Pairs depth and colour by their stamps while they come: depth with the nearest colour, each
// colour with one depth at most. What pairs depth is decided when colour of its time or later has
// come, or depth of two frames later.
class ImagePairs {
 public:
  // Without colour each image of depth is a pair at once.
  explicit ImagePairs(bool has_color) : has_color_(has_color) {}

  void Add(DeviceImage image);
  // The next pair in order of depth's stamps, once it is decided.
  std::optional<ImagePair> Take();
  // What waits is forgotten, as when the device is gone.
  void Clear();

 private:
  bool IsDecided() const;

  bool has_color_;
  std::deque<DeviceImage> depth_, color_;
};

}  // namespace surfit
