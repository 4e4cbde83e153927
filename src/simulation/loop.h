#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

namespace surfit {

// A smooth closed curve through its corners (Catmull-Rom).
class Loop {
 public:
  explicit Loop(std::vector<Eigen::Vector3d> corners) : corners_(std::move(corners)) {}

  // At corner i for place = i, and again a whole round later.
  Eigen::Vector3d At(double place) const {
    const double whole = std::floor(place), s = place - whole;
    const Eigen::Vector3d a = Corner(whole - 1), b = Corner(whole), c = Corner(whole + 1),
                          d = Corner(whole + 2);
    return 0.5 *
           (2 * b + s * (c - a + s * (2 * a - 5 * b + 4 * c - d + s * (3 * b - a - 3 * c + d))));
  }

 private:
  Eigen::Vector3d Corner(double index) const {
    const auto count = static_cast<double>(corners_.size());
    return corners_[static_cast<std::size_t>(index - count * std::floor(index / count))];
  }

  std::vector<Eigen::Vector3d> corners_;
};

}  // namespace surfit
