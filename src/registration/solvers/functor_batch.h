#pragma once

#include <array>
#include <cmath>
#include <utility>

#include "cost_functions/batch_data.h"
#include "cost_functions/photometric.h"
#include "cost_functions/plane_to_plane.h"
#include "cost_functions/point_to_plane.h"
#include "cost_functions/point_to_point.h"
#include "cost_functions/symmetric_point_to_plane.h"
#include "registration/icp/photometric_term.h"
#include "registration/icp/residual_rows.h"
#include "surfit/core/parallel.h"

namespace surfit {

// Data of the functors in cost_functions/ from pairs with arrays of exact size. Source points are
// already transformed. The pose starts at the identity, so the estimated pose is the left
// increment.

template <typename S>
RawVector<S> InverseSigmas(RawVector<S> information) {
  ParallelFor(0, static_cast<int>(information.size()), 4096, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) information[i] = std::sqrt(information[i]);
  });
  return information;
}

template <typename S>
BatchData<PointToPoint, S> MakeBatch(Pairs<S> pairs, const PointToPoint&) {
  return BatchData<PointToPoint, S>({std::move(pairs.px), std::move(pairs.py), std::move(pairs.pz),
                                     std::move(pairs.qx), std::move(pairs.qy), std::move(pairs.qz),
                                     InverseSigmas(std::move(pairs.information))});
}

template <typename S>
BatchData<PointToPlane, S> MakeBatch(Pairs<S> pairs, const PointToPlane&) {
  return BatchData<PointToPlane, S>({std::move(pairs.px), std::move(pairs.py), std::move(pairs.pz),
                                     std::move(pairs.qx), std::move(pairs.qy), std::move(pairs.qz),
                                     std::move(pairs.nx), std::move(pairs.ny), std::move(pairs.nz),
                                     InverseSigmas(std::move(pairs.information))});
}

template <typename S>
BatchData<SymmetricPointToPlane, S> MakeBatch(Pairs<S> pairs, const SymmetricPointToPlane&) {
  return BatchData<SymmetricPointToPlane, S>(
      {std::move(pairs.px), std::move(pairs.py), std::move(pairs.pz), std::move(pairs.qx),
       std::move(pairs.qy), std::move(pairs.qz), std::move(pairs.nx), std::move(pairs.ny),
       std::move(pairs.nz), std::move(pairs.mx), std::move(pairs.my), std::move(pairs.mz),
       InverseSigmas(std::move(pairs.information))});
}

// The whitening matrix is evaluated at the current rotation.
template <typename S>
BatchData<PlaneToPlane, S> MakeBatch(Pairs<S> pairs, const PlaneToPlane&) {
  constexpr int kEntries = 6;
  std::array<RawVector<S>, kEntries> whitening;
  for (auto& array : whitening) array.resize(pairs.size);
  const RawVector<S> inverse_sigma = InverseSigmas(std::move(pairs.information));
  ParallelFor(0, pairs.size, 4096, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      S u[kEntries];
      PlaneToPlaneRows::Whitening<S>(pairs.n(i).data(), pairs.m(i).data(), u);
      for (int k = 0; k < kEntries; ++k) whitening[k][i] = u[k] * inverse_sigma[i];
    }
  });
  return BatchData<PlaneToPlane, S>({std::move(pairs.px), std::move(pairs.py), std::move(pairs.pz),
                                     std::move(pairs.qx), std::move(pairs.qy), std::move(pairs.qz),
                                     std::move(whitening[0]), std::move(whitening[1]),
                                     std::move(whitening[2]), std::move(whitening[3]),
                                     std::move(whitening[4]), std::move(whitening[5])});
}

// Photometric functor of a target camera, without data.
inline Photometric FunctorOf(const PinholeCamera& camera) {
  return {camera.fx, camera.fy, camera.cx, camera.cy};
}

// Data of the functor Photometric. The residual at the current pose is I0 - i, sampled at the
// projection of the point.
inline BatchData<Photometric, float> MakeBatch(const IntensityPairs& pairs,
                                               const PhotometricTerm& term) {
  const PinholeCamera& camera = term.camera();
  RawVector<float> residual(pairs.size), u(pairs.size), v(pairs.size);
  ParallelFor(0, pairs.size, 4096, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      residual[i] = term.exposure().Residual(pairs, i);
      const double x = pairs.px[i], y = pairs.py[i], z = pairs.pz[i];
      u[i] = static_cast<float>(camera.fx * x / z + camera.cx);
      v[i] = static_cast<float>(camera.fy * y / z + camera.cy);
    }
  });
  const auto inverse_sigma = static_cast<float>(std::sqrt(term.information()));
  return BatchData<Photometric, float>({pairs.px, pairs.py, pairs.pz, std::move(residual),
                                        pairs.slope_u, pairs.slope_v, std::move(u), std::move(v),
                                        RawVector<float>(pairs.size, inverse_sigma)});
}

// Calls f with the functor of a built-in residual, with the type known at compile time. Test
// OwnResidualOf() first: user-defined types give PointToPlane.
template <typename F>
auto WithFunctorOf(ResidualType type, const F& f) {
  switch (type) {
    case ResidualType::kPointToPoint:
      return f(PointToPoint());
    case ResidualType::kSymmetricPointToPlane:
      return f(SymmetricPointToPlane());
    case ResidualType::kPlaneToPlane:
      return f(PlaneToPlane());
    case ResidualType::kPointToPlane:
      break;
  }
  return f(PointToPlane());
}

}  // namespace surfit
