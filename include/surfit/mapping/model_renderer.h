#pragma once

#include <limits>
#include <vector>

#include "surfit/frame/frame_pyramid.h"
#include "surfit/mapping/surfel_map.h"

namespace surfit {

class OptionVisitor;

class DiscList;

// Options of ModelRenderer.
struct RenderOptions {
  // Confidence of a stable surfel (Keller et al., 3DV 2013). Unstable surfels are mostly noise, so
  // they are drawn only in pixels without stable surfels.
  float stable_confidence = 10;
  // Radius of a drawn disc, relative to the surfel radius. 0.5 just closes the gaps of the pixel
  // grid.
  float radius_ratio = 1;
  int max_half_window_px = 4;  // maximum distance of drawn pixels from the disc centre, per axis
  // Thickness of a surface, plus 4 sigma of the depth. All discs of a ray that are this close
  // behind the first disc belong to the surface. The pixel shows the disc whose centre is nearest
  // to the ray, because noise biases the first disc.
  float surface_thickness_m = 0.02f;

  void Visit(OptionVisitor& visitor);
};

// Renders surfel maps as oriented discs with occlusion. Each pixel shows one disc of the first
// surface of its ray. Stable discs take precedence over unstable discs. Vertices are intersections
// of ray and disc. Back faces, surfels closer than 5 cm, and surfels that were observed only at
// depth edges are not drawn. Not thread-safe.
class ModelRenderer {
 public:
  // Throws InputError for invalid options.
  explicit ModelRenderer(const RenderOptions& options);
  ~ModelRenderer();
  ModelRenderer& operator=(ModelRenderer&&) = delete;

  // Renders the surfels last observed in frame `active_since` or later, with the camera of
  // `sensor`. An empty map gives a view without surfaces. The view has no intensities and keeps no
  // reference. The view is bitwise identical for any number of threads. Throws if the image has
  // more than 32767 columns or rows, or a band of rows 2^24 discs.
  ModelView Render(const SurfelMap& map, const DepthSensor& sensor, const Rigid3d& world_from_view,
                   int active_since = std::numeric_limits<int>::min());

 private:
  RenderOptions options_;
  std::vector<DiscList> lists_;  // buffers, one per visible cell
};

// Surfel colours of a view; (0, 0, 0): no surfel. Surfels of Fusion without an observed colour are
// grey. The map must not have changed since the view was rendered.
Image<Rgb8> ColorsOf(const ModelView& view, const SurfelMap& map);

}  // namespace surfit
