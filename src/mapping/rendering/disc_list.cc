#include <algorithm>

#include "mapping/map/block_lanes.h"
#include "mapping/rendering/band_canvas.h"
#include "mapping/rendering/bands.h"
#include "mapping/rendering/posed_camera.h"
#include "surfit/core/lanes.h"
#include "surfit/mapping/model_renderer.h"

namespace surfit {
namespace {

struct BlockDiscs {
  BlockCentres centre;
  alignas(32) PerSurfel<float> rho_u, rho_v, aa, ab, bb;
  alignas(32) PerSurfel<std::int32_t> u_begin, u_end, v_begin, v_end;

  Disc Get(int k, std::int32_t surfel) const {
    Disc disc;
    disc.surfel = surfel;
    disc.u = centre.u[k];
    disc.v = centre.v[k];
    disc.rho = centre.rho[k];
    disc.rho_u = rho_u[k];
    disc.rho_v = rho_v[k];
    disc.aa = aa[k];
    disc.ab = ab[k];
    disc.bb = bb[k];
    disc.u_begin = static_cast<std::int16_t>(u_begin[k]);
    disc.v_begin = static_cast<std::int16_t>(v_begin[k]);
    disc.columns = static_cast<std::uint8_t>(u_end[k] - u_begin[k]);
    disc.rows = static_cast<std::uint8_t>(v_end[k] - v_begin[k]);
    return disc;
  }
};

// Minimum sine of the viewing angle. Prevents overflow of rho_u and rho_v.
constexpr float kMinSine = 1e-6f;

// Floor of x for -1024 < x < 2^22, faster than std::floor.
std::int32_t FloorOf(float x) { return static_cast<std::int32_t>(x + 1024.f) - 1024; }

// Computes the bounding rectangles of the discs. Bit k of the result is set if disc k is in the
// image and deeper than kMinDepth.
std::uint64_t FindPixels(const SurfelBlock& block, const PosedCamera& camera,
                         const RenderOptions& options, BlockDiscs* discs) {
  FindCentres(block, camera, &discs->centre);
  const BlockCentres& c = discs->centre;
  const float margin = static_cast<float>(options.max_half_window_px);
  const float u_limit = static_cast<float>(camera.width) + margin;
  const float v_limit = static_cast<float>(camera.height) + margin;
  const float scale = camera.fx * options.radius_ratio;
  const int width = camera.width, height = camera.height;
  PerSurfel<std::uint8_t> seen;
  for (int k = 0; k < SurfelBlock::kCapacity; ++k) {
    const bool near = (c.z[k] > kMinDepth) & (c.u[k] > -margin) & (c.u[k] < u_limit) &
                      (c.v[k] > -margin) & (c.v[k] < v_limit);
    const float u = near ? c.u[k] : 0.f, v = near ? c.v[k] : 0.f;
    const float window = scale * SmallLength::ToFloat(block.radius[k]) * c.rho[k];
    const float extent = window < margin ? window : margin;
    const std::int32_t u_begin = std::max(0, FloorOf(u - extent) + 1);
    const std::int32_t v_begin = std::max(0, FloorOf(v - extent) + 1);
    const std::int32_t u_end = std::min(width, FloorOf(u + extent) + 1);
    const std::int32_t v_end = std::min(height, FloorOf(v + extent) + 1);
    discs->u_begin[k] = u_begin;
    discs->v_begin[k] = v_begin;
    discs->u_end[k] = u_end;
    discs->v_end[k] = v_end;
    seen[k] = near & (u_begin < u_end) & (v_begin < v_end);
  }
  return MaskOf(seen) & MaskOfAll(block);
}

// Bit k of the result is set if disc k faces the camera.
std::uint64_t FindShapes(const SurfelBlock& block, const PosedCamera& camera,
                         const RenderOptions& options, BlockDiscs* discs) {
  BlockNormals n;
  FindNormals(block, camera, &n);
  const BlockCentres& p = discs->centre;
  const float pixel_x = 1.f / camera.fx, pixel_y = 1.f / camera.fy;
  const float radius_ratio = options.radius_ratio;
  PerSurfel<std::uint8_t> seen;
  for (int k = 0; k < SurfelBlock::kCapacity; ++k) {
    const float px = p.x[k], py = p.y[k], pz = p.z[k];
    const float along = n.x[k] * px + n.y[k] * py + n.z[k] * pz;
    const float radius_m = SmallLength::ToFloat(block.radius[k]);
    const float share = 1.f / (radius_ratio * radius_m), inverse = 1.f / along;
    const float rho_u = pixel_x * n.x[k] * inverse, rho_v = pixel_y * n.y[k] * inverse;
    const float a_p = -share * rho_u, b_p = -share * rho_v;
    const float ax = share * pixel_x + a_p * px, ay = a_p * py, az = a_p * pz;
    const float bx = b_p * px, by = share * pixel_y + b_p * py, bz = b_p * pz;
    discs->rho_u[k] = rho_u;
    discs->rho_v[k] = rho_v;
    discs->aa[k] = ax * ax + ay * ay + az * az;
    discs->ab[k] = 2.f * (ax * bx + ay * by + az * bz);
    discs->bb[k] = bx * bx + by * by + bz * bz;
    seen[k] = along < -kMinSine * pz;
  }
  return MaskOf(seen);
}

std::uint64_t FindDiscs(const SurfelBlock& block, const PosedCamera& camera,
                        const RenderOptions& options, BlockDiscs* discs) {
  return WithInstructions([&](auto) {
    const std::uint64_t in_image = FindPixels(block, camera, options, discs) & ~block.at_edge;
    return in_image == 0 ? in_image : in_image & FindShapes(block, camera, options, discs);
  });
}

}  // namespace

void DiscLayer::Add(const Disc& disc) {
  const int number = static_cast<int>(discs.size()), last = (disc.v_end() - 1) / kBandRows;
  discs.push_back(disc);
  for (int band = disc.v_begin / kBandRows; band <= last; ++band) bands.Add(number, band);
}

void DiscList::Assign(const SurfelMap& map, const SurfelCell& cell, const PosedCamera& camera,
                      const ViewFrustum& frustum, const RenderOptions& options, int active_since) {
  for (DiscLayer& layer : layers_) {
    ClearClosely(cell.blocks.size() * SurfelBlock::kCapacity, &layer.discs);
    layer.bands.Clear(BandCount(camera.height));
  }
  BlockDiscs discs;
  for (std::size_t i = 0; i < cell.blocks.size(); ++i) {
    const std::int32_t b = cell.blocks[i];
    const SurfelBlock& block = map.block(b);
    FetchShapes(map.block(cell.blocks[std::min(i + 1, cell.blocks.size() - 1)]));
    if (!frustum.MaySee(block.bounds)) continue;
    const std::uint64_t seen =
        FindDiscs(block, camera, options, &discs) & MaskOfActive(block, active_since);
    ForEachBit(seen, [&](int k) {
      const Layer layer = block.Confidence(k) >= options.stable_confidence ? kStable : kUnstable;
      layers_[layer].Add(discs.Get(k, b * SurfelBlock::kCapacity + k));
    });
  }
}

}  // namespace surfit
