#pragma once

#include <string>
#include <vector>

#include "apps/export/sparse_points.h"
#include "surfit/core/image.h"

namespace surfit {

// Unit of the exported depth images.
inline constexpr double kDepthUnits_per_m = 1000;

// Renders the depth of the map for each pixel of a colour image, in units of 1 / kDepthUnits_per_m;
// 0: no surface, or farther than 65.5 m.
Image<std::uint16_t> DepthForImage(const SurfelMap& map, const PinholeCamera& lens,
                                   const Rigid3d& world_from_color);

// Writes transforms.json of nerfstudio. Poses are camera-to-world with OpenGL axes (x right, y up,
// z backward). All images have one camera, so the intrinsics are at the top level. cx and cy are
// 0.5 px larger than those of `lens`. `applied_transform` is the 3 x 4 matrix from the world frame
// of the run to that of the file. `has_masks`: each image has a mask. Throws InputError with the
// path if writing fails.
void WriteTransformsJson(const PinholeCamera& lens, const std::vector<PosedImage>& images,
                         bool has_masks, const Rigid3d& export_from_world, const std::string& path);

}  // namespace surfit
