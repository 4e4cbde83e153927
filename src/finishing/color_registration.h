#pragma once

#include "mapping/rendering/blended_view.h"
#include "surfit/core/image.h"
#include "surfit/frame/camera_motion.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/geometry/sensor.h"
#include "surfit/mapping/model_renderer.h"
#include "surfit/mapping/surfel_map.h"

namespace surfit {

// Pose of the camera `seconds` after `world_from_camera`, at constant velocity. Negative: before.
Rigid3d ExtrapolatePose(const Rigid3d& world_from_camera, const CameraMotion& motion,
                        double seconds);

// Renders colour and depth (0: no surfel) of the map with ModelRenderer, which is faster than
// DrawBlended(). `renderer` may have any options. Not thread-safe for one renderer.
BlendedView RenderDiscs(const SurfelMap& map, const DepthSensor& sensor,
                        const Rigid3d& world_from_view, ModelRenderer* renderer);

// Registers a colour image to a rendered view of the map, and returns the camera pose at the
// capture time of the image. This corrects errors of colour timestamps, interpolated motion and
// weakly constrained poses.
//
// Minimises over the pose increment d and the exposure (gain, offset):
//   sum rho((I(pi(X - tau (turn x X + velocity))) - gain J - offset) / 0.06) / 25 + |d|^2 / s^2
//   X    point of the view with the intensity J, in the camera frame
//   I    intensity of the image
//   tau  capture time of the image row of X, relative to the middle row
//   rho  robust kernel of Geman and McClure
//   s    prior of the rendered pose: 1 cm and 10 mrad
// Every fourth pixel of the view is used, if it has texture. The divisor 25 accounts for correlated
// errors of neighbouring pixels. The exposure is damped, without a prior.
//
// `drawn` is the rendered view at `world_from_drawn`, with the camera of `sensor`. `color` is the
// measured image, without rolling-shutter correction. The view has the size of
// PinholeCamera::Binned() of the image, which is not checked. Returns `world_from_drawn` for fewer
// than 500 visible textured points, or if a step is not finite. `motion`: camera velocity, zero:
// none. The minimisation runs 12 Gauss-Newton steps in two passes.
Rigid3d RegisterColors(const Image<Rgb8>& color, const BlendedView& drawn,
                       const DepthSensor& sensor, const CameraMotion& motion,
                       const Rigid3d& world_from_drawn);

}  // namespace surfit
