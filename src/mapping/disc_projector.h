#pragma once

#include "mapping/disc.h"
#include "mapping/surfel_projector.h"
#include "surfit/mapping/model_renderer.h"

namespace surfit {

// The discs of four surfels that follow each other in the map; fields as in Disc.
struct FourDiscs {
  Int4 seen;  // mask: those that may be seen; the others' fields are meaningless
  Float4 u, v, rho, rho_u, rho_v, aa, ab, bb;
  Vector4 normal;
  Int4 u_begin, u_end, v_begin, v_end;

  // Disc k, without its surfel and colour.
  Disc operator[](int k) const;
};

// Projects the surfels of a map into a camera's image, as discs.
class DiscProjector {
 public:
  DiscProjector(const SurfelMap& map, const PosedCamera& camera, const RenderOptions& options)
      : surfels_(map, camera), camera_(camera), options_(options) {}

  // The discs of the surfels [begin, end), at most four. False if none of them may be seen: they
  // are outside the image, too close, turned away, or so small that they are between the pixels.
  bool Project(int begin, int end, FourDiscs* discs) const;

 private:
  bool FindCentres(const FourCentres& centres, FourDiscs* discs) const;
  bool FindPixels(const Float4& radius, FourDiscs* discs) const;
  void FindShapes(const Vector4& p, const Float4& radius, FourDiscs* discs) const;

  const SurfelProjector surfels_;
  const PosedCamera& camera_;
  const RenderOptions& options_;
};

}  // namespace surfit
