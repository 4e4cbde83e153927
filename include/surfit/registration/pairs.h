#pragma once

#include <Eigen/Core>
#include <array>

#include "surfit/core/raw_vector.h"
#include "surfit/geometry/rigid3.h"

namespace surfit {

// Matched points of two surfaces as structure of arrays, in the target's frame. Values count up to
// size; the arrays may be longer.
template <typename S>
struct Pairs {
  using Vector3 = Eigen::Matrix<S, 3, 1>;

  RawVector<S> px, py, pz;   // source point, moved: p' = R p + t
  RawVector<S> qx, qy, qz;   // target point
  RawVector<S> nx, ny, nz;   // unit normal of the target; (0, 0, 0) if unknown
  RawVector<S> mx, my, mz;   // unit normal of the source, rotated; (0, 0, 0) if unknown
  RawVector<S> information;  // 1 / sigma^2 of the residual, 1/m^2 (ErrorModel)
  int size = 0;

  static constexpr int kArrays = 13;
  std::array<RawVector<S>*, kArrays> Arrays() {
    return {&px, &py, &pz, &qx, &qy, &qz, &nx, &ny, &nz, &mx, &my, &mz, &information};
  }

  std::array<const RawVector<S>*, kArrays> Arrays() const {
    return {&px, &py, &pz, &qx, &qy, &qz, &nx, &ny, &nz, &mx, &my, &mz, &information};
  }

  // Makes room for so many pairs, at least size, without changing size.
  void SetCapacity(int capacity) {
    for (auto* array : Arrays()) array->resize(capacity);
  }
  // Writes a pair at an index for which there is room; size stays.
  void Set(int i, const Vector3& p, const Vector3& q, const Vector3& n, const Vector3& m,
           S pair_information) {
    px[i] = p.x(), py[i] = p.y(), pz[i] = p.z();
    qx[i] = q.x(), qy[i] = q.y(), qz[i] = q.z();
    nx[i] = n.x(), ny[i] = n.y(), nz[i] = n.z();
    mx[i] = m.x(), my[i] = m.y(), mz[i] = m.z();
    information[i] = pair_information;
  }
  // Appends a pair, making room where needed.
  void Add(const Vector3& p, const Vector3& q, const Vector3& n, const Vector3& m,
           S pair_information) {
    if (size == static_cast<int>(px.size())) SetCapacity(2 * size + 16);
    Set(size++, p, q, n, m, pair_information);
  }

  Vector3 p(int i) const { return {px[i], py[i], pz[i]}; }
  Vector3 q(int i) const { return {qx[i], qy[i], qz[i]}; }
  Vector3 n(int i) const { return {nx[i], ny[i], nz[i]}; }
  Vector3 m(int i) const { return {mx[i], my[i], mz[i]}; }
};

using PairBuffer = Pairs<float>;        // what associations find
using Correspondences = Pairs<double>;  // given from elsewhere

// The pairs after the source has moved by a further transform of the target's frame.
Correspondences Moved(Correspondences pairs, const Rigid3d& motion);

}  // namespace surfit
