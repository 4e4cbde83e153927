#pragma once

#include <vector>

#include "mesh/surface/distance_field.h"
#include "mesh/surface/surfel_cubes.h"

namespace surfit {

struct SurfaceVertex {
  Eigen::Vector3f position;  // metres
  Eigen::Vector3f normal;    // first any vector to the side that was seen
  Rgb8 color;
  bool is_supported = false;  // by a surfel that faces the same way, and reaches here
};

// Completes vertices of the field's zero by the surfels around them. One for each thread.
class VertexRefiner {
 public:
  VertexRefiner(const DistanceField& field, const SurfelCubes& surfels)
      : field_(field), surfels_(surfels) {}

  // Those of a small part of space.
  void Refine(std::vector<SurfaceVertex>* vertices);

 private:
  struct Around;

  Around LookAround(const Eigen::Vector3f& place) const;
  void Refine(SurfaceVertex* vertex) const;

  const DistanceField& field_;
  const SurfelCubes& surfels_;
  std::vector<SurfelCubes::Range> ranges_;
};

}  // namespace surfit
