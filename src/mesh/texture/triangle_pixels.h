#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

namespace surfit {

// Calls visit(u, v, shares) for all pixels with their centre in a triangle of any orientation.
// `shares`: barycentric coordinates. They are for a, b and c, at least 0, and their sum is 1.
// Pixels outside of width x height, and degenerate triangles, are omitted. Pixel centres are
// integers.
template <typename Visit>
void VisitPixels(const Eigen::Vector2f& a, const Eigen::Vector2f& b, const Eigen::Vector2f& c,
                 int width, int height, const Visit& visit) {
  const Eigen::Vector2f low = a.cwiseMin(b).cwiseMin(c), high = a.cwiseMax(b).cwiseMax(c);
  const auto clamped = [](float value, int size) {
    return static_cast<int>(std::clamp(value, -1.f, static_cast<float>(size)));
  };
  const int left = std::max(0, clamped(std::ceil(low.x()), width));
  const int right = std::min(width - 1, clamped(std::floor(high.x()), width));
  const int top = std::max(0, clamped(std::ceil(low.y()), height));
  const int bottom = std::min(height - 1, clamped(std::floor(high.y()), height));
  const Eigen::Vector2f ab = b - a, ac = c - a;
  const float area = ab.x() * ac.y() - ab.y() * ac.x();
  if (!(std::abs(area) > 0)) return;
  for (int v = top; v <= bottom; ++v) {
    for (int u = left; u <= right; ++u) {
      const float du = static_cast<float>(u) - a.x(), dv = static_cast<float>(v) - a.y();
      const float of_b = (du * ac.y() - dv * ac.x()) / area;
      const float of_c = (ab.x() * dv - ab.y() * du) / area;
      const float of_a = 1 - of_b - of_c;
      if (of_a >= 0 && of_b >= 0 && of_c >= 0) visit(u, v, Eigen::Vector3f(of_a, of_b, of_c));
    }
  }
}

}  // namespace surfit
