#pragma once

#include "surfit/core/image.h"
#include "surfit/frame/frame_pyramid.h"
#include "surfit/geometry/rigid3.h"

namespace surfit {

// Two views of one camera: pyramids of as many levels, and the colours of their finest pixels;
// empty where there are none.
struct ViewPair {
  const FramePyramid& source;
  const Image<Rgb8>& source_color;
  const FramePyramid& target;
  const Image<Rgb8>& target_color;
};

// Turns a pose about the target's camera until the coarsest levels of both views are most alike in
// brightness and shape (Gauss-Newton; the SO(3) pre-alignment of Whelan et al., ElasticFusion,
// RSS 2015). A cheap start for registration where the camera turns fast: it follows rotations of
// some ten degrees. Without colours it goes by the shapes alone.
Rigid3d AlignRotation(const ViewPair& views, const Rigid3d& target_from_source_initial);

}  // namespace surfit
