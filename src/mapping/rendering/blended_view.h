#pragma once

#include "surfit/core/image.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/geometry/sensor.h"
#include "surfit/mapping/surfel_map.h"

namespace surfit {

// Rendered colour and depth with the image size of the camera.
struct BlendedView {
  Image<Rgb8> color;     // (0, 0, 0): no surface
  Image<float> depth_m;  // 0: no surface
};

// Renders a map for display, several times slower than ModelRenderer. Surfels are splats with soft
// borders (after EWA splatting: Zwicker, Pfister, van Baar and Gross, SIGGRAPH 2001). A pixel
// blends colour and inverse depth of the splats on the first surface. A splat belongs to the first
// surface if it is at most 3 cm plus 4 sigma of the depth behind it. A splat has the weight (1 - (d
// / 2 R)^2)^8 at the distance d from its centre, with the surfel radius R. Stable surfels take
// precedence, as in RenderOptions. Larger splats fill the holes. The result is bitwise identical
// for any number of threads. Uses camera and noise of `sensor`. `world_from_view`: camera to world.
BlendedView DrawBlended(const SurfelMap& map, const DepthSensor& sensor,
                        const Rigid3d& world_from_view);

}  // namespace surfit
