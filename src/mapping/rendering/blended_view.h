#pragma once

#include <cstdint>
#include <memory>
#include <vector>

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

// Part of a splat in the colour of a pixel. The colour of a pixel is about the sum of the colours
// of its surfels, times their weights.
struct BlendShare {
  std::int32_t surfel;  // id in the map
  std::int32_t pixel;   // index in the image
  float weight;         // ratio of the weights of the pixel
};

// Renders a map for display, several times slower than ModelRenderer. Surfels are splats with soft
// borders (after EWA splatting: Zwicker, Pfister, van Baar and Gross, SIGGRAPH 2001). A pixel
// blends colour and inverse depth of the splats on the first surface. A splat belongs to the first
// surface if it is at most 3 cm plus 4 sigma of the depth behind it. A splat has the weight (1 - (d
// / 2 R)^2)^8 at the distance d from its centre, with the surfel radius R. Stable surfels take
// precedence, as in RenderOptions. Splats of twice the size fill holes, at pixels with splats on
// several sides, so that surfaces do not grow beyond their edges. The result is bitwise identical
// for any number of threads. Uses camera and noise of `sensor`. `world_from_view`: camera to world.
BlendedView DrawBlended(const SurfelMap& map, const DepthSensor& sensor,
                        const Rigid3d& world_from_view);

// Depth and blending weights of DrawBlended(), without the fillers of holes. The map must not
// change, and must outlive the object.
class BlendedDepth {
 public:
  BlendedDepth(const SurfelMap& map, const DepthSensor& sensor, const Rigid3d& world_from_view);
  ~BlendedDepth();

  const Image<float>& depth_m() const { return depth_m_; }  // 0: no surface
  // The shares of the pixels in a band of kBandRows rows, without shares below 2 %. Band 0 is the
  // top one. Thread-safe.
  std::vector<BlendShare> SharesOf(int band) const;

 private:
  struct Bands;
  Image<float> depth_m_;
  std::unique_ptr<const Bands> bands_;
};

}  // namespace surfit
