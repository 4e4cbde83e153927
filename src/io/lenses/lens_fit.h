#pragma once

#include <array>
#include <string>
#include <vector>

#include "surfit/geometry/pinhole_camera.h"

namespace surfit {

// Approximates another lens model by the five coefficients of PinholeCamera, by least squares over
// the image. `camera`: size and intrinsics of the lens; its distortion is ignored.
//
// Models of OpenCV, with x = X/Z, y = Y/Z, r2 = x^2 + y^2:
// - rational: 8 or 12 coefficients k1 k2 p1 p2 k3 k4 k5 k6 s1 s2 s3 s4. The radial factor is
//   (1 + k1 r2 + k2 r2^2 + k3 r2^3) / (1 + k4 r2 + k5 r2^2 + k6 r2^3). The thin prism adds
//   s1 r2 + s2 r2^2 to x and s3 r2 + s4 r2^2 to y.
// - fisheye: 4 coefficients k1 k2 k3 k4. The radius is a (1 + k1 a^2 + k2 a^4 + k3 a^6 + k4 a^8)
// for
//   the angle a = atan(r).
//
// `model`: "fisheye" or "equidistant", or a name of the rational model: "rational",
// "rational_polynomial", "thin_prism". Throws InputError with the name `what` for another model and
// for a wrong number of coefficients. Also throws if the approximation is off by more than 0.5 px.
std::array<double, 5> FitDistortion(const std::string& model, const std::vector<double>& numbers,
                                    const PinholeCamera& camera, const std::string& what);

}  // namespace surfit
