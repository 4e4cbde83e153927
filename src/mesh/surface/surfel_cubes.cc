#include "mesh/surface/surfel_cubes.h"

#include <algorithm>

#include "surfit/core/error.h"
#include "surfit/core/parallel.h"

namespace surfit {

SurfelCubes::SurfelCubes(const std::vector<MeshSurfel>& surfels, float cube_m) : cube_m_(cube_m) {
  std::vector<std::pair<std::uint64_t, std::uint32_t>> keyed(surfels.size());
  for (std::size_t i = 0; i < surfels.size(); ++i) {
    const Eigen::Vector3f& p = surfels[i].position;
    const float farthest_m = p.cwiseAbs().maxCoeff();
    ThrowIf(!(farthest_m / cube_m < CubeKey::kMaxCubes - 2), "a point ", farthest_m,
            " m from the origin is too far for cells of ", "this size: increase cell_m");
    keyed[i] = {CubeKey::Of(CubeAt(p)), static_cast<std::uint32_t>(i)};
  }
  std::sort(keyed.begin(), keyed.end());
  surfels_.resize(surfels.size());
  order_.resize(surfels.size());
  for (std::size_t i = 0; i < keyed.size(); ++i) {
    const auto& [key, from] = keyed[i];
    if (i == 0 || key != keys_.back()) {
      keys_.push_back(key);
      begin_.push_back(static_cast<std::uint32_t>(i));
    }
    surfels_[i] = surfels[from];
    order_[i] = from;
  }
  begin_.push_back(static_cast<std::uint32_t>(keyed.size()));
}

void SurfelCubes::FindWithin(const Eigen::Vector3f& low, const Eigen::Vector3f& high,
                             std::vector<Range>* ranges) const {
  ranges->clear();
  const Cube from = CubeAt(low), to = CubeAt(high);
  for (int z = from.z(); z <= to.z(); ++z) {
    for (int y = from.y(); y <= to.y(); ++y) {
      const auto first =
          std::lower_bound(keys_.begin(), keys_.end(), CubeKey::Of({from.x(), y, z}));
      auto last = first;
      const std::uint64_t most = CubeKey::Of({to.x(), y, z});
      while (last != keys_.end() && *last <= most) ++last;
      if (first != last) {
        ranges->push_back({begin_[first - keys_.begin()], begin_[last - keys_.begin()]});
      }
    }
  }
}

}  // namespace surfit
