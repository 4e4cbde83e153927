#include "mesh/surface/vertex_refiner.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "surfit/mapping/surfel_block.h"

namespace surfit {

// What the surfels around a place say about it.
struct VertexRefiner::Around {
  float weight = 0, height = 0;                      // sums of w and of w n . (x - p)
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();  // sum of w n
  float color_weight = 0;
  Eigen::Vector3f color = Eigen::Vector3f::Zero();
  bool is_supported = false;

  float Distance() const { return weight > 0 ? height / weight : 0; }
};

VertexRefiner::Around VertexRefiner::LookAround(const Eigen::Vector3f& place) const {
  Around around;
  for (const SurfelCubes::Range& range : ranges_) {
    for (std::uint32_t i = range.begin; i < range.end; ++i) {
      const MeshSurfel& surfel = surfels_.surfels()[i];
      const Eigen::Vector3f offset = place - surfel.position;
      const float square = offset.squaredNorm();
      const SurfelKernel kernel(surfel, field_.SupportOf(surfel));
      const float weight = kernel.Weight(square);
      if (!(weight > 0)) continue;
      const float height = surfel.normal.dot(offset);
      around.weight += weight;
      around.height += weight * height;
      around.normal += weight * surfel.normal;
      // Colours change faster than heights: of nearer surfels.
      const float share = 1 - square * kernel.per_square;
      const float color_weight = weight * share * share * share * share;
      around.color_weight += color_weight;
      around.color +=
          color_weight * Eigen::Vector3f(surfel.color.r, surfel.color.g, surfel.color.b);
      if (std::abs(height) <= field_.cell_m() &&
          square - height * height <= surfel.reach_m * surfel.reach_m)
        around.is_supported = true;
    }
  }
  return around;
}

void VertexRefiner::Refine(SurfaceVertex* vertex) const {
  const float most_m = field_.cell_m() / 2;
  const Eigen::Vector3f first = vertex->position, seen_side = vertex->normal;
  Around around = LookAround(first);
  for (int i = 0; i < 2; ++i) {
    vertex->normal = around.normal.normalized();
    const Eigen::Vector3f moved = vertex->position - around.Distance() * vertex->normal;
    const Eigen::Vector3f offset = moved - first;
    vertex->position = first + offset * std::min(1.f, most_m / std::max(offset.norm(), most_m));
    around = LookAround(vertex->position);
  }
  vertex->normal = around.normal.normalized();
  const Eigen::Vector3f color =
      around.color / std::max(around.color_weight, std::numeric_limits<float>::min());
  vertex->color = ToRgb8(color);
  vertex->is_supported = around.is_supported && vertex->normal.dot(seen_side) > 0;
}

void VertexRefiner::Refine(std::vector<SurfaceVertex>* vertices) {
  if (vertices->empty()) return;
  Eigen::Vector3f low = vertices->front().position, high = low;
  for (const SurfaceVertex& vertex : *vertices) {
    low = low.cwiseMin(vertex.position);
    high = high.cwiseMax(vertex.position);
  }
  const Eigen::Vector3f margin =
      Eigen::Vector3f::Constant(field_.support_m() + field_.cell_m() / 2);
  surfels_.FindWithin(low - margin, high + margin, &ranges_);
  for (SurfaceVertex& vertex : *vertices) Refine(&vertex);
}

}  // namespace surfit
