#pragma once

#include <Eigen/Core>
#include <vector>

#include "pictures/picture_view.h"

namespace surfit {

// A view of the points from behind and above the first camera of the path, all but the farthest few
// of them and the whole path in the image. Its direction stays the same while points are added and
// the path goes on, but for what the cameras' mean up changes.
PictureView LiveMapView(const std::vector<Eigen::Vector3f>& points_in_world,
                        const Trajectory& camera_path, int width, int height);

}  // namespace surfit
