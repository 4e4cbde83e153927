#pragma once

#include <functional>

namespace surfit {

// Runs the loop at low priority if the calling thread executes a low-priority task that is not
// awaited. Runs the loop serially on the low-priority thread itself. Otherwise returns false
// without running it.
bool RunLoopAtLowPriority(int block_count, const std::function<void(int)>& run_block);

}  // namespace surfit
