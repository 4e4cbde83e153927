#pragma once

#include <vector>

#include "surfit/mapping/move_map.h"
#include "surfit/poses/pose_store.h"

namespace surfit {

// The corrections of all frames, one for each index from the first one's to the last one's, from
// those of keyframes (new_from_old in the world). Between two keyframes of a stretch the camera's
// displacement and turn grow with the frame's index from one's to the other's; all after the last
// keyframe of a stretch moves with that. Indices without a frame go with the frame before.
FrameCorrections CorrectionsOfFrames(const std::vector<PosedFrame>& frames,
                                     const std::vector<int>& frame_of_keyframe,
                                     const std::vector<Rigid3d>& new_from_old_of_keyframe);

// The poses of all indices from the first frame's to the last one's, likewise.
std::vector<Rigid3d> PosesOfIndices(const std::vector<PosedFrame>& frames);

}  // namespace surfit
