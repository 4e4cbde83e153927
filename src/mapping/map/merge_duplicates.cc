#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <unordered_map>
#include <vector>

#include "core/trace.h"
#include "mapping/map/block_lanes.h"
#include "mapping/map/merge_gate.h"
#include "surfit/core/options.h"
#include "surfit/core/parallel.h"
#include "surfit/mapping/fusion.h"

namespace surfit {
namespace {

struct GridSurfel {
  Patch patch = {};
  std::int32_t id = 0;
  std::int32_t last_seen = 0;
};

// Surfels of a box, sorted by grid cube. Neighbour searches load consecutive surfels into vectors.
class SurfelGrid {
 public:
  // `low`, `high`: corners of the box, which must contain all surfels. `cube_m`: minimum edge
  // length of a cube. A large box gets larger cubes.
  SurfelGrid(const Eigen::Vector3f& low, const Eigen::Vector3f& high, float cube_m,
             const std::vector<GridSurfel>& surfels)
      : low_(low), ids_(surfels.size()) {
    const float longest = (high - low).maxCoeff();
    per_metre_ = 1 / std::max(cube_m, longest / kMaxCubes);
    size_ = CubeAt(high) + Cube::Ones();
    std::vector<int> cube_of(surfels.size());
    begin_.assign(size_.prod() + 1, 0);
    for (std::size_t i = 0; i < surfels.size(); ++i) {
      const Patch& p = surfels[i].patch;
      cube_of[i] = IndexOf(CubeAt({p.x, p.y, p.z}));
      ++begin_[cube_of[i] + 1];
    }
    for (std::size_t c = 1; c < begin_.size(); ++c) begin_[c] += begin_[c - 1];
    std::vector<int> next(begin_.begin(), begin_.end() - 1);
    for (auto& numbers : numbers_) numbers.resize(surfels.size() + kPadding, kNowhere);
    for (std::size_t i = 0; i < surfels.size(); ++i) Set(next[cube_of[i]]++, surfels[i]);
  }

  // Calls f(begin, end) for ranges of sorted indices. The ranges contain all surfels within
  // `margin` of `position` along each axis, and some farther surfels.
  template <typename F>
  void ForEachRowAround(const Eigen::Vector3f& position, const Eigen::Vector3f& margin,
                        const F& f) const {
    const Cube from = CubeAt(position - margin).cwiseMax(0);
    const Cube to = CubeAt(position + margin).cwiseMin(size_ - Cube::Ones());
    for (int z = from.z(); z <= to.z(); ++z) {
      for (int y = from.y(); y <= to.y(); ++y) {
        const int begin = begin_[IndexOf({from.x(), y, z})];
        const int end = begin_[IndexOf({to.x(), y, z}) + 1];
        if (begin < end) f(begin, end);
      }
    }
  }

  // Loads the patches of consecutive surfels. `place`: sorted index of the first surfel. Vector
  // lanes after the last surfel are NaN.
  template <typename Number>
  PatchOf<Number> Patches(int place) const {
    const auto load = [&](int i) { return Number::Load(&numbers_[i][place]); };
    return {load(0), load(1), load(2), load(3), load(4), load(5)};
  }
  // Loads the last observation frames of consecutive surfels. A float represents frame indices up
  // to 2^24 exactly.
  template <typename Number>
  Number LastSeen(int place) const {
    return Number::Load(&numbers_[6][place]);
  }
  std::int32_t Id(int place) const { return ids_[place]; }

 private:
  using Cube = Eigen::Vector3i;
  static constexpr int kMaxCubes = 64;  // along each axis
  static constexpr int kPadding = 8;
  // Value of padding entries. NaN fails every comparison.
  static constexpr float kNowhere = std::numeric_limits<float>::quiet_NaN();

  void Set(int place, const GridSurfel& surfel) {
    const Patch& p = surfel.patch;
    const float numbers[] = {p.x, p.y, p.z, p.nx, p.ny, p.nz, static_cast<float>(surfel.last_seen)};
    for (std::size_t i = 0; i < numbers_.size(); ++i) numbers_[i][place] = numbers[i];
    ids_[place] = surfel.id;
  }

  Cube CubeAt(const Eigen::Vector3f& position) const {
    return (per_metre_ * (position - low_)).array().floor().cast<int>();
  }
  int IndexOf(const Cube& cube) const {
    return (cube.z() * size_.y() + cube.y()) * size_.x() + cube.x();
  }

  Eigen::Vector3f low_;
  float per_metre_ = 0;
  Cube size_ = Cube::Ones();
  std::array<std::vector<float>, 7> numbers_;
  std::vector<std::int32_t> ids_;
  std::vector<int> begin_;
};

constexpr std::int32_t kNobody = -1;
// Trade-off: large cubes contain many unrelated surfels. Small cubes are mostly empty.
constexpr float kSpacingsPerCube = 3;

Patch PatchAt(const SurfelBlock& block, int k) {
  const Eigen::Vector3f n = block.Normal(k);
  return {block.X(k), block.Y(k), block.Z(k), n.x(), n.y(), n.z()};
}

Eigen::Vector3f PositionOf(const Patch& patch) { return {patch.x, patch.y, patch.z}; }

// Finds the cells of a map near a box, without a loop over all cells.
class CellIndex {
 public:
  explicit CellIndex(const SurfelMap& map) {
    for (std::int32_t i = 0; i < map.cell_count(); ++i) {
      const SurfelBounds& bounds = map.cell(i).bounds;
      if (bounds.empty()) continue;
      const Cubes cubes(bounds.low, bounds.high);
      cubes.ForEach([&](std::uint64_t key) { cells_[key].push_back(i); });
    }
  }

  // Ascending indices of cells that contain all cells whose bounds intersect the box.
  std::vector<std::int32_t> CellsNear(const Eigen::Vector3f& low,
                                      const Eigen::Vector3f& high) const {
    std::vector<std::int32_t> near;
    Cubes(low.data(), high.data()).ForEach([&](std::uint64_t key) {
      const auto at = cells_.find(key);
      if (at != cells_.end()) near.insert(near.end(), at->second.begin(), at->second.end());
    });
    std::sort(near.begin(), near.end());
    near.erase(std::unique(near.begin(), near.end()), near.end());
    return near;
  }

 private:
  // Cubes of the size of cells that overlap a box.
  class Cubes {
   public:
    Cubes(const float* low, const float* high) {
      for (int axis = 0; axis < 3; ++axis) {
        first_[axis] = IndexOf(low[axis]);
        last_[axis] = IndexOf(high[axis]);
      }
    }
    template <typename F>
    void ForEach(const F& f) const {
      for (std::int64_t x = first_[0]; x <= last_[0]; ++x) {
        for (std::int64_t y = first_[1]; y <= last_[1]; ++y) {
          for (std::int64_t z = first_[2]; z <= last_[2]; ++z)
            f(static_cast<std::uint64_t>((x << kBits | y) << kBits | z));
        }
      }
    }

   private:
    static constexpr int kBits = 20;
    // Positions beyond the range belong to the outermost cube.
    static std::int64_t IndexOf(float coordinate) {
      constexpr float kHalf = 1 << (kBits - 1);
      const float index = std::floor(coordinate / SurfelMap::kCellSize);
      return static_cast<std::int64_t>(std::max(-kHalf, std::min(index, kHalf - 1)) + kHalf);
    }
    std::array<std::int64_t, 3> first_, last_;
  };

  std::unordered_map<std::uint64_t, std::vector<std::int32_t>> cells_;
};

struct NewerSurfel {
  std::int32_t id;
  std::int32_t first_seen;
  Patch patch;
  float radius_m;
};

struct NewerOfCell {
  std::vector<NewerSurfel> surfels;
  Eigen::Vector3f low, high;
  std::int32_t most_first_seen = std::numeric_limits<std::int32_t>::min();
};

class DuplicateFinder {
 public:
  DuplicateFinder(const FusionOptions& options, const DuplicateOptions& doubles,
                  const SurfelMap& map)
      : gate_(options),
        reach_m_(options.merge_distance_m + options.max_spacing_m),
        cube_m_(kSpacingsPerCube * options.max_spacing_m),
        duplicates_(doubles),
        map_(map),
        cells_(map) {}

  // Entry i is the id of an older duplicate of surfel i, or kNobody. An older duplicate can have an
  // even older duplicate.
  std::vector<std::int32_t> FindAll() const {
    std::vector<std::int32_t> older(map_.id_end(), kNobody);
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
          if (surfel.first_seen - oldest <= duplicates_.frames_apart) continue;
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
        if (block.FirstSeen(k) < duplicates_.newer_since) continue;
        const Patch patch = PatchAt(block, k);
        newer.surfels.push_back(
            {b * SurfelBlock::kCapacity + k, block.FirstSeen(k), patch, block.Radius_m(k)});
        newer.most_first_seen = std::max(newer.most_first_seen, block.FirstSeen(k));
        bounds.Add(PositionOf(patch));
      }
    }
    newer.low = Eigen::Map<const Eigen::Vector3f>(bounds.low).array() - reach_m_;
    newer.high = Eigen::Map<const Eigen::Vector3f>(bounds.high).array() + reach_m_;
    return newer;
  }

  // False: no surfel inside `bounds` is an older duplicate of a surfel in `newer`.
  bool MayHaveOlder(const SurfelBounds& bounds, const NewerOfCell& newer) const {
    if (newer.most_first_seen - bounds.least_last_seen <= duplicates_.frames_apart) return false;
    for (int axis = 0; axis < 3; ++axis) {
      if (bounds.high[axis] < newer.low[axis] || bounds.low[axis] > newer.high[axis]) return false;
    }
    return true;
  }

  std::vector<GridSurfel> OlderWithin(const NewerOfCell& newer) const {
    std::vector<GridSurfel> older;
    for (const std::int32_t cell : cells_.CellsNear(newer.low, newer.high)) {
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
      older->push_back({PatchAt(block, k), b * SurfelBlock::kCapacity + k, block.LastSeen(k)});
    });
  }

  std::uint64_t MaskOfOlder(const SurfelBlock& block, const NewerOfCell& newer) const {
    return WithInstructions([&](auto) {
      const int seen_before = newer.most_first_seen - duplicates_.frames_apart;
      const float *low = newer.low.data(), *high = newer.high.data();
      PerSurfel<std::uint8_t> older;
      for (int k = 0; k < SurfelBlock::kCapacity; ++k) {
        const float x = block.X(k), y = block.Y(k), z = block.Z(k);
        older[k] = (block.LastSeen(k) < seen_before) & (x >= low[0]) & (x <= high[0]) &
                   (y >= low[1]) & (y <= high[1]) & (z >= low[2]) & (z <= high[2]);
      }
      return MaskOf(older);
    });
  }

  // Id of the nearest older duplicate. If distances are equal, the first surfel in grid order wins.
  template <typename Number>
  std::int32_t NearestTo(const NewerSurfel& newer, const SurfelGrid& grid) const {
    const Patch& p = newer.patch;
    const PatchOf<Number> patch = {p.x, p.y, p.z, p.nx, p.ny, p.nz};
    const Number radius_m = newer.radius_m,
                 seen_before = newer.first_seen - duplicates_.frames_apart;
    Number least = MergeGate::kNever, from = 0.;
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
    int nearest = kNobody;
    for (int lane = 0; lane < Number::kCount; ++lane) {
      const int place = static_cast<int>(from[lane]) + lane;
      if (distances2[lane] < least || (distances2[lane] == least && place < nearest)) {
        least = distances2[lane];
        nearest = place;
      }
    }
    return nearest == kNobody ? kNobody : grid.Id(nearest);
  }

  const MergeGate gate_;
  const float reach_m_, cube_m_;
  const DuplicateOptions duplicates_;
  const SurfelMap& map_;
  const CellIndex cells_;
};

SurfelObservation AsObservation(const Surfel& seen, float max_radius_m) {
  SurfelObservation observation;
  observation.position_in_world = seen.position_in_world;
  observation.normal_in_world = seen.normal_in_world;
  observation.radius_m = seen.radius_m;
  observation.color = {1.f * seen.color.r, 1.f * seen.color.g, 1.f * seen.color.b};
  observation.color_weight = seen.color_weight;
  observation.weight = seen.confidence;
  const bool has_shape = !seen.at_edge && seen.radius_m < max_radius_m;
  observation.shape_weight = has_shape ? seen.confidence : 0;
  observation.at_edge = seen.at_edge;
  return observation;
}

void MergeInto(std::int32_t older, std::int32_t newer, SurfelMap* map) {
  SurfelBlock& block = map->block(older / SurfelBlock::kCapacity);
  const int k = older % SurfelBlock::kCapacity;
  const Surfel seen = (*map)[newer];
  map->Merge(older, AsObservation(seen, FusionOptions::kMaxRadiusRatio * block.Radius_m(k)),
             FusionOptions::kMaxConfidence);
  block.SetLastSeen(k, std::max(block.LastSeen(k), seen.last_seen));
  map->Mark(newer);
}

}  // namespace

std::size_t MergeDuplicates(const FusionOptions& options, const DuplicateOptions& doubles,
                            SurfelMap* map) {
  Validate(options);
  const TraceSlice slice("merge_duplicates");
  const std::vector<std::int32_t> older = DuplicateFinder(options, doubles, *map).FindAll();
  for (const std::int32_t id : map->Ids()) {
    if (older[id] == kNobody) continue;
    std::int32_t oldest = older[id];
    while (older[oldest] != kNobody) oldest = older[oldest];
    MergeInto(oldest, id, map);
  }
  return map->RemoveMarked();
}

}  // namespace surfit
