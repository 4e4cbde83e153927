#pragma once

#include <functional>

namespace surfit {

// Implements ParallelFor() in tasks of LowPriorityScope. Calls run_block(0 ... block_count - 1) at
// low priority if the calling thread runs a low-priority task that is not awaited. On the
// low-priority thread, the loop is serial. After LowPriorityScope::Await(), the calling thread runs
// the remaining blocks. Returns true after all blocks. After an exception of a block, no further
// block begins, and the exception is rethrown. Otherwise returns false without running the loop.
bool RunLoopAtLowPriority(int block_count, const std::function<void(int)>& run_block);

}  // namespace surfit
