#pragma once

#include <string>
#include <vector>

#include "surfit/run/find_loops_run.h"

namespace surfit {

// All loops that were tried, one a line. Throws InputError naming the file.
void WriteLoopsCsv(const std::vector<FoundLoop>& loops, const std::string& path);

// The keyframes by their frames' indices, and the accepted loops. Throws InputError naming the
// file.
void WriteLoopsG2o(const std::vector<Keyframe>& keyframes, const std::vector<FoundLoop>& loops,
                   const std::string& path);

}  // namespace surfit
