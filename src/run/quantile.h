#pragma once

#include <vector>

namespace surfit {

// The value at a share of the ascending order, interpolated between two; 0 of nothing.
double Quantile(std::vector<double> values, double share);

}  // namespace surfit
