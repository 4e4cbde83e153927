#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "apps/export/color_images.h"
#include "surfit/mapping/surfel_map.h"

namespace surfit {

// Image of an export: a colour image with its final pose and camera.
struct PosedImage {
  ColorImage source;
  Rigid3d world_from_color;  // in the world frame of the map
};

// Projection of a point into an image.
struct PointView {
  std::int32_t point = 0;                           // index
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  // px
};

// Points of the map with their projections, as a sparse reconstruction.
struct SparsePoints {
  std::vector<Surfel> points;
  std::vector<std::vector<PointView>> views;  // per image, ascending in the point
  std::size_t unseen = 0;  // points that fewer than two images show; they are not in `points`
};

// At most `most` (positive) surfels, the most confident one per cube of a grid. The edge of the
// cubes follows from `most`.
std::vector<Surfel> ThinOut(const std::vector<Surfel>& surfels, std::size_t most);

// Projects at most 60000 reliable points of the map into the images, with a test of occlusion.
SparsePoints FindSparsePoints(const SurfelMap& map, const PinholeCamera& lens,
                              const std::vector<PosedImage>& images);

}  // namespace surfit
