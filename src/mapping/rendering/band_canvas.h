#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "mapping/map/view_frustum.h"
#include "mapping/rendering/bands.h"
#include "mapping/rendering/posed_camera.h"
#include "surfit/core/lanes.h"
#include "surfit/frame/frame_pyramid.h"
#include "surfit/mapping/model_renderer.h"

namespace surfit {

// Disc of a surfel in an image, for intersections with pixel rays.
//
// The disc has centre p, unit normal n and radius R in the camera frame. The pixel at offset (du,
// dv) from the image of p has the ray r = p / p_z + e with e = (du / fx, dv / fy, 0). This ray
// meets the plane n . X = n . p at the inverse depth
//   rho = (n . r) / (n . p) = 1 / p_z + rho_u du + rho_v dv,
//   rho_u = n_x / (fx n . p),  rho_v = n_y / (fy n . p).
// The intersection r / rho has the offset from the centre
//   r / rho - p = (e - (rho_u du + rho_v dv) p) / rho = R (du a + dv b) / rho,
//   a = (e_x / fx - rho_u p) / R,  b = (e_y / fy - rho_v p) / R.
// Therefore the ray meets the disc if rho > 0 and |du a + dv b|^2 <= rho^2. All values are relative
// to the centre, which avoids cancellation for distant discs.
struct Disc {
  float u, v;                     // image of p, px
  float rho, rho_u, rho_v;        // 1 / p_z and the derivatives, 1/m and 1/(m px)
  float aa, ab, bb;               // |a|^2, 2 a . b, |b|^2
  std::int32_t surfel;            // id in the map
  std::int16_t u_begin, v_begin;  // bounding rectangle in the image, px
  std::uint8_t columns, rows;

  int u_end() const { return u_begin + columns; }
  int v_end() const { return v_begin + rows; }

  // Inverse depth of the intersection, 1/m. Not positive: no intersection.
  float Rho(float pixel_u, float pixel_v) const {
    return rho + rho_u * (pixel_u - u) + rho_v * (pixel_v - v);
  }
};

// Visits the pixels of a disc in the rows [v_begin, v_end), eight at a time: (u, v) to (u + 3, v)
// and (u, v + 1) to (u + 3, v + 1). Pixels can be outside of the rows or the image. If wants(u, v),
// calls f(u, v, met, rho, across2):
//   met: mask of the pixels whose rays meet the disc, without pixels outside;
//   rho: inverse depth of the intersection;
//   across2: rho^2 times the squared distance from the centre, relative to R.
template <typename Instructions, typename Wants, typename F>
void ForEachEightPixels(const Disc& disc, int v_begin, int v_end, const Wants& wants, const F& f) {
  using Numbers = Lanes<float, Instructions>;
  constexpr float kColumns[] = {0, 1, 2, 3, 0, 1, 2, 3}, kRows[] = {0, 0, 0, 0, 1, 1, 1, 1};
  const Numbers columns = Numbers::Load(kColumns), rows = Numbers::Load(kRows);
  const int u_begin = disc.u_begin, u_end = disc.u_end();
  const Numbers u_limit = static_cast<float>(u_end), v_limit = static_cast<float>(v_end);
  const Numbers centre_u = disc.u, centre_v = disc.v;
  const Numbers rho_0 = disc.rho, rho_u = disc.rho_u, rho_v = disc.rho_v;
  const Numbers aa = disc.aa, ab = disc.ab, bb = disc.bb, zero = 0.f;
  for (int v = v_begin; v < v_end; v += 2) {
    const Numbers pixel_v = static_cast<float>(v) + rows;
    const Numbers dv = pixel_v - centre_v;
    const Numbers row_rho = rho_0 + rho_v * dv, ab_dv = ab * dv, bb_dv2 = bb * dv * dv;
    const auto in_rows = pixel_v < v_limit;
    for (int u = u_begin; u < u_end; u += 4) {
      if (!wants(u, v)) continue;
      const Numbers pixel_u = static_cast<float>(u) + columns;
      const Numbers du = pixel_u - centre_u;
      const Numbers rho = row_rho + rho_u * du;
      const Numbers across2 = du * (aa * du + ab_dv) + bb_dv2;
      const auto inside = Numbers::Both(in_rows, pixel_u < u_limit);
      const auto on_disc = Numbers::Both(rho > zero, across2 <= rho * rho);
      f(u, v, Numbers::Both(inside, on_disc), rho, across2);
    }
  }
}

// Unstable discs are drawn only at pixels without stable discs.
enum Layer { kStable, kUnstable, kLayerCount };

// Discs of one layer, sorted by band and then by surfel. A disc can be in several bands.
struct DiscLayer {
  std::vector<Disc> discs;
  BucketList bands;

  void Add(const Disc& disc);
};

// Possibly visible discs of a map cell. Surfels that face away, lie at depth edges or were last
// seen before frame `active_since` have no disc.
class DiscList {
 public:
  // Replaces the discs. Thread-safe for different objects.
  void Assign(const SurfelMap& map, const SurfelCell& cell, const PosedCamera& camera,
              const ViewFrustum& frustum, const RenderOptions& options, int active_since);

  const DiscLayer& operator[](Layer layer) const { return layers_[layer]; }

 private:
  std::array<DiscLayer, kLayerCount> layers_;
};

// Renders one band of the image. Discs are drawn in the order of the surfels, so parallel rendering
// of bands is deterministic. Keeps references to the arguments. Call Draw() for kStable, then for
// kUnstable, and then WriteTo(). Different bands may run in parallel.
class BandCanvas {
 public:
  BandCanvas(int band, const PosedCamera& camera, const DepthNoise& noise,
             const RenderOptions& options);

  // Draws the discs of one layer into pixels without a disc of an earlier layer. The lists must not
  // change until WriteTo(). Aborts above 2^24 discs.
  void Draw(const std::vector<DiscList>& lists, Layer layer);

  // Writes surfel indices, vertices and normals of the rows of the band. Pixels without a disc get
  // no surfel, and vertices and normals of 0.
  void WriteTo(ModelView* view) const;

 private:
  template <typename Instructions>
  void DrawWith(const std::vector<DiscList>& lists, Layer layer);
  template <typename Instructions>
  bool FindFirst(const Disc& disc);
  void FindBacks();
  template <typename Instructions>
  void Pick(const Disc& disc, float id);
  void CloseDrawnPixels();
  template <typename Instructions>
  void WriteLanes(int u, int v, ModelView* view) const;

  const int band_, v_begin_, v_end_;
  const PosedCamera& camera_;
  const DepthNoise noise_;
  const RenderOptions& options_;
  std::vector<const Disc*> discs_;  // the first one stands for pixels without a disc
  // Buffers per pixel, with an extra row because rows are processed in pairs.
  std::vector<float> first_;  // nearest intersection; 0: none
  // Minimum inverse depth to draw: first 0, then the back of the first surface, then infinity.
  std::vector<float> back_;
  std::vector<float> offset2_;  // squared offset of the drawn disc, relative to its radius
  std::vector<float> drawn_;    // index of the disc
};

}  // namespace surfit
