#pragma once

#include "surfit/core/image.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/geometry/sensor.h"
#include "surfit/mapping/surfel_map.h"

namespace surfit {

struct BlendedView {
  Image<Rgb8> color;     // (0, 0, 0): no surface
  Image<float> depth_m;  // 0: no surface
};

// Renders a map for display. It takes several times as long as ModelRenderer, which renders for
// tracking. Surfels are splats with soft borders and twice the radius of their discs (after EWA
// splatting: Zwicker, Pfister, van Baar and Gross, SIGGRAPH 2001). A pixel blends colour and
// inverse depth of the splats on the first surface, which is 3 cm plus 4 sigma of the depth thick.
// With the offset d from the centre and the radius R, the weight is
//   (1 - (d / 2 R)^2)^8, approximately exp(-2 d^2 / R^2).
// Confident surfels take precedence over others, as in RenderOptions. Splats of twice the size fill
// the holes. The result is bitwise identical for any number of threads.
BlendedView DrawBlended(const SurfelMap& map, const DepthSensor& sensor,
                        const Rigid3d& world_from_view);

}  // namespace surfit
