#pragma once

namespace surfit {

// Images are worked on in bands of so many rows.
constexpr int kBandRows = 16;
inline int BandCount(int height) { return (height + kBandRows - 1) / kBandRows; }

}  // namespace surfit
