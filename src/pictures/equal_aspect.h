#pragma once

namespace surfit {

// Values from the left (lower) edge of an axis to the right (upper) one; begin > end turns it.
struct AxisRange {
  double begin, end;
};

struct AxisRanges {
  AxisRange x, y;
};

// Ranges about the centres of the given ones with the same number of units per pixel on both axes
// of a box; at least one of the given ranges fills 90 % of its side, none more. Directions are
// kept; a range shorter than 1 mm counts as 1 mm.
AxisRanges EqualAspect(const AxisRanges& ranges, double box_width_px, double box_height_px);

}  // namespace surfit
