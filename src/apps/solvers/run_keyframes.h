#pragma once

#include <cstddef>
#include <vector>

#include "apps/solvers/refine_run.h"
#include "surfit/frame/frame_source.h"
#include "surfit/geometry/trajectory.h"
#include "surfit/optimization/keyframes.h"

namespace surfit {

// Keyframes of a run, with their images, for Refine().
struct RunKeyframes {
  SequenceInfo info;
  Trajectory trajectory;           // trajectory of the run, in the pose convention of the frames
  std::vector<double> stamps_s;    // capture times of all frames
  std::vector<std::size_t> poses;  // indices of the keyframes in `trajectory`
  std::vector<RefinementKeyframe> keyframes;
  int frames_without_pose = 0, frames_unreadable = 0;  // of all frames
  std::vector<std::size_t> frame_poses;  // indices in `trajectory` of poses with a frame
  std::vector<int> frames;               // frame indices of these poses
};

// Selects the keyframes by the options, and reads their images. Throws InputError for unreadable
// files, or a trajectory without poses at frames of the sequence.
RunKeyframes ReadRunKeyframes(const RefineRunOptions& options);

}  // namespace surfit
