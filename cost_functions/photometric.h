#pragma once

#include "cost_functions/point_functor.h"

namespace surfit {

// Photometric residual r = (I(u, v) - i) / sigma, one row: target intensity I minus intensity i of
// the source point. The point R p + t, with (R, t) = target_from_source, projects to the pixel (u,
// v) of the target. It must be in front of the camera, which is not checked. I is linearised at the
// pixel (u0, v0): I(u, v) = I0 + g_u (u - u0) + g_v (v - v0).
struct Photometric : PointFunctor<Photometric, 9, 1> {
  // Intrinsics of the target camera, px.
  Photometric(double focal_u, double focal_v, double center_u, double center_v)
      : fx(focal_u), fy(focal_v), cx(center_u), cy(center_v) {}

  // Sets the point p (source frame, m) with intensity i, and the target intensity I0 with its
  // gradient (per px) at (u0, v0). Intensities and sigma have the same unit.
  void SetPoint(const Eigen::Vector3d& p, double i, double u0, double v0, double intensity,
                const Eigen::Vector2d& gradient, double sigma) {
    Set(0, p);
    data[3] = intensity - i;
    data[4] = gradient.x(), data[5] = gradient.y();
    data[6] = u0, data[7] = v0;
    data[8] = 1 / sigma;
  }

  template <typename T, typename D>
  void AtMovedPoint(const T* y, const D* d, T* residuals) const {
    const T inverse_z = 1. / y[2];
    const T du = y[0] * inverse_z * fx + (cx - d[6]);
    const T dv = y[1] * inverse_z * fy + (cy - d[7]);
    residuals[0] = (du * d[4] + dv * d[5] + d[3]) * d[8];
  }

  double fx, fy, cx, cy;
};

}  // namespace surfit
