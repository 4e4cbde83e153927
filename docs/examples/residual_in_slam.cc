// Custom residual in SLAM, built as a library that programs load at run time:
//   surfit_slam --residual_library=./residual_in_slam.so --residual=soft_plane ...
#include "cost_functions/own_residual.h"
#include "cost_functions/point_functor.h"

// Point-to-plane residual with a small point-to-point part, which limits sliding along bare walls:
// r = ((n . x) n + k (x - (n . x) n)) / sigma, x = R p + t - q. Data: p, q, n, 1 / sigma.
struct SoftPlane : surfit::PointFunctor<SoftPlane, 10, 3> {
  template <typename T, typename D>
  void AtMovedPoint(const T* y, const D* d, T* residuals) const {
    constexpr double k = 0.02;
    const T x[3] = {y[0] - d[3], y[1] - d[4], y[2] - d[5]};
    const T along_normal = x[0] * d[6] + x[1] * d[7] + x[2] * d[8];
    for (int i = 0; i < 3; ++i)
      residuals[i] = (along_normal * d[6 + i] * (1 - k) + x[i] * k) * d[9];
  }
};

extern "C" void SurfitRegisterResiduals() { surfit::RegisterResidual<SoftPlane>("soft_plane"); }
