#pragma once

#include <Eigen/Core>

#include "surfit/geometry/pinhole_camera.h"

namespace surfit {

// Projection of a point, or of one point per lane. u and v are unspecified if is_seen is false.
template <typename Scalar>
struct LensPixel {
  using Truth = decltype(Scalar() > Scalar());
  Scalar u = 0, v = 0;  // px
  Truth is_seen{};
};

// Camera with lens distortion (Brown's model, coefficients as in OpenCV). With x = X/Z, y = Y/Z, r2
// = x^2 + y^2 and k = 1 + k1 r2 + k2 r2^2 + k3 r2^3, the pixel of a point is
//   u = fx (x k + 2 p1 x y + p2 (r2 + 2 x^2)) + cx,
//   v = fy (y k + p1 (r2 + 2 y^2) + 2 p2 x y) + cy.
// A point is invisible if Z <= 0, or if the derivative of r k at its r is not positive (invalid
// range of the polynomial). The image border is not tested.
template <typename Scalar>
class Lens {
 public:
  explicit Lens(const PinholeCamera& c)
      : fx_(Scalar(c.fx)),
        fy_(Scalar(c.fy)),
        cx_(Scalar(c.cx)),
        cy_(Scalar(c.cy)),
        k1_(Scalar(c.distortion[0])),
        k2_(Scalar(c.distortion[1])),
        p1_(Scalar(c.distortion[2])),
        p2_(Scalar(c.distortion[3])),
        k3_(Scalar(c.distortion[4])) {}

  // Pixel of a point in the camera frame, m.
  LensPixel<Scalar> Project(const Scalar& point_x, const Scalar& point_y,
                            const Scalar& point_z) const {
    const Scalar x = point_x / point_z, y = point_y / point_z;
    const Scalar r2 = x * x + y * y, xy = x * y;
    const Scalar k = 1 + r2 * (k1_ + r2 * (k2_ + r2 * k3_));
    const Scalar slope = 1 + r2 * (3 * k1_ + r2 * (5 * k2_ + r2 * 7 * k3_));
    LensPixel<Scalar> pixel;
    pixel.u = fx_ * (x * k + 2 * p1_ * xy + p2_ * (r2 + 2 * x * x)) + cx_;
    pixel.v = fy_ * (y * k + p1_ * (r2 + 2 * y * y) + 2 * p2_ * xy) + cy_;
    pixel.is_seen = (point_z > 0) & (slope > 0);
    return pixel;
  }
  LensPixel<Scalar> Project(const Eigen::Matrix<Scalar, 3, 1>& point_in_camera) const {
    return Project(point_in_camera.x(), point_in_camera.y(), point_in_camera.z());
  }

 private:
  Scalar fx_, fy_, cx_, cy_, k1_, k2_, p1_, p2_, k3_;
};

// True if the point is visible, with u in [-0.5, width - 0.5) and v in [-0.5, height - 0.5).
template <typename Scalar>
typename LensPixel<Scalar>::Truth IsInImage(const PinholeCamera& camera,
                                            const LensPixel<Scalar>& pixel) {
  const Scalar first(-0.5), last_u(camera.width - 0.5), last_v(camera.height - 0.5);
  return pixel.is_seen & (pixel.u >= first) & (pixel.v >= first) & (pixel.u < last_u) &
         (pixel.v < last_v);
}

}  // namespace surfit
