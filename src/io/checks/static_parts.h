#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "io/sequences/recording.h"
#include "surfit/core/image.h"

namespace surfit {

// Parts of the view that move with the camera, such as a part of the robot or its mount.
struct StaticParts {
  Image<std::uint8_t> mask;  // size of the depth images; 1: moves with the camera
  double ratio = 0;          // masked cells / cells with depth
};

// Finds parts at the rim of the view whose depth is constant while most of the other depth changes.
// Parts are regions of at least 1 % of the image that touch its border, with a depth step along
// most of their outline. A floor that a robot drives over has no such step. `images`: frames that
// are about 0.5 s apart. Returns std::nullopt without such parts, with fewer than five images, and
// for images of different sizes.
std::optional<StaticParts> FindStaticParts(const std::vector<FrameImages>& images);

// Sets the depth of masked pixels to 0, which means missing. Does nothing for an image of another
// size.
void RemoveStaticParts(const Image<std::uint8_t>& mask, RawDepth* depth);

}  // namespace surfit
