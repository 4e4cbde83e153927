#pragma once

#include <functional>

namespace surfit {

// Runs the loop at low priority if the calling thread runs a low-priority task that is not awaited.
// Returns false otherwise, without running the loop. A loop of the low-priority thread is serial.
bool RunLoopAtLowPriority(int block_count, const std::function<void(int)>& run_block);

}  // namespace surfit
