#pragma once

#include "surfit/core/image.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/registration/global_registration.h"

namespace surfit {

struct ReferenceView {
  ColoredView view;  // colours only with photometric residuals
  Rigid3d world_from_view;
  Image<float> grey;  // brightness per ViewGrid cell, 0: unknown; may be empty

  bool has_intensities() const { return !view.pyramid.levels.front().intensity.empty(); }
};

class ModelViews {
 public:
  virtual ~ModelViews() = default;

  virtual const ReferenceView& View() const = 0;
  // Renders View() at a predicted pose if `must` is true, after fusion of a frame, or if the
  // image shift is large. Returns whether View() was rendered for this pose.
  virtual bool Update(const Rigid3d& world_from_predicted, bool must, bool with_intensities) = 0;
  // Renders the stable surfels.
  virtual ReferenceView ViewAt(const Rigid3d& world_from_view, bool with_intensities) = 0;
  // Renders stable and unstable surfels, so that new surfaces occlude the surfaces behind
  // them.
  virtual ReferenceView NewestViewAt(const Rigid3d& world_from_view, bool with_intensities) = 0;
  // Activates inactive surfels that were last observed near frame `frame_index`. `now`: index
  // of the current frame.
  virtual void ActivateAround(int frame_index, int now) = 0;
};

// Approximate image shift by a motion at the mean depth, as a ratio of the image width. Infinite
// without depth.
double ImageShift(const Rigid3d& motion, const FrameLevel& level);

}  // namespace surfit
