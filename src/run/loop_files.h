#pragma once

#include <string>
#include <vector>

#include "surfit/run/find_loops_run.h"
#include "surfit/slam/loop_finder.h"

namespace surfit {

// All loops that were tried, one a line, with what speaks for each and the reason of its verdict.
// Of a run of SLAM, whose pose graph may have overruled it; or of a search, with what the ground
// truth says. Throws InputError naming the file.
void WriteLoopsCsv(const std::vector<LoopRecord>& loops, const std::string& path);
void WriteLoopsCsv(const std::vector<FoundLoop>& loops, const std::string& path);

// The keyframes by their frames' indices, and the accepted loops. Throws InputError naming the
// file.
void WriteLoopsG2o(const std::vector<Keyframe>& keyframes, const std::vector<FoundLoop>& loops,
                   const std::string& path);

}  // namespace surfit
