#pragma once

#include <Eigen/Core>
#include <vector>

#include "mapping/frame_colors.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/mapping/blended_view.h"
#include "surfit/mapping/surfel_map.h"

namespace surfit {

// New colours of a map whose surfels stay where they are: the average of what frames show of each,
// by the weights of FrameColors.
class ColorAverage {
 public:
  // The map is not to change but by WriteTo().
  explicit ColorAverage(const SurfelMap& map);

  // A frame's colours as the camera took them at a pose, and a picture of the map from about there,
  // which tells what is hidden: what lies more than 5 % behind something that the picture shows
  // within a pixel of it. Beside the rim of a thing its colours reach over what is behind.
  void Add(const FrameColors& colors, const PosedCamera& camera, const BlendedView& drawn,
           const PosedCamera& drawn_camera);

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
