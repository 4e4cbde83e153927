#pragma once

#include <cstdint>
#include <vector>

#include "simulation/sensors/exact_view.h"

namespace surfit {

// Range measurement of one laser dot.
struct LidarDot {
  int u = 0, v = 0;
  Rgb8 color;
  double inverse_depth = 0;  // 1/m; 0: not detected
  double sigma = 0;          // standard deviation of the inverse depth, 1/m
};

// Dots in the centres of dots_across x dots_down equal parts of the image.
class DotGrid {
 public:
  DotGrid(const ExactView& exact, std::uint64_t seed, const LidarOptions& options);

  double spacing_u() const { return spacing_u_; }
  double spacing_v() const { return spacing_v_; }

  // The detected dots of the 5 x 5 parts around a pixel. Without a dot there, the reach doubles.
  // Empty if no dot of the grid is detected.
  std::vector<const LidarDot*> Around(int u, int v) const;

 private:
  int across_, down_;
  double spacing_u_, spacing_v_;
  std::vector<LidarDot> dots_;
};

}  // namespace surfit
