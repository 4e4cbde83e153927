#pragma once

#include <Eigen/Core>
#include <vector>

#include "mapping/rendering/frame_colors.h"
#include "surfit/core/image.h"
#include "surfit/mapping/surfel_map.h"

namespace surfit {

// Depth that a camera sees, metres; 0 where there is none.
struct DepthPicture {
  const Image<float>& depth_m;
  const PosedCamera& camera;
};

// New colours of a map whose surfels stay where they are: the average of what frames show of each,
// by the weights of FrameColors.
class ColorAverage {
 public:
  // The map is not to change but by WriteTo().
  explicit ColorAverage(const SurfelMap& map);

  // A frame's colours as the camera took them at a pose, and what tells what is hidden then, both
  // about as fine: a picture of the map, and the frame's own depth. Hidden is what lies more than
  // 5 % behind something that one of them shows within a pixel of it: beside the rim of a thing its
  // colours reach over what is behind. So is what is seen where no depth was measured: the
  // map does not know of black and shiny things that return none.
  void Add(const FrameColors& colors, const PosedCamera& camera, const DepthPicture& drawn,
           const DepthPicture& measured);

  // Surfels that no frame has shown keep their colours.
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
