#pragma once

#include "registration/residual_rows.h"

namespace surfit {

// What a point that landed in the target's image, or as many as the lanes of V hold, says.
template <typename V>
struct IntensityValues {
  V p[3];              // p', metres
  V residual;          // r
  V slope_u, slope_v;  // dI/du, dI/dv, per px
};

// The row [a r] of r = I(u, v) - ..., u = fx x / z + cx, v = fy y / z + cy, at p' = (x, y, z):
//   dr/dp' = g = (I_u fx / z, I_v fy / z, -(I_u fx x + I_v fy y) / z^2),  a = [p' x g, g].
template <typename V>
void SetPhotometricRow(const IntensityValues<V>& values, double fx, double fy, V* row) {
  const V* p = values.p;
  const V inverse_z = V(1.) / p[2];
  const V x = values.slope_u * V(fx) * inverse_z, y = values.slope_v * V(fy) * inverse_z;
  const V g[3] = {x, y, -(x * p[0] + y * p[1]) * inverse_z};
  SetRow(p, g, values.residual, row);
}

}  // namespace surfit
