#pragma once

#include <Eigen/Core>
#include <vector>

#include "mapping/rendering/frame_colors.h"
#include "surfit/core/image.h"
#include "surfit/mapping/surfel_map.h"

namespace surfit {

// `depth_m` 0: no depth. Does not own the references.
struct DepthPicture {
  const Image<float>& depth_m;
  const PosedCamera& camera;
};

// New colours of a map with fixed geometry: averages over frames with the weights of FrameColors.
// Not thread-safe: Add() uses several threads itself.
class ColorAverage {
 public:
  // Keeps a reference. The map must not change, except by WriteTo().
  explicit ColorAverage(const SurfelMap& map);

  // Adds the colours of a frame with colours. `camera`: pose of the colour image. `drawn` is the
  // rendered depth of the map, `measured` the depth of the frame. Their image sizes and poses may
  // differ.
  //
  // A surfel is occluded if it is more than 5 % behind the smallest depth within one pixel, in
  // either image. Surfels outside of an image, or without depth there, are treated as occluded,
  // because the map lacks black and shiny objects. Surfels that face away are ignored.
  void Add(const FrameColors& colors, const PosedCamera& camera, const DepthPicture& drawn,
           const DepthPicture& measured);

  // Writes the averages into a map with the surfels of the constructor. Surfels without
  // observations keep their colours.
  void WriteTo(SurfelMap* map) const;

 private:
  struct Sum {
    Eigen::Vector3f color = Eigen::Vector3f::Zero();
    float weight = 0;
  };

  const SurfelMap& map_;
  std::vector<Sum> sums_;  // by id
};

}  // namespace surfit
