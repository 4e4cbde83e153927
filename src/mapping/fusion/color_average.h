#pragma once

#include <Eigen/Core>
#include <vector>

#include "mapping/rendering/blended_view.h"
#include "mapping/rendering/frame_colors.h"
#include "surfit/core/image.h"
#include "surfit/geometry/sensor.h"
#include "surfit/mapping/surfel_map.h"

namespace surfit {

// `depth_m` 0: no depth. Does not own the references.
struct DepthPicture {
  const Image<float>& depth_m;
  const PosedCamera& camera;
};

// New colours of a map with fixed geometry. The colour of a surfel is the average of the pixels
// that show it, by its blending weights b in views of the map (DrawBlended()):
//   c_j = sum_p b_pj I_p / sum_p b_pj,    sum_j b_pj = 1,
// for the pixel colours I_p. Nearer frames have more pixels per surfel, and a larger weight. This
// is the first step of SIRT (Gilbert 1972) for the least squares sum_p |sum_j b_pj c_j - I_p|^2.
// Further steps made held-out views of recordings worse. Not thread-safe: Add() uses several
// threads itself.
class ColorAverage {
 public:
  // Keeps a reference. The map must not change, except by WriteTo().
  explicit ColorAverage(const SurfelMap& map);

  // Adds the colours of a frame with colours. `camera`: pose of the colour image, with the camera
  // of `sensor`. `shown`: depth of the surfaces that the frame shows. Sizes and poses of these
  // images may differ.
  //
  // Samples every n-th column and row of the image, so that at least 240 columns remain, or all
  // columns of smaller images. Each call uses other columns or rows. Samples are ignored:
  // - without a surface of the map, or if the map is more than 5 % nearer at a neighbour sample
  // - if all images of `shown` hide them: without depth, because the map lacks some objects, or
  // with
  //   a depth more than 5 % nearer within one pixel
  void Add(const FrameColors& colors, const DepthSensor& sensor, const Rigid3d& world_from_camera,
           const std::vector<DepthPicture>& shown);

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
  int added_ = 0;
};

}  // namespace surfit
