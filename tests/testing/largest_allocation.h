#pragma once

#include <cstddef>

namespace surfit::testing {

// Largest request to operator new since the last reset, in bytes. largest_allocation.cc replaces
// operator new of the test program.
std::size_t LargestAllocation();
void ResetLargestAllocation();

}  // namespace surfit::testing
