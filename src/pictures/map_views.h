#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "pictures/picture_view.h"
#include "surfit/mapping/surfel_map.h"

namespace surfit {

// Four views of the surfels with shown[id] != 0, each width x height pixels: from above, from a
// bird's place, from the first camera pulled back, and from the camera that looks most elsewhere.
std::array<PictureView, 4> ChooseMapViews(const SurfelMap& map,
                                          const std::vector<std::uint8_t>& shown,
                                          const Trajectory& camera_path, int width, int height);

// The pose of the path whose view differs most from the first's: by the angle in rad plus the
// distance in units of scene_depth_m. 0 for a path of one pose.
std::size_t MostDifferentPose(const Trajectory& camera_path, double scene_depth_m);

}  // namespace surfit
