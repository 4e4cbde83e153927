#pragma once

#include <string>
#include <vector>

#include "apps/export/sparse_points.h"
#include "surfit/geometry/pinhole_camera.h"

namespace surfit {

// Sparse model of COLMAP. All images have one camera. The referenced objects must outlive the
// model.
struct ColmapModel {
  const PinholeCamera& lens;
  const std::vector<PosedImage>& images;
  const SparsePoints& points;
  const Rigid3d& export_from_world;  // applied to poses and points
};

// Writes cameras, images and points3D as .bin and as .txt into two existing folders. The camera
// model is PINHOLE, OPENCV, or FULL_OPENCV if k3 is not 0. COLMAP has the centre of the top-left
// pixel at (0.5, 0.5), so all pixel coordinates are 0.5 px larger than those of `lens`. Ids count
// from 1. The error of a point is -1 (unknown), because its views are projections of the point.
// Throws InputError with the path if writing fails.
void WriteColmapModel(const ColmapModel& model, const std::string& binary_folder,
                      const std::string& text_folder);

}  // namespace surfit
