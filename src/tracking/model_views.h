#pragma once

#include "surfit/core/image.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/registration/global_registration.h"

namespace surfit {

// View that frames are registered to: a rendered view of the map, or an earlier frame.
struct ReferenceView {
  ColoredView view;  // colours only with photometric residuals
  Rigid3d world_from_view;
  Image<float> grey;            // brightness per ViewGrid cell, 0: unknown; may be empty
  double mean_first_seen = -1;  // frame index, of the visible surfels; -1: not a view of the map

  bool has_intensities() const { return !view.pyramid.levels.front().intensity.empty(); }
};

// Renders the map for tracking. Mapper implements it. All functions run on the tracking thread.
class ModelViews {
 public:
  virtual ~ModelViews() = default;

  // Last view of Update(). Empty before the first Update(). The reference is valid for the life of
  // this object, its content until the next Update() or correction of the map.
  virtual const ReferenceView& View() const = 0;
  // Renders View() at a predicted pose if `must` is true, after fusion of a frame, or if the image
  // shift exceeds SlamOptions::max_view_shift. Returns whether View() has this pose.
  // `with_intensities`: with colours of the map.
  virtual bool Update(const Rigid3d& world_from_predicted, bool must, bool with_intensities) = 0;
  // Renders a view at any pose, and keeps View(). Unstable surfels are visible only in pixels
  // without stable surfels.
  virtual ReferenceView ViewAt(const Rigid3d& world_from_view, bool with_intensities) = 0;
  // As ViewAt(), but treats all surfels as stable, so that new surfaces occlude the surfaces behind
  // them.
  virtual ReferenceView NewestViewAt(const Rigid3d& world_from_view, bool with_intensities) = 0;
  // Activates inactive surfels that were last observed near frame `frame_index`. `now`: index of
  // the current frame. Does nothing if surfels never become inactive.
  virtual void ActivateAround(int frame_index, int now) = 0;
  // Switches to the map of a submap. Submaps that are connected share a map. A new submap has an
  // empty map.
  virtual void UseSubmap(int submap) = 0;
};

// Approximate image shift by a relative camera motion, as a ratio of the image width: fx / width
// (angle + distance / mean depth). `level` gives camera and depth. Infinite without depth.
double ImageShift(const Rigid3d& motion, const FrameLevel& level);

}  // namespace surfit
