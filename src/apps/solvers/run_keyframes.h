#pragma once

#include <cstddef>
#include <vector>

#include "apps/solvers/refine_run.h"
#include "surfit/frame/frame_source.h"
#include "surfit/geometry/trajectory.h"
#include "surfit/optimization/keyframes.h"

namespace surfit {

// The keyframes of a run, as refinement needs them.
struct RunKeyframes {
  SequenceInfo info;
  Trajectory trajectory;           // of the run, in the convention of the sequence's frames
  std::vector<double> stamps_s;    // of all frames
  std::vector<std::size_t> poses;  // of the trajectory: the keyframes'
  std::vector<RefinementKeyframe> keyframes;
  int frames_without_pose = 0, frames_unreadable = 0;  // of those read
  std::vector<std::size_t> frame_poses;                // of the trajectory: those with a frame,
  std::vector<int> frames;                             // and their frames' indices
};

// Reads them. Throws InputError for files that cannot be read, or a trajectory of other frames.
RunKeyframes ReadRunKeyframes(const RefineRunOptions& options);

}  // namespace surfit
