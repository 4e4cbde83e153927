#include "surfit/mapping/merge_doubles.h"

#include <algorithm>
#include <limits>
#include <vector>

#include "mapping/merge_gate.h"
#include "mapping/per_surfel.h"
#include "mapping/surfel_grid.h"
#include "surfit/core/options.h"
#include "surfit/core/parallel.h"
#include "surfit/core/trace.h"

namespace surfit {
namespace {

constexpr std::int32_t kNone = -1;
constexpr float kSpacingsPerCube = 3;  // of the grid: larger ones hold many surfels, smaller none

Patch PatchAt(const SurfelBlock& block, int k) {
  return {block.x[k], block.y[k], block.z[k], block.nx[k], block.ny[k], block.nz[k]};
}

Eigen::Vector3f PositionOf(const Patch& patch) { return {patch.x, patch.y, patch.z}; }

// A surfel that may have been mapped before.
struct NewerSurfel {
  std::int32_t id;
  std::int32_t first_seen;
  Patch patch;
  float radius_m;
};

// The newer ones of a cell, and the box that their older ones lie in.
struct NewerOfCell {
  std::vector<NewerSurfel> surfels;
  Eigen::Vector3f low, high;
  std::int32_t most_first_seen = std::numeric_limits<std::int32_t>::min();
};

// Finds the older surfels that newer ones belong to.
class DoubleFinder {
 public:
  DoubleFinder(const FusionOptions& options, const DoublesOptions& doubles, const SurfelMap& map)
      : gate_(options),
        reach_m_(options.merge_distance_m + options.max_spacing_m),
        cube_m_(kSpacingsPerCube * options.max_spacing_m),
        doubles_(doubles),
        map_(map) {}

  // By id: the older one of each surfel, or kNone. Chains of them lead from newer to older ones.
  std::vector<std::int32_t> FindAll() const {
    std::vector<std::int32_t> older(map_.id_end(), kNone);
    ParallelFor(0, map_.cell_count(), 1, [&](int cell, int) {
      const NewerOfCell newer = NewerOf(map_.cell(cell));
      if (newer.surfels.empty()) return;
      const std::vector<GridSurfel> within = OlderWithin(newer);
      if (within.empty()) return;
      const int oldest = std::min_element(within.begin(), within.end(), [](auto& a, auto& b) {
                           return a.last_seen < b.last_seen;
                         })->last_seen;
      const SurfelGrid grid(newer.low, newer.high, cube_m_, within);
      WithInstructions([&](auto instructions) {
        using Number = Lanes<float, decltype(instructions)>;
        for (const NewerSurfel& surfel : newer.surfels) {
          if (surfel.first_seen - oldest <= doubles_.frames_apart) continue;
          older[surfel.id] = NearestTo<Number>(surfel, grid);
        }
      });
    });
    return older;
  }

 private:
  NewerOfCell NewerOf(const SurfelCell& cell) const {
    NewerOfCell newer;
    SurfelBounds bounds;
    for (const std::int32_t b : cell.blocks) {
      const SurfelBlock& block = map_.block(b);
      for (int k = 0; k < block.count; ++k) {
        if (block.first_seen[k] < doubles_.newer_since) continue;
        const Patch patch = PatchAt(block, k);
        newer.surfels.push_back(
            {b * SurfelBlock::kCapacity + k, block.first_seen[k], patch, block.radius_m[k]});
        newer.most_first_seen = std::max(newer.most_first_seen, block.first_seen[k]);
        bounds.Add(PositionOf(patch));
      }
    }
    newer.low = Eigen::Map<const Eigen::Vector3f>(bounds.low).array() - reach_m_;
    newer.high = Eigen::Map<const Eigen::Vector3f>(bounds.high).array() + reach_m_;
    return newer;
  }

  // Whether some of a set may be older ones of these.
  bool MayHaveOlder(const SurfelBounds& bounds, const NewerOfCell& newer) const {
    if (newer.most_first_seen - bounds.least_last_seen <= doubles_.frames_apart) return false;
    for (int axis = 0; axis < 3; ++axis) {
      if (bounds.high[axis] < newer.low[axis] || bounds.low[axis] > newer.high[axis]) return false;
    }
    return true;
  }

  std::vector<GridSurfel> OlderWithin(const NewerOfCell& newer) const {
    std::vector<GridSurfel> older;
    for (std::int32_t cell = 0; cell < map_.cell_count(); ++cell) {
      if (!MayHaveOlder(map_.cell(cell).bounds, newer)) continue;
      for (const std::int32_t b : map_.cell(cell).blocks) {
        if (MayHaveOlder(map_.block(b).bounds, newer)) AddOlder(b, newer, &older);
      }
    }
    return older;
  }

  void AddOlder(std::int32_t b, const NewerOfCell& newer, std::vector<GridSurfel>* older) const {
    const SurfelBlock& block = map_.block(b);
    ForEachBit(MaskOfOlder(block, newer) & MaskOfAll(block), [&](int k) {
      older->push_back({PatchAt(block, k), b * SurfelBlock::kCapacity + k, block.last_seen[k]});
    });
  }

  std::uint64_t MaskOfOlder(const SurfelBlock& block, const NewerOfCell& newer) const {
    return WithInstructions([&](auto) {
      const int seen_before = newer.most_first_seen - doubles_.frames_apart;
      const float *low = newer.low.data(), *high = newer.high.data();
      const PerSurfel<float>&x = block.x, &y = block.y, &z = block.z;
      PerSurfel<std::uint8_t> older;
      for (int k = 0; k < SurfelBlock::kCapacity; ++k) {
        older[k] = (block.last_seen[k] < seen_before) & (x[k] >= low[0]) & (x[k] <= high[0]) &
                   (y[k] >= low[1]) & (y[k] <= high[1]) & (z[k] >= low[2]) & (z[k] <= high[2]);
      }
      return MaskOf(older);
    });
  }

  // Of two that are equally near, the first in the grid.
  template <typename Number>
  std::int32_t NearestTo(const NewerSurfel& newer, const SurfelGrid& grid) const {
    const Patch& p = newer.patch;
    const PatchOf<Number> patch = {p.x, p.y, p.z, p.nx, p.ny, p.nz};
    const Number radius_m = newer.radius_m, seen_before = newer.first_seen - doubles_.frames_apart;
    Number least = MergeGate::kNever, from = 0.;  // and the place that was read from then
    const Eigen::Vector3f reach = gate_.Reach({p.nx, p.ny, p.nz});
    grid.ForEachRowAround(PositionOf(p), reach, [&](int begin, int end) {
      for (int i = begin; i < end; i += Number::kCount) {
        const Number distance2 = gate_.SquaredDistance(grid.Patches<Number>(i), radius_m, patch);
        const auto nearer = (distance2 < least) & (grid.LastSeen<Number>(i) < seen_before);
        least = Select(nearer, distance2, least);
        from = Select(nearer, i, from);
      }
    });
    return LeastOf(least, from, grid);
  }

  template <typename Number>
  static std::int32_t LeastOf(const Number& distances2, const Number& from,
                              const SurfelGrid& grid) {
    float least = MergeGate::kNever;
    int nearest = kNone;
    for (int lane = 0; lane < Number::kCount; ++lane) {
      const int place = static_cast<int>(from[lane]) + lane;
      if (distances2[lane] < least || (distances2[lane] == least && place < nearest)) {
        least = distances2[lane];
        nearest = place;
      }
    }
    return nearest == kNone ? kNone : grid.Id(nearest);
  }

  const MergeGate gate_;
  const float reach_m_, cube_m_;
  const DoublesOptions doubles_;
  const SurfelMap& map_;
};

SurfelObservation AsObservation(const Surfel& seen, float max_radius_m) {
  SurfelObservation observation;
  observation.position_in_world = seen.position_in_world;
  observation.normal_in_world = seen.normal_in_world;
  observation.radius_m = seen.radius_m;
  observation.color = {1.f * seen.color.r, 1.f * seen.color.g, 1.f * seen.color.b};
  observation.weight = observation.color_weight = seen.confidence;
  const bool has_shape = !seen.at_edge && seen.radius_m < max_radius_m;
  observation.shape_weight = has_shape ? seen.confidence : 0;
  observation.at_edge = seen.at_edge;
  return observation;
}

void MergeInto(std::int32_t older, std::int32_t newer, const FusionOptions& options,
               SurfelMap* map) {
  SurfelBlock& block = map->block(older / SurfelBlock::kCapacity);
  const int k = older % SurfelBlock::kCapacity;
  const Surfel seen = (*map)[newer];
  map->Merge(older, AsObservation(seen, options.max_radius_ratio * block.radius_m[k]),
             options.max_confidence);
  block.last_seen[k] = std::max(block.last_seen[k], seen.last_seen);
  map->Mark(newer);
}

}  // namespace

std::size_t MergeDoubles(const FusionOptions& options, const DoublesOptions& doubles,
                         SurfelMap* map) {
  Validate(options);
  const TraceSlice slice("merge_doubles");
  const std::vector<std::int32_t> older = DoubleFinder(options, doubles, *map).FindAll();
  for (const std::int32_t id : map->Ids()) {
    if (older[id] == kNone) continue;
    std::int32_t oldest = older[id];
    while (older[oldest] != kNone) oldest = older[oldest];
    MergeInto(oldest, id, options, map);
  }
  return map->RemoveMarked();
}

}  // namespace surfit
