#pragma once

#include <cstddef>
#include <vector>

#include "surfit/geometry/inverse_depth_field.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/mapping/surfel_map.h"

namespace surfit {

// Where what each frame saw belongs, after the poses of frames have been corrected.
class FrameCorrections {
 public:
  // new_from_old_world[i] takes what frame first_frame + i has seen first from where it was in the
  // world to where it is now. There must be one; frames beyond the ends take the nearest one.
  FrameCorrections(int first_frame, std::vector<Rigid3d> new_from_old_world);

  const Rigid3d& At(int frame) const { return new_from_old_world_[IndexOf(frame)]; }

  // The number of a frame's correction, from 0 to size() - 1.
  std::size_t IndexOf(int frame) const;
  std::size_t size() const { return new_from_old_world_.size(); }
  const Rigid3d& operator[](std::size_t index) const { return new_from_old_world_[index]; }

 private:
  int first_frame_;
  std::vector<Rigid3d> new_from_old_world_;
};

// A calibration that has changed: what was measured by one is seen by the other.
struct Recalibration {
  DepthCalibration from, to;
  std::vector<Rigid3d> world_from_camera;  // of each of the corrections' frames, before these
};

// What became of a map that was moved.
struct MoveReport {
  std::size_t moved = 0;         // surfels whose frame's correction is not the identity
  std::size_t changed_cell = 0;  // of those, the ones that came to another cell of the map
};

// Moves each surfel rigidly with the frame that saw it first: later frames were registered to it.
// The same map and corrections give the same map bit for bit at any number of threads. Ids change.
MoveReport MoveMap(const FrameCorrections& corrections, SurfelMap* map);

// The same where the calibration has changed as well: each surfel keeps its pixel and measured
// depth in the frame that saw it first.
MoveReport MoveMap(const FrameCorrections& corrections, const Recalibration& recalibration,
                   SurfelMap* map);

// Raises the last sight of the surfels that were last seen from frame `first` to `last` to frame
// `now`, so that what is known to be near again is active: see FusionOptions::active_frames.
// Returns how many there were.
std::size_t WakeSurfels(int first, int last, int now, SurfelMap* map);

}  // namespace surfit
