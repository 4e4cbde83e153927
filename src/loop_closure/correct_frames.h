#pragma once

#include <vector>

#include "surfit/mapping/move_map.h"
#include "surfit/poses/pose_store.h"

namespace surfit {

// Computes the corrections of all frame indices from the corrections of the keyframes: new_from_old
// in the world frame, one per keyframe. `frames` have the poses before the correction. `frames`
// must not be empty. Indices are strictly ascending. `frame_of_keyframe` has positions in `frames`.
// Between keyframes of a trajectory segment, displacement and rotation are interpolated by frame
// index. Frames after the last keyframe of a segment move with this keyframe. Indices without a
// frame have the correction of the previous frame.
FrameCorrections CorrectionsOfFrames(const std::vector<PosedFrame>& frames,
                                     const std::vector<int>& frame_of_keyframe,
                                     const std::vector<Rigid3d>& new_from_old_of_keyframe);

// Poses world_from_camera of all indices from the first to the last frame. Empty without frames.
// Indices without a frame have the pose of the previous frame.
std::vector<Rigid3d> PosesOfIndices(const std::vector<PosedFrame>& frames);

}  // namespace surfit
