#pragma once

#include <cstddef>
#include <vector>

#include "surfit/geometry/inverse_depth_field.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/mapping/surfel_map.h"

namespace surfit {

// Corrections of the world frame, one per frame index, after an optimisation of the poses.
class FrameCorrections {
 public:
  // new_from_old_world[i] moves surfels that were first seen in frame first_frame + i from the old
  // to the new world frame. Earlier and later frames use the nearest entry. Throws if the vector is
  // empty.
  FrameCorrections(int first_frame, std::vector<Rigid3d> new_from_old_world);

  const Rigid3d& At(int frame) const { return new_from_old_world_[IndexOf(frame)]; }

  // Index of the correction of a frame, in [0, size()).
  std::size_t IndexOf(int frame) const;
  std::size_t size() const { return new_from_old_world_.size(); }
  const Rigid3d& operator[](std::size_t index) const { return new_from_old_world_[index]; }

 private:
  int first_frame_;
  std::vector<Rigid3d> new_from_old_world_;
};

// Change of the calibration, for MoveMap().
struct Recalibration {
  DepthCalibration from, to;
  std::vector<Rigid3d> world_from_camera;  // old poses, one per entry of FrameCorrections
};

// Statistics of a map correction.
struct MoveReport {
  std::size_t moved = 0;         // surfels whose correction is not the identity
  std::size_t changed_cell = 0;  // surfels that moved to another cell
};

// Moves each surfel rigidly with the frame that saw it first. Ids become invalid. The result is
// bitwise identical for any number of threads.
MoveReport MoveMap(const FrameCorrections& corrections, SurfelMap* map);

// Also applies a new calibration. In the frame that saw it first, each surfel keeps its pixel and
// its measured depth. Surfels less than 1 cm in front of this camera, or with a corrected depth
// beyond 1 km, move rigidly and keep their normals. `moved` counts all surfels. `corrections` map
// the world frame of the old poses to that of the new poses. Throws if
// recalibration.world_from_camera and `corrections` differ in size.
MoveReport MoveMap(const FrameCorrections& corrections, const Recalibration& recalibration,
                   SurfelMap* map);

// Appends the surfels of a map to another map. `frame_shift` is added to their frame indices, which
// must not be negative. Throws InputError if one is then above SurfelBlock::kMaxFrame.
void AppendSurfels(const SurfelMap& from, int frame_shift, SurfelMap* to);

// Makes surfels active again, for example after a loop closure: sets last_seen to `now` if it is in
// [first, last]. Returns the number of changed surfels. `now` must be at least `first`, which is
// not checked. See FusionOptions::active_frames.
std::size_t ReactivateSurfels(int first, int last, int now, SurfelMap* map);

}  // namespace surfit
