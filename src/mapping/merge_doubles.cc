#include "surfit/mapping/merge_doubles.h"

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "mapping/merge_gate.h"
#include "mapping/surfel_grid.h"
#include "surfit/core/parallel.h"
#include "surfit/core/trace.h"

namespace surfit {
namespace {

constexpr std::int32_t kNone = -1;

// The frames within which surfels can be the older or the newer of a double at all.
struct FrameRange {
  std::int32_t least_last_seen = std::numeric_limits<std::int32_t>::max();
  std::int32_t most_first_seen = std::numeric_limits<std::int32_t>::min();
};

template <typename F>
void ForEachSurfel(const SurfelMap& map, const F& f) {
  for (std::int32_t cell = 0; cell < map.cell_count(); ++cell) {
    for (const std::int32_t b : map.cell(cell).blocks) {
      for (int k = 0; k < map.block(b).count; ++k) f(b, k);
    }
  }
}

FrameRange RangeOf(const SurfelMap& map) {
  FrameRange range;
  ForEachSurfel(map, [&](std::int32_t b, int k) {
    range.least_last_seen = std::min(range.least_last_seen, map.block(b).last_seen[k]);
    range.most_first_seen = std::max(range.most_first_seen, map.block(b).first_seen[k]);
  });
  return range;
}

Patch PatchAt(const SurfelBlock& block, int k) {
  return {block.x[k], block.y[k], block.z[k], block.nx[k], block.ny[k], block.nz[k]};
}

// Finds the older surfels that newer ones belong to.
class DoubleFinder {
 public:
  DoubleFinder(const FusionOptions& options, int frames_apart, const SurfelMap& map)
      : gate_(options),
        frames_apart_(frames_apart),
        map_(map),
        range_(RangeOf(map)),
        grid_(options.max_distance_m + options.max_spacing_m) {
    if (range_.most_first_seen - range_.least_last_seen <= frames_apart_) return;
    ForEachSurfel(map, [&](std::int32_t b, int k) {
      if (MayBeOlder(map.block(b).last_seen[k])) grid_.Add(PositionOf(map.block(b), k), IdOf(b, k));
    });
  }

  // By id: the older one of each surfel, or kNone. Chains of them lead from newer to older ones.
  std::vector<std::int32_t> FindAll() const {
    std::vector<std::int32_t> older(map_.id_end(), kNone);
    if (grid_.empty()) return older;
    ParallelFor(0, map_.cell_count(), 1, [&](int cell, int) {
      for (const std::int32_t b : map_.cell(cell).blocks) {
        for (int k = 0; k < map_.block(b).count; ++k) {
          if (MayBeNewer(map_.block(b).first_seen[k])) older[IdOf(b, k)] = OlderOf(b, k);
        }
      }
    });
    return older;
  }

 private:
  static std::int32_t IdOf(std::int32_t b, int k) { return b * SurfelBlock::kCapacity + k; }
  static Eigen::Vector3f PositionOf(const SurfelBlock& block, int k) {
    return {block.x[k], block.y[k], block.z[k]};
  }
  bool MayBeOlder(std::int32_t last_seen) const {
    return range_.most_first_seen - last_seen > frames_apart_;
  }
  bool MayBeNewer(std::int32_t first_seen) const {
    return first_seen - range_.least_last_seen > frames_apart_;
  }

  std::int32_t OlderOf(std::int32_t b, int k) const {
    const SurfelBlock& block = map_.block(b);
    const Patch patch = PatchAt(block, k);
    float least = MergeGate::kNever;
    std::int32_t nearest = kNone;
    grid_.ForEachAround(PositionOf(block, k), [&](std::int32_t id) {
      const SurfelBlock& other = map_.block(id / SurfelBlock::kCapacity);
      const int j = id % SurfelBlock::kCapacity;
      if (block.first_seen[k] - other.last_seen[j] <= frames_apart_) return;
      const float distance2 = gate_.SquaredDistance(patch, block.radius_m[k], PatchAt(other, j));
      const bool nearer = distance2 < least || (distance2 == least && id < nearest);
      if (distance2 == MergeGate::kNever || !nearer) return;
      least = distance2;
      nearest = id;
    });
    return nearest;
  }

  const MergeGate gate_;
  const int frames_apart_;
  const SurfelMap& map_;
  const FrameRange range_;
  SurfelGrid grid_;  // of those that may be older
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

std::size_t MergeDoubles(const FusionOptions& options, int frames_apart, SurfelMap* map) {
  options.Validate();
  const TraceSlice slice("merge_doubles");
  const std::vector<std::int32_t> older = DoubleFinder(options, frames_apart, *map).FindAll();
  for (const std::int32_t id : map->Ids()) {
    if (older[id] == kNone) continue;
    std::int32_t oldest = older[id];
    while (older[oldest] != kNone) oldest = older[oldest];
    MergeInto(oldest, id, options, map);
  }
  return map->RemoveMarked();
}

}  // namespace surfit
