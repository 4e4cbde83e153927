#pragma once

#include "surfit/core/image.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/geometry/sensor.h"
#include "surfit/mapping/surfel_map.h"

namespace surfit {

// A picture of a map.
struct BlendedView {
  Image<Rgb8> color;     // (0, 0, 0) where the map shows nothing
  Image<float> depth_m;  // 0 there
};

// Draws a map for people to look at; it takes several times as long as ModelRenderer, which draws
// for tracking. Surfels are splats with soft borders, twice as large as their discs (after EWA
// splatting: Zwicker, Pfister, van Baar and Gross, SIGGRAPH 2001). A pixel blends the colours and
// inverse depths of those that its ray meets on the first surface: no more than 3 cm, plus 4 sigma
// of the depth, behind the first of them. With the offset d from the centre and the radius R,
//   weight = (1 - (d / 2 R)^2)^8, which is near to exp(-2 d^2 / R^2).
// Confident surfels go before others, as in RenderOptions. Where no splat is met, twice as large
// ones fill the hole. The same map and pose give the same view bit for bit at any number of
// threads.
BlendedView DrawBlended(const SurfelMap& map, const DepthSensor& sensor,
                        const Rigid3d& world_from_view);

}  // namespace surfit
