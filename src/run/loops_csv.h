#pragma once

#include <string>
#include <vector>

#include "surfit/slam/loop_finder.h"

namespace surfit {

// Writes a line for each pair of keyframes that was tried as a loop, with the reason of its verdict
// and what speaks for it. Throws InputError naming the file if it cannot be written.
void WriteLoopsCsv(const std::vector<LoopRecord>& loops, const std::string& path);

}  // namespace surfit
