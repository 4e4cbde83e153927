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

// A surfel's disc in the image of a camera: which pixels' rays meet it, and where.
//
// With centre p, unit normal n and radius R in the camera's frame, the pixel (du, dv) away from the
// image of p has the ray r = p / p_z + e, e = (du / fx, dv / fy, 0). It meets the disc's plane
// n . X = n . p where the inverse depth is
//   rho = (n . r) / (n . p) = 1 / p_z + rho_u du + rho_v dv,
//   rho_u = n_x / (fx n . p),  rho_v = n_y / (fy n . p),
// and the point r / rho there is off the centre by
//   r / rho - p = (e - (rho_u du + rho_v dv) p) / rho = R (du a + dv b) / rho,
//   a = (e_x / fx - rho_u p) / R,  b = (e_y / fy - rho_v p) / R.
// So the ray meets the disc if rho > 0 and |du a + dv b|^2 <= rho^2. As all is relative to the
// centre, nothing cancels, however far away the disc is.
struct Disc {
  float u, v;               // the image of p, px
  float rho, rho_u, rho_v;  // 1 / p_z and the derivatives, 1/m and 1/(m px)
  float aa, ab, bb;         // |a|^2, 2 a . b, |b|^2
  std::int32_t surfel;
  std::int16_t u_begin, v_begin;  // the pixels to look at begin here
  std::uint8_t columns, rows;     // and are so many

  int u_end() const { return u_begin + columns; }
  int v_end() const { return v_begin + rows; }

  // Inverse depth at a pixel.
  float Rho(float pixel_u, float pixel_v) const {
    return rho + rho_u * (pixel_u - u) + rho_v * (pixel_v - v);
  }
};

// Looks at the pixels of a disc in the rows [v_begin, v_end), eight at a time: (u, v) to (u + 3,
// v), and below these (u, v + 1) to (u + 3, v + 1). Some of them may be outside of the rows or the
// image. Where wants(u, v), calls f(u, v, met, rho, across2):
//   met: a mask of the pixels whose rays meet the disc, none of them outside;
//   rho: the inverse depth where they do;
//   across2: rho^2 times the squared distance from the centre there, as a share of R.
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

// Unstable discs are drawn only where no stable ones are.
enum Layer { kStable, kUnstable, kLayerCount };

// The discs of one layer, by band and there by surfel. A disc on the border of two bands is in
// both.
struct DiscLayer {
  std::vector<Disc> discs;
  BucketList bands;  // of their numbers

  void Add(const Disc& disc);
};

// The discs that a camera may see of a cell of a map.
class DiscList {
 public:
  void Assign(const SurfelMap& map, const SurfelCell& cell, const PosedCamera& camera,
              const ViewFrustum& frustum, const RenderOptions& options, int active_since);

  const DiscLayer& operator[](Layer layer) const { return layers_[layer]; }

 private:
  std::array<DiscLayer, kLayerCount> layers_;
};

// Draws one band of the image. Nothing in it depends on other bands, and it meets its discs in the
// order of their surfels, so that bands can be drawn at the same time with the same outcome.
class BandCanvas {
 public:
  BandCanvas(int band, const PosedCamera& camera, const DepthNoise& noise,
             const RenderOptions& options);

  // Draws the discs of one layer into the pixels that no layer before it has drawn.
  void Draw(const std::vector<DiscList>& lists, Layer layer);

  // Writes what the pixels see.
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
  struct PixelDiscs;
  void FindDiscs(int v, PixelDiscs* discs, ModelView* view) const;
  template <typename Instructions>
  void WriteLanes(const PixelDiscs& discs, int u, int v, ModelView* view) const;

  const int band_, v_begin_, v_end_;
  const PosedCamera& camera_;
  const DepthNoise noise_;
  const RenderOptions& options_;
  std::vector<const Disc*> discs_;  // by id: those that pixels were open for
  // Per pixel, and one more row, as two are read and written back at once. Depths are inverse, so
  // that nearer ones are larger.
  std::vector<float> first_;  // where the ray meets the first disc; 0 if none
  // What may still be drawn is no farther: all at first, then the first surface, then nothing.
  std::vector<float> back_;
  std::vector<float> offset2_;  // of the disc drawn: squared, as a share of its radius
  std::vector<float> drawn_;    // its id, a whole number
};

}  // namespace surfit
