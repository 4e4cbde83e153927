#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "surfit/core/image.h"

namespace surfit {

// Brightness (0 = black, 1 = white), each image half as wide as the one before.
using GreyPyramid = std::vector<Image<float>>;

GreyPyramid MakeGreyPyramid(const Image<Rgb8>& color);

// Pixels whose surroundings can be found again in another image: those where brightness changes
// most in all directions (Shi and Tomasi 1994), where there is depth, not near each other, the
// strongest first, at most `max_count`.
std::vector<Eigen::Vector2f> FindCorners(const GreyPyramid& grey, const Image<float>& depth_m,
                                         int max_count);

// Corners that are followed from image to image by their patches (Lucas and Kanade 1981, inverse
// compositional: Baker and Matthews 2004), coarse to fine, gain and offset of the brightness taken
// out.
class CornerTracks {
 public:
  CornerTracks() = default;
  CornerTracks(GreyPyramid first, std::vector<Eigen::Vector2f> corners);

  struct Track {
    int corner;                   // its index
    Eigen::Vector2f first, last;  // px, in the first and in the last image
  };
  using Expect = std::function<Eigen::Vector2f(const Track&)>;

  // Goes on to the next image, where a corner is looked for from `expect(track)` on, px, in about a
  // dozen pixels. Corners that are not found are lost.
  void Follow(GreyPyramid next, const Expect& expect);

  // Of the corners that still look as in the first image.
  std::vector<Track> Lasting() const;

 private:
  GreyPyramid first_, last_;
  std::vector<Track> tracks_;
};

}  // namespace surfit
