#include "mapping/map/block_lanes.h"
#include "mapping/map/surfel_assignment.h"
#include "mapping/rendering/posed_camera.h"
#include "surfit/core/lanes.h"

namespace surfit {

struct CandidateFinder::BlockPixels {
  BlockCentres centre;
  BlockNormals normal;
  alignas(32) PerSurfel<std::int32_t> pixel;
  alignas(32) PerSurfel<float> free_depth_m;
  alignas(32) PerSurfel<float> x, y, z, nx, ny, nz, radius_m;  // measured point at the pixel
  alignas(32) PerSurfel<float> distance2;
};

namespace {

using BlockPixels = CandidateFinder::BlockPixels;

// Projects the surfels into the image. Bit k of the result is set if surfel k is inside the image.
std::uint64_t FindPixels(const SurfelBlock& block, const PosedCamera& camera, BlockPixels* found) {
  FindCentres(block, camera, &found->centre);
  const BlockCentres& c = found->centre;
  const int width = camera.width;
  const float u_limit = static_cast<float>(camera.width);
  const float v_limit = static_cast<float>(camera.height);
  PerSurfel<std::uint8_t> inside;
  for (int k = 0; k < SurfelBlock::kCapacity; ++k) {
    const float u = c.u[k] + 0.5f, v = c.v[k] + 0.5f;
    const bool in = (c.z[k] > kMinDepth) & (u >= 0.f) & (v >= 0.f) & (u < u_limit) & (v < v_limit);
    const int column = static_cast<int>(in ? u : 0.f), row = static_cast<int>(in ? v : 0.f);
    found->pixel[k] = row * width + column;
    inside[k] = in;
  }
  return MaskOf(inside) & MaskOfAll(block);
}

void Gather(std::uint64_t mask, const std::vector<MeasuredPoint>& points,
            const Image<float>& free_depth_m, BlockPixels* found) {
  ForEachBit(mask, [&](int k) {
    const MeasuredPoint& point = points[found->pixel[k]];
    found->x[k] = point.patch.x;
    found->y[k] = point.patch.y;
    found->z[k] = point.patch.z;
    found->nx[k] = point.patch.nx;
    found->ny[k] = point.patch.ny;
    found->nz[k] = point.patch.nz;
    found->radius_m[k] = point.radius_m;
    found->free_depth_m[k] = free_depth_m[found->pixel[k]];
  });
}

std::uint64_t FindFreeSpaceViolations(BlockPixels* p) {
  PerSurfel<std::uint8_t> through;
  for (int k = 0; k < SurfelBlock::kCapacity; ++k) {
    through[k] = p->centre.z[k] < p->free_depth_m[k];
  }
  return MaskOf(through);
}

// Bit k of the result is set if surfel k passes the merge gate with the measured point at its
// pixel.
template <typename Instructions>
std::uint64_t FindMatches(const MergeGate& gate, BlockPixels* p) {
  using Numbers = Lanes<float, Instructions>;
  PerSurfel<std::uint8_t> same;
  const BlockCentres& c = p->centre;
  const BlockNormals& n = p->normal;
  for (int k = 0; k < SurfelBlock::kCapacity; k += Numbers::kCount) {
    const auto at = [k](const PerSurfel<float>& of) { return Numbers::Load(of + k); };
    const PatchOf<Numbers> point = {at(p->x), at(p->y), at(p->z), at(p->nx), at(p->ny), at(p->nz)};
    const PatchOf<Numbers> surfel = {at(c.x), at(c.y), at(c.z), at(n.x), at(n.y), at(n.z)};
    gate.SquaredDistanceOnRay(point, at(p->radius_m), surfel).Store(p->distance2 + k);
  }
  for (int k = 0; k < SurfelBlock::kCapacity; ++k) same[k] = p->distance2[k] < MergeGate::kNever;
  return MaskOf(same);
}

}  // namespace

// Projects a block and prefetches the measurements at its pixels. Bit k of the result is set if
// surfel k is active and inside the image.
std::uint64_t CandidateFinder::Project(const SurfelBlock& block, BlockPixels* p) const {
  const std::uint64_t inside =
      WithInstructions([&](auto) { return FindPixels(block, camera_, p); }) &
      MaskOfActive(block, active_since_);
  ForEachBit(inside, [&](int k) {
    __builtin_prefetch(&points_[p->pixel[k]]);
    __builtin_prefetch(&free_depth_m_[p->pixel[k]]);
  });
  return inside;
}

void CandidateFinder::Judge(std::uint64_t inside, std::int32_t first_id, SurfelBlock* block,
                            BlockPixels* p, std::vector<Candidate>* candidates) const {
  if (inside == 0) return;
  const std::uint64_t same = WithInstructions([&](auto instructions) {
    FindNormals(*block, camera_, &p->normal);
    Gather(inside, points_, free_depth_m_, p);
    block->to_remove |= inside & FindFreeSpaceViolations(p);
    return inside & ~block->to_remove & FindMatches<decltype(instructions)>(gate_, p);
  });
  ForEachBit(same, [&](int k) {
    const Patch patch = {p->centre.x[k], p->centre.y[k], p->centre.z[k],
                         p->normal.x[k], p->normal.y[k], p->normal.z[k]};
    candidates->push_back({patch, block->Radius_m(k), block->Confidence(k), first_id + k,
                           p->pixel[k], p->distance2[k]});
  });
}

void CandidateFinder::Find(const std::vector<std::int32_t>& blocks, SurfelMap* map,
                           std::vector<Candidate>* candidates) const {
  BlockPixels two[2] = {};  // vector code also reads surfels without a pixel
  std::uint64_t inside[2];
  const std::size_t count = blocks.size();
  for (std::size_t i = 0; i <= count; ++i) {
    if (i + 1 < count) FetchShapes(map->block(blocks[i + 1]));
    if (i < count) inside[i % 2] = Project(map->block(blocks[i]), &two[i % 2]);
    if (i == 0) continue;
    const std::size_t before = (i - 1) % 2;
    Judge(inside[before], blocks[i - 1] * SurfelBlock::kCapacity, &map->block(blocks[i - 1]),
          &two[before], candidates);
  }
}

}  // namespace surfit
