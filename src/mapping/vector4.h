#pragma once

#include <Eigen/Core>

#include "core/float4.h"

namespace surfit {

// Four 3-vectors.
struct Vector4 {
  Float4 x, y, z;
};

inline Vector4 Transposed(const Eigen::Vector3f& a, const Eigen::Vector3f& b,
                          const Eigen::Vector3f& c, const Eigen::Vector3f& d) {
  return {Float4{a.x(), b.x(), c.x(), d.x()}, Float4{a.y(), b.y(), c.y(), d.y()},
          Float4{a.z(), b.z(), c.z(), d.z()}};
}

inline Vector4 operator-(const Vector4& a, const Vector4& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}

inline Float4 Dot(const Vector4& a, const Vector4& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

inline Vector4 Rotate(const Eigen::Matrix3f& r, const Vector4& a) {
  return {r(0, 0) * a.x + r(0, 1) * a.y + r(0, 2) * a.z,
          r(1, 0) * a.x + r(1, 1) * a.y + r(1, 2) * a.z,
          r(2, 0) * a.x + r(2, 1) * a.y + r(2, 2) * a.z};
}

}  // namespace surfit
