#pragma once

#include <vector>

#include "surfit/mapping/move_map.h"
#include "surfit/poses/pose_store.h"

namespace surfit {

// Computes the corrections of all frame indices, from the first to the last frame, from the
// corrections of the keyframes (new_from_old in the world frame). Between two keyframes of a
// trajectory segment, displacement and rotation are interpolated by the frame index. Frames after
// the last keyframe of a segment move with this keyframe. An index without a frame has the
// correction of the frame before.
FrameCorrections CorrectionsOfFrames(const std::vector<PosedFrame>& frames,
                                     const std::vector<int>& frame_of_keyframe,
                                     const std::vector<Rigid3d>& new_from_old_of_keyframe);

// Poses of all indices from the first to the last frame. An index without a frame has the pose of
// the frame before.
std::vector<Rigid3d> PosesOfIndices(const std::vector<PosedFrame>& frames);

}  // namespace surfit
