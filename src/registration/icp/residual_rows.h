#pragma once

#include <cmath>

#include "cost_functions/pose.h"
#include "cost_functions/row_sums.h"
#include "surfit/core/lanes.h"
#include "surfit/registration/association.h"
#include "surfit/registration/error_model.h"
#include "surfit/registration/normal_system.h"

namespace surfit {

// Rows of the built-in residuals for the left perturbation, see row_sums.h. One pair, or one pair
// per lane of V, in the target frame, with the symbols of Pairs (association.h).
template <typename V>
struct PairValues {
  V p[3], q[3], n[3], m[3];
  V information;
};

template <typename V>
V Dot(const V* a, const V* b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// Sets the row [a r] of a residual r with the derivative g by p. The left increment (w, v) moves p
// to p + w x p + v. Therefore a = [p x g, g], because g . (w x p) = w . (p x g).
//
// kNormalRatio of the row types: variance of the row direction relative to the variance of a
// normal, see SpuriousInformation().
template <typename V>
void SetRow(const V* p, const V* g, const V& r, V* row) {
  Cross(p, g, row);
  for (int i = 0; i < 3; ++i) row[3 + i] = g[i];
  row[6] = r;
}

// r = p - q: a = [-[p]x | I], row by row.
struct PointToPointRows {
  static constexpr int kRows = 3;
  static constexpr double kNormalRatio = 0;
  template <typename V>
  static void Evaluate(const PairValues<V>& pair, V rows[][kRowColumns]) {
    const V zero(0.), one(1.);
    const V *p = pair.p, *q = pair.q;
    const V a[kRows][kRowColumns] = {{zero, p[2], -p[1], one, zero, zero, p[0] - q[0]},
                                     {-p[2], zero, p[0], zero, one, zero, p[1] - q[1]},
                                     {p[1], -p[0], zero, zero, zero, one, p[2] - q[2]}};
    for (int k = 0; k < kRows; ++k) {
      for (int i = 0; i < kRowColumns; ++i) rows[k][i] = a[k][i];
    }
  }
};

// r = n . (p - q): a = [p x n, n].
struct PointToPlaneRows {
  static constexpr int kRows = 1;
  static constexpr double kNormalRatio = 1;
  template <typename V>
  static void Evaluate(const PairValues<V>& pair, V rows[][kRowColumns]) {
    const V x[3] = {pair.p[0] - pair.q[0], pair.p[1] - pair.q[1], pair.p[2] - pair.q[2]};
    SetRow(pair.p, pair.n, Dot(pair.n, x), rows[0]);
  }
};

// r = g . (p - q), g = (n + m) / 2. The increment also rotates m to m + w x m, which adds (w x m) .
// (p - q) / 2 = w . (m x (p - q)) / 2. Therefore a = [p x g + m x (p - q) / 2, g].
struct SymmetricPointToPlaneRows {
  static constexpr int kRows = 1;
  static constexpr double kNormalRatio = 0.5;  // mean of two normals
  template <typename V>
  static void Evaluate(const PairValues<V>& pair, V rows[][kRowColumns]) {
    const V half(0.5);
    V x[3], g[3], turned[3];
    for (int i = 0; i < 3; ++i) {
      x[i] = pair.p[i] - pair.q[i];
      g[i] = (pair.n[i] + pair.m[i]) * half;
    }
    SetRow(pair.p, g, Dot(g, x), rows[0]);
    Cross(pair.m, x, turned);
    for (int i = 0; i < 3; ++i) rows[0][i] = rows[0][i] + turned[i] * half;
  }
};

// r = U (p - q) with upper triangular U, U^T U = C^-1. U is constant during the step. C is the mean
// of the covariances of both planes in units of sigma^2. Each covariance is 1 along the normal and
// 1 / e within the plane:
//   C = 1/2 (C_n + C_m),  C_n = n n^T + (I - n n^T) / e.
// For equal normals, |r|^2 is the squared point-to-plane residual plus e times the squared offset
// within the plane. e = 1e-3 as in Segal, Haehnel and Thrun 2009.
struct PlaneToPlaneRows {
  static constexpr int kRows = 3;
  static constexpr double kNormalRatio = 0.5;  // approximately the mean of two normals
  static constexpr double kFlatness = 1e-3;

  // Entries 00, 01, 02, 11, 12, 22 of U.
  template <typename V>
  static void Whitening(const V* n, const V* m, V* u) {
    using std::sqrt;
    // e C = I - (1 - e) / 2 (n n^T + m m^T) has entries of order 1.
    const V c(0.5 * (1 - kFlatness));
    const auto entry = [&](int i, int j) {
      return V(i == j ? 1. : 0.) - c * (n[i] * n[j] + m[i] * m[j]);
    };
    const V a = entry(0, 0), b = entry(0, 1), d = entry(0, 2), e = entry(1, 1), f = entry(1, 2),
            g = entry(2, 2);
    // Inverse by cofactors, then its Cholesky factor.
    const V c00 = e * g - f * f, c01 = d * f - b * g, c02 = b * f - d * e;
    const V scale = V(kFlatness) / (a * c00 + b * c01 + d * c02);
    const V w00 = c00 * scale, w01 = c01 * scale, w02 = c02 * scale;
    const V w11 = (a * g - d * d) * scale, w12 = (b * d - a * f) * scale,
            w22 = (a * e - b * b) * scale;
    u[0] = sqrt(w00);
    u[1] = w01 / u[0];
    u[2] = w02 / u[0];
    u[3] = sqrt(w11 - u[1] * u[1]);
    u[4] = (w12 - u[1] * u[2]) / u[3];
    u[5] = sqrt(w22 - u[2] * u[2] - u[4] * u[4]);
  }

  template <typename V>
  static void Evaluate(const PairValues<V>& pair, V rows[][kRowColumns]) {
    const V zero(0.);
    V u[6], x[3];
    Whitening(pair.n, pair.m, u);
    for (int i = 0; i < 3; ++i) x[i] = pair.p[i] - pair.q[i];
    const V g[kRows][3] = {{u[0], u[1], u[2]}, {zero, u[3], u[4]}, {zero, zero, u[5]}};
    for (int k = 0; k < kRows; ++k) SetRow(pair.p, g[k], Dot(g[k], x), rows[k]);
  }
};

// Intensity gradient g = dI/dp at p = (x, y, z), for u = fx x / z + cx and v = fy y / z + cy:
//   g = (I_u fx / z, I_v fy / z, -(I_u fx x + I_v fy y) / z^2).
// over_z(a) returns a / z.
template <typename V, typename OverZ>
void IntensityGradient(const V& slope_u, const V& slope_v, const V& fx, const V& fy, const V* p,
                       const OverZ& over_z, V* g) {
  g[0] = over_z(slope_u * fx);
  g[1] = over_z(slope_v * fy);
  g[2] = over_z(-(g[0] * p[0] + g[1] * p[1]));
}

// Input of a photometric row: one point, or one point per lane of V.
template <typename V>
struct IntensityValues {
  V p[3];              // p' in the target frame, m
  V residual;          // r
  V slope_u, slope_v;  // dI/du, dI/dv, per px
};

// r = I(u, v) - (gain J + offset): a = [p x g, g].
struct IntensityRows {
  static constexpr int kRows = 1;
  template <typename V>
  static void Evaluate(const IntensityValues<V>& values, double fx, double fy,
                       V rows[][kRowColumns]) {
    const V inverse_z = V(1.) / values.p[2];
    V g[3];
    IntensityGradient(
        values.slope_u, values.slope_v, V(fx), V(fy), values.p,
        [&](const V& a) { return a * inverse_z; }, g);
    SetRow(values.p, g, values.residual, rows[0]);
  }
};

// Adds a a^T to the Hessian, -r a to the right side and r^2 to the square sum, for all rows [a r].
inline void AddProducts(const RowSums& sums, Matrix6d* hessian, Vector6d* right_side,
                        double* square_sum) {
  for (int i = 0, k = 0; i < kRowColumns; ++i) {
    for (int j = i; j < kRowColumns; ++j, ++k) {
      if (i == 6) {
        *square_sum += sums.product[k];
      } else if (j == 6) {
        (*right_side)[i] -= sums.product[k];
      } else {
        (*hessian)(i, j) += sums.product[k];
        if (i != j) (*hessian)(j, i) += sums.product[k];
      }
    }
  }
}

// Calls f with the row type of a built-in residual, known at compile time. Test OwnResidualOf()
// first: user-defined types give PointToPlaneRows.
template <typename F>
auto WithRowsOf(ResidualType type, const F& f) {
  switch (type) {
    case ResidualType::kPointToPoint:
      return f(PointToPointRows());
    case ResidualType::kSymmetricPointToPlane:
      return f(SymmetricPointToPlaneRows());
    case ResidualType::kPlaneToPlane:
      return f(PlaneToPlaneRows());
    case ResidualType::kPointToPlane:
      break;
  }
  return f(PointToPlaneRows());
}

}  // namespace surfit
