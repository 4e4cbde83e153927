#pragma once

#include <limits>
#include <vector>

#include "surfit/frame/frame_pyramid.h"
#include "surfit/mapping/surfel_map.h"

namespace surfit {

class OptionVisitor;

class DiscList;

// Options of map rendering.
struct RenderOptions {
  // Surfels below this confidence (Keller et al., 3DV 2013) are drawn only in pixels without other
  // surfels. Most of them are noise that would occlude the surface.
  float stable_confidence = 10;
  // Radius of the drawn disc, relative to the radius of the surfel. A surfel of one pixel has a
  // radius of sqrt(2) pixels, so 0.5 just closes the gaps of the pixel grid. In u and v a disc
  // covers pixels up to f / z times this radius from its centre.
  float radius_ratio = 1;
  int max_half_window_px = 4;  // limit of the pixels around a disc centre
  // Thickness of a surface: discs within this distance plus 4 sigma of the depth behind the first
  // disc of a ray belong to it. The pixel shows the disc whose centre is nearest to the ray. The
  // first disc is biased towards the camera by noise.
  float surface_thickness_m = 0.02f;

  void Visit(OptionVisitor& visitor);
};

// Renders surfel maps as oriented discs with occlusion. Each pixel shows one disc of the first
// surface of its ray; stable discs take precedence over unstable discs. Vertices are intersections
// of ray and disc. Back faces and surfels with observations at depth edges only are not drawn,
// because they degrade tracking. Not thread-safe.
class ModelRenderer {
 public:
  // Throws InputError for invalid options.
  explicit ModelRenderer(const RenderOptions& options);
  ~ModelRenderer();
  ModelRenderer& operator=(ModelRenderer&&) = delete;

  // Predicted view of the sensor, with the surfels last observed in frame `active_since` or later.
  // The view is bitwise identical for every number of threads.
  ModelView Render(const SurfelMap& map, const DepthSensor& sensor, const Rigid3d& world_from_view,
                   int active_since = std::numeric_limits<int>::min());

 private:
  RenderOptions options_;
  std::vector<DiscList> lists_;  // buffers, one per visible cell
};

// Colours of the surfels in a view; (0, 0, 0): no surfel. The map must be unchanged since the view
// was rendered.
Image<Rgb8> ColorsOf(const ModelView& view, const SurfelMap& map);

}  // namespace surfit
