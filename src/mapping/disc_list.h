#pragma once

#include <array>
#include <vector>

#include "mapping/bucket_list.h"
#include "mapping/disc.h"
#include "mapping/posed_camera.h"
#include "mapping/view_frustum.h"
#include "surfit/mapping/model_renderer.h"

namespace surfit {

// Unstable discs are drawn only where no stable ones are.
enum Layer { kStable, kUnstable, kLayerCount };

// The discs of one layer, by band and there by surfel. A disc on the border of two bands is in
// both.
struct DiscLayer {
  std::vector<Disc> discs;
  BucketList bands;  // of their numbers

  void Add(const Disc& disc);
};

// The discs that a camera may see of a cell of a map.
class DiscList {
 public:
  void Assign(const SurfelMap& map, const SurfelCell& cell, const PosedCamera& camera,
              const ViewFrustum& frustum, const RenderOptions& options, int active_since);

  const DiscLayer& operator[](Layer layer) const { return layers_[layer]; }

 private:
  std::array<DiscLayer, kLayerCount> layers_;
};

}  // namespace surfit
