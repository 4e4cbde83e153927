#pragma once

#include <limits>
#include <vector>

#include "surfit/frame/frame_pyramid.h"
#include "surfit/mapping/surfel_map.h"

namespace surfit {

class OptionVisitor;

class DiscList;

// How the map is drawn.
struct RenderOptions {
  // Surfels with less confidence (Keller et al., 3DV 2013) are drawn only where no others are: they
  // are mostly noise, and would otherwise hide the surface behind them.
  float stable_confidence = 10;
  // A disc covers the pixels within this share of its radius. A surfel made from one pixel has a
  // radius of sqrt(2) pixels, so that half of it just closes the gaps of the pixel grid. Pixels
  // farther than f / z times that from the disc's centre, in u or v, are not looked at.
  float radius_share = 1;
  int max_half_window_px = 4;  // of the pixels that one disc may cover
  // Discs this far behind the first one that a ray meets, plus 4 sigma of the depth, belong to the
  // same surface. Of these the ray takes the one whose centre it passes closest. Taking the first
  // would pick those that noise brought nearest, and with them a surface that is too near.
  float surface_thickness_m = 0.02f;

  void Visit(OptionVisitor& visitor);
};

// Draws surfel maps as oriented discs with hidden surfaces removed: each pixel shows one disc of
// the surface that its ray meets first, stable ones before unstable ones. Vertices lie where the
// ray meets that disc. Not drawn are discs seen from behind, and surfels that were observed at
// depth edges alone: tracking would suffer. Keeps its buffers between calls.
class ModelRenderer {
 public:
  explicit ModelRenderer(const RenderOptions& options);
  ~ModelRenderer();
  ModelRenderer& operator=(ModelRenderer&&) = delete;

  // What the sensor would see, of the surfels that were last seen in frame `active_since` or later.
  // The same map and pose give the same view bit for bit at any number of threads.
  ModelView Render(const SurfelMap& map, const DepthSensor& sensor, const Rigid3d& world_from_view,
                   int active_since = std::numeric_limits<int>::min());

 private:
  RenderOptions options_;
  std::vector<DiscList> lists_;  // the discs of the cells in view
};

// The colours of the surfels that a view of the map shows, (0, 0, 0) where there is none. The map
// must not have changed since.
Image<Rgb8> ColorsOf(const ModelView& view, const SurfelMap& map);

}  // namespace surfit
