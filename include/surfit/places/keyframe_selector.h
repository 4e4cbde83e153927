#pragma once

#include "surfit/places/keyframe.h"

namespace surfit {

class OptionVisitor;

// When a frame becomes a keyframe.
struct KeyframeOptions {
  // From the last keyframe the camera has moved so far,
  double max_distance_m = 0.2;
  double max_angle_rad = 0.21;  // 12 degrees
  // or sees less than this share of what the keyframe sees,
  double min_overlap_share = 0.7;
  // or so many frames have passed since in which it moved at all: by a tenth of what is above.
  int max_frames = 60;

  void Visit(OptionVisitor& visitor);
};

// Whether a frame at that pose is to become a keyframe, after the last one. `surface` is any level
// of its pyramid.
bool IsKeyframe(const Keyframe& last, int frame_index, const FrameLevel& surface,
                const Rigid3d& world_from_camera, const KeyframeOptions& options);

// The share of the points that a keyframe sees which fall into the image of a camera there, and are
// not hidden from it by the surface it sees. 0 where the keyframe's view is empty.
double OverlapShare(const Keyframe& keyframe, const FrameLevel& surface,
                    const Rigid3d& world_from_camera);

}  // namespace surfit
