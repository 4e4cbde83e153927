#pragma once

#include <functional>

namespace surfit {

// Does the blocks of a loop of the calling thread, if that is at a task in spare time that nobody
// waits for when the loop begins, or does the blocks of such tasks; else false.
bool RunLoopInSpareTime(int block_count, const std::function<void(int)>& run_block);

}  // namespace surfit
