#pragma once

#include <cstddef>
#include <vector>

#include "surfit/geometry/inverse_depth_field.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/mapping/surfel_map.h"

namespace surfit {

// Map corrections, one per frame, after an optimisation of the poses.
class FrameCorrections {
 public:
  // new_from_old_world[i] maps surfels first seen in frame first_frame + i from the old to the new
  // world frame. Other frames use the nearest entry. Aborts if the vector is empty.
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

// Change of the calibration.
struct Recalibration {
  DepthCalibration from, to;
  std::vector<Rigid3d> world_from_camera;  // old poses, one per correction
};

// Statistics of a map correction.
struct MoveReport {
  std::size_t moved = 0;         // surfels with a correction other than identity; see MoveMap()
  std::size_t changed_cell = 0;  // moved surfels that are in another cell now
};

// Moves each surfel rigidly with the frame that saw it first, because later frames were registered
// to it. Ids become invalid. The result is bitwise identical for every number of threads.
MoveReport MoveMap(const FrameCorrections& corrections, SurfelMap* map);

// Also applies a new calibration: each surfel keeps its pixel and measured depth in the frame that
// saw it first. Surfels less than 1 cm in front of this camera only move rigidly. `moved` counts
// every surfel. Aborts if recalibration.world_from_camera and `corrections` differ in size.
MoveReport MoveMap(const FrameCorrections& corrections, const Recalibration& recalibration,
                   SurfelMap* map);

// Reactivates surfels: sets last_seen to `now` if it is in [first, last]. Used after a loop
// closure, see FusionOptions::active_frames. Returns the number of changed surfels.
std::size_t ReactivateSurfels(int first, int last, int now, SurfelMap* map);

}  // namespace surfit
