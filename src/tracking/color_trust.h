#pragma once

#include <vector>

#include "surfit/core/image.h"
#include "surfit/frame/rgbd_frame.h"

namespace surfit {

// Returns whether colour changes at the depth edges of a frame. Most depth edges are outlines of
// objects. Compares the mean colour gradient there with the mean of the image. Returns true with
// few depth edges, where nothing is known.
bool HasColorAtDepthEdges(const Image<float>& depth_m, const Image<Rgb8>& color);

// Detects colour that does not belong to the depth: images of another time, rotated images, noise,
// or a frozen camera. Colour that loses the trust is not used any more. Colour that has agreed with
// depth often enough is proven: later contradictions show another place, not another camera. Not
// thread-safe.
class ColorTrust {
 public:
  // Adds the images of a frame. Returns whether its colour may be used. It is false after a
  // contradiction, and for the fourth and later repetitions of a colour image with new depth.
  // `is_new_depth`: the depth differs from the last frame.
  bool Accepts(const Image<Rgb8>& color, bool is_new_depth);
  // Adds a frame whose pose is certain by depth. `agrees`: the brightness agrees with the pose.
  // Colour loses the trust after 5 more contradictions than agreements, unless it is proven.
  void AddBrightness(bool agrees);
  // Adds a frame whose pose is certain by depth, and rejected by image features. Colour without
  // changes at depth edges loses the trust, unless it is proven. Returns whether the rejection is
  // trusted.
  bool TrustsFeatures(const RgbdFrame& frame);

  // True after 15 more agreements than contradictions.
  bool is_proven() const { return is_proven_; }
  // False after a contradiction. Frozen colour is only rejected while it repeats.
  bool is_trusted() const { return is_trusted_; }

 private:
  int agreement_ = 0, doubt_ = 0, repetitions_ = 0;
  bool is_trusted_ = true, is_proven_ = false;
  std::vector<Rgb8> last_sample_;  // pixels of the last colour image
};

}  // namespace surfit
