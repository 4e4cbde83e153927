#pragma once

#include <cstdint>
#include <vector>

#include "surfit/core/image.h"
#include "surfit/mapping/surfel_map.h"

namespace surfit::python {

// Surfels of a map as columns, in the order of SurfelMap::Ids().
struct SurfelColumns {
  std::vector<Eigen::Vector3f> position_in_world, normal_in_world;
  std::vector<Rgb8> color;
  std::vector<float> radius_m, confidence;
  std::vector<std::int32_t> first_seen, last_seen;
};

SurfelColumns ColumnsOf(const SurfelMap& map);

}  // namespace surfit::python
