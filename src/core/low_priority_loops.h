#pragma once

#include <functional>

namespace surfit {

// Runs the loop at low priority if the calling thread runs a low-priority task that is not awaited.
// On the low-priority thread, the loop is serial. Otherwise returns false without running the loop.
bool RunLoopAtLowPriority(int block_count, const std::function<void(int)>& run_block);

}  // namespace surfit
