#pragma once

#include <cstddef>

namespace surfit::testing {

// The largest single request to operator new since the last reset, in bytes. The program that calls
// this has operator new replaced (largest_allocation.cc).
std::size_t LargestAllocation();
void ResetLargestAllocation();

}  // namespace surfit::testing
