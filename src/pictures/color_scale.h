#pragma once

#include <array>

#include "surfit/core/image.h"

namespace surfit {

// Colours for numbers from low to high: viridis, dark blue through green to yellow, even to the
// eye.
class ColorScale {
 public:
  // Where logarithmic, 0 < low. Needs low <= high.
  ColorScale(double low, double high, bool logarithmic);

  double low() const { return low_; }
  double high() const { return high_; }
  bool logarithmic() const { return logarithmic_; }

  // 0 at low, 1 at high, clamped to them.
  double Position(double value) const;
  Rgb8 ColorAt(double position) const;
  Rgb8 ColorOf(double value) const { return ColorAt(Position(value)); }

 private:
  double low_, high_;
  bool logarithmic_;
  std::array<Rgb8, 256> colors_;
};

}  // namespace surfit
