#include "evaluation/morton_order.h"

#include <algorithm>
#include <utility>

namespace surfit {
namespace {

// Cells along each side of the cube: 3 x 21 bits fit a 64-bit code.
constexpr double kCells = 2097151;

// Puts two zeros between any two of the lowest 21 bits.
std::uint64_t SpreadBits(std::uint64_t x) {
  x = (x | x << 32) & 0x001f00000000ffffu;
  x = (x | x << 16) & 0x001f0000ff0000ffu;
  x = (x | x << 8) & 0x100f00f00f00f00fu;
  x = (x | x << 4) & 0x10c30c30c30c30c3u;
  x = (x | x << 2) & 0x1249249249249249u;
  return x;
}

}  // namespace

std::vector<std::uint32_t> MortonOrder(const std::vector<Eigen::Vector3f>& points) {
  if (points.empty()) return {};
  Eigen::Array3d low = points[0].cast<double>(), high = low;
  for (const Eigen::Vector3f& point : points) {
    low = low.min(point.cast<double>().array());
    high = high.max(point.cast<double>().array());
  }
  const double side = (high - low).maxCoeff();
  const double scale = side > 0 ? kCells / side : 0;
  std::vector<std::pair<std::uint64_t, std::uint32_t>> codes(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Array3d cell = (points[i].cast<double>().array() - low) * scale;
    std::uint64_t code = 0;
    for (int axis = 0; axis < 3; ++axis) {
      code |= SpreadBits(static_cast<std::uint64_t>(cell[axis])) << axis;
    }
    codes[i] = {code, static_cast<std::uint32_t>(i)};
  }
  std::sort(codes.begin(), codes.end());
  std::vector<std::uint32_t> order;
  order.reserve(codes.size());
  for (const auto& code : codes) order.push_back(code.second);
  return order;
}

}  // namespace surfit
