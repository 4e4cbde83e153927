#pragma once

#include "surfit/core/image.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/registration/global_registration.h"

namespace surfit {

// View that a frame is registered to.
struct ReferenceView {
  ColoredView view;  // has colours only with photometric residuals
  Rigid3d world_from_view;
  Image<float> grey;  // brightness of the model's cells (ViewGrid), 0: unknown; may be empty

  bool has_intensities() const { return !view.pyramid.levels.front().intensity.empty(); }
};

// Views of the map for tracking.
class ModelViews {
 public:
  virtual ~ModelViews() = default;

  // View for frames at the predicted pose.
  virtual const ReferenceView& View() const = 0;
  // Renders View() at a predicted pose: if `must`, in turn with fusion, or after a large shift of
  // the image. Returns whether View() belongs to this pose alone.
  virtual bool Update(const Rigid3d& world_from_predicted, bool must, bool with_intensities) = 0;
  // Renders the stable surfels.
  virtual ReferenceView ViewAt(const Rigid3d& world_from_view, bool with_intensities) = 0;
  // Renders all surfels. A surface that has just come into view occludes the surface behind it.
  virtual ReferenceView NewestViewAt(const Rigid3d& world_from_view, bool with_intensities) = 0;
  // Activates the surfels that were last seen near a frame, as of frame `now`.
  virtual void ActivateAround(int frame_index, int now) = 0;
};

// Shift of the image centre by a motion, as a fraction of the image width at the mean depth of the
// level. Infinite without depth.
double ImageShift(const Rigid3d& motion, const FrameLevel& level);

}  // namespace surfit
