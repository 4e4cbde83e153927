#include "mapping/map/smooth_map.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/trace.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

constexpr int kPasses = 2;
constexpr float kReachInRadii = 3, kMaxReach_m = 0.03f;
constexpr float kStep_m = 0.001f;
constexpr float kNormalsApart = 0.1f;

struct NearSurfel {
  Eigen::Vector3f position, normal;
  float sigma_m;
  float weight;
};

class NeighbourGrid {
 public:
  NeighbourGrid(const Eigen::Vector3f& low, const Eigen::Vector3f& high,
                const std::vector<NearSurfel>& neighbours)
      : low_(low), size_(CubeAt(high) + Cube::Ones()), sorted_(neighbours.size()) {
    begin_.assign(static_cast<std::size_t>(size_.prod()) + 1, 0);
    for (const NearSurfel& one : neighbours) ++begin_[IndexOf(CubeAt(one.position)) + 1];
    for (std::size_t c = 1; c < begin_.size(); ++c) begin_[c] += begin_[c - 1];
    std::vector<int> next(begin_.begin(), begin_.end() - 1);
    for (const NearSurfel& one : neighbours) sorted_[next[IndexOf(CubeAt(one.position))]++] = one;
  }

  // Calls f(surfel) for all surfels within `reach_m` of `position` along each axis, and for some
  // farther surfels.
  template <typename F>
  void ForEachAround(const Eigen::Vector3f& position, float reach_m, const F& f) const {
    const Eigen::Vector3f margin = Eigen::Vector3f::Constant(reach_m);
    const Cube from = CubeAt(position - margin).cwiseMax(0);
    const Cube to = CubeAt(position + margin).cwiseMin(size_ - Cube::Ones());
    for (int z = from.z(); z <= to.z(); ++z) {
      for (int y = from.y(); y <= to.y(); ++y) {
        const int end = begin_[IndexOf({to.x(), y, z}) + 1];
        for (int i = begin_[IndexOf({from.x(), y, z})]; i < end; ++i) f(sorted_[i]);
      }
    }
  }

 private:
  using Cube = Eigen::Vector3i;
  static constexpr float kCube_m = 0.02f;

  Cube CubeAt(const Eigen::Vector3f& position) const {
    return ((position - low_) / kCube_m).array().floor().cast<int>();
  }
  int IndexOf(const Cube& cube) const {
    return (cube.z() * size_.y() + cube.y()) * size_.x() + cube.x();
  }

  const Eigen::Vector3f low_;
  const Cube size_;
  std::vector<NearSurfel> sorted_;
  std::vector<int> begin_;
};

struct Moved {
  Eigen::Vector3f position, normal;
};

class Smoothing {
 public:
  Smoothing(const DepthSensor& sensor, SurfelMap* map)
      : focal_px_(static_cast<float>(sensor.camera.fx)),
        inverse_depth_sigma_(static_cast<float>(sensor.noise.inverse_depth_sigma)),
        map_(*map),
        moved_(map_.id_end()) {}

  void Pass() {
    ParallelFor(0, map_.cell_count(), 1, [&](int cell, int) { FindMoved(map_.cell(cell)); });
    ParallelFor(0, map_.cell_count(), 1, [&](int cell, int) { Move(&map_.cell(cell)); });
  }

 private:
  template <typename F>
  void ForEach(const SurfelCell& cell, const F& f) const {
    for (const std::int32_t b : cell.blocks) {
      for (int k = 0; k < map_.block(b).count; ++k) f(b * SurfelBlock::kCapacity + k);
    }
  }

  void FindMoved(const SurfelCell& cell) {
    if (cell.blocks.empty()) return;
    const Eigen::Vector3f margin = Eigen::Vector3f::Constant(kMaxReach_m);
    const Eigen::Vector3f low = Eigen::Map<const Eigen::Vector3f>(cell.bounds.low) - margin;
    const Eigen::Vector3f high = Eigen::Map<const Eigen::Vector3f>(cell.bounds.high) + margin;
    const NeighbourGrid grid(low, high, Within(low, high));
    ForEach(cell, [&](std::int32_t id) { moved_[id] = MovedBy(grid, map_[id]); });
  }

  std::vector<NearSurfel> Within(const Eigen::Vector3f& low, const Eigen::Vector3f& high) const {
    std::vector<NearSurfel> within;
    for (std::int32_t i = 0; i < map_.cell_count(); ++i) {
      if (!Meets(map_.cell(i).bounds, low, high)) continue;
      for (const std::int32_t b : map_.cell(i).blocks) {
        if (Meets(map_.block(b).bounds, low, high)) AddWithin(map_.block(b), low, high, &within);
      }
    }
    return within;
  }

  static bool Meets(const SurfelBounds& bounds, const Eigen::Vector3f& low,
                    const Eigen::Vector3f& high) {
    return (Eigen::Map<const Eigen::Vector3f>(bounds.high).array() >= low.array()).all() &&
           (Eigen::Map<const Eigen::Vector3f>(bounds.low).array() <= high.array()).all();
  }

  void AddWithin(const SurfelBlock& block, const Eigen::Vector3f& low, const Eigen::Vector3f& high,
                 std::vector<NearSurfel>* within) const {
    for (int k = 0; k < block.count; ++k) {
      const Surfel surfel = block[k];
      const Eigen::Vector3f& p = surfel.position_in_world;
      // normals at depth edges are copied from neighbour pixels
      if (surfel.at_edge || !(p.array() >= low.array()).all() ||
          !(p.array() <= high.array()).all()) {
        continue;
      }
      within->push_back({p, surfel.normal_in_world, SigmaOf(surfel), surfel.confidence});
    }
  }

  // Standard deviation of the position along the normal, m. The depth z of the surfel follows from
  // radius = sqrt(2) z / focal length.
  float SigmaOf(const Surfel& surfel) const {
    const float z = surfel.radius_m * focal_px_ / std::sqrt(2.f);
    return inverse_depth_sigma_ * z * z / std::sqrt(std::max(surfel.confidence, 1.f));
  }

  Moved MovedBy(const NeighbourGrid& grid, const Surfel& surfel) const {
    const Eigen::Vector3f &p = surfel.position_in_world, &n = surfel.normal_in_world;
    const float reach = std::min(kReachInRadii * surfel.radius_m, kMaxReach_m);
    const float sigma = SigmaOf(surfel), per_reach2 = 1 / (reach * reach);
    float weights = 0, sum = 0;
    Eigen::Vector3f normals = Eigen::Vector3f::Zero();
    grid.ForEachAround(p, reach, [&](const NearSurfel& other) {
      const Eigen::Vector3f way = other.position - p;
      const float d2 = way.squaredNorm() * per_reach2, cosine = n.dot(other.normal);
      if (d2 > 1.f || cosine < 1.f - kNormalsApart) return;
      const float h = other.normal.dot(way) / cosine;
      const float share = h / (kStep_m + sigma + other.sigma_m);
      const float weight = other.weight * std::exp(-2.f * d2 - share * share) *
                           (1.f - (1.f - cosine) / kNormalsApart);
      weights += weight;
      sum += weight * h;
      normals += weight * other.normal;
    });
    if (!(weights > 0)) return {p, n};
    return {p + sum / weights * n, normals.normalized()};
  }

  void Move(SurfelCell* cell) {
    for (const std::int32_t b : cell->blocks) {
      SurfelBlock& block = map_.block(b);
      for (int k = 0; k < block.count; ++k) {
        const Moved& to = moved_[b * SurfelBlock::kCapacity + k];
        block.SetPosition(k, to.position);
        block.SetNormal(k, to.normal);
        block.bounds.Add(block.Position(k));
      }
      cell->bounds.Add(block.bounds);
    }
  }

  const float focal_px_, inverse_depth_sigma_;
  SurfelMap& map_;
  std::vector<Moved> moved_;  // index: surfel id
};

}  // namespace

void SmoothMap(const DepthSensor& sensor, SurfelMap* map) {
  const TraceSlice slice("smooth_map");
  Smoothing smoothing(sensor, map);
  for (int pass = 0; pass < kPasses; ++pass) smoothing.Pass();
}

}  // namespace surfit
