#pragma once

#include <cstdint>

#include "core/float4.h"

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
  float nx, ny, nz;         // n
  std::int32_t surfel;
  std::int16_t u_begin, u_end, v_begin, v_end;  // the pixels [begin, end) to look at
  std::uint8_t red, green, blue;

  // Inverse depth at a pixel.
  float Rho(int pixel_u, int pixel_v) const {
    return rho + rho_u * (static_cast<float>(pixel_u) - u) +
           rho_v * (static_cast<float>(pixel_v) - v);
  }
};

// A disc along one row of pixels, four at a time.
class DiscRow {
 public:
  struct Hits {
    Int4 met;        // mask: the rays that meet the disc
    Float4 rho;      // where: inverse depth
    Float4 across2;  // rho^2 times the squared distance from the centre as a share of R
  };

  DiscRow(const Disc& disc, int v) : u_end_(disc.u_end), u_(AllLanes(disc.u)) {
    const float dv = static_cast<float>(v) - disc.v;
    rho_ = AllLanes(disc.rho + disc.rho_v * dv);
    rho_u_ = AllLanes(disc.rho_u);
    aa_ = AllLanes(disc.aa);
    ab_ = AllLanes(disc.ab * dv);
    bb_ = AllLanes(disc.bb * dv * dv);
  }

  // For the pixels u to u + 3.
  Hits At(int u) const {
    const Int4 pixels = u + kLanes;
    const Float4 du = ToFloat(pixels) - u_;
    const Float4 rho = rho_ + rho_u_ * du;
    const Float4 across2 = du * (aa_ * du + ab_) + bb_;
    const Int4 met = (pixels < u_end_) & (rho > 0.f) & (across2 <= rho * rho);
    return {met, rho, across2};
  }

 private:
  int u_end_;
  Float4 u_, rho_, rho_u_, aa_, ab_, bb_;
};

}  // namespace surfit
