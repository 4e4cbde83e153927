#pragma once

#include "mapping/rendering/blended_view.h"
#include "surfit/core/image.h"
#include "surfit/frame/camera_motion.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/geometry/sensor.h"
#include "surfit/mapping/model_renderer.h"
#include "surfit/mapping/surfel_map.h"

namespace surfit {

// Extrapolates a pose by `seconds` with constant motion.
Rigid3d ExtrapolatePose(const Rigid3d& world_from_camera, const CameraMotion& motion,
                        double seconds);

// Renders colour and depth of the map with ModelRenderer, which is faster than DrawBlended().
BlendedView RenderDiscs(const SurfelMap& map, const DepthSensor& sensor,
                        const Rigid3d& world_from_view, ModelRenderer* renderer);

// Registers a colour image to a rendered view of the map, and returns the camera pose at the
// capture time of the image. This corrects errors of colour timestamps, of the interpolated motion
// and of poses along weakly constrained directions.
//
// Minimises over the pose increment d and the exposure (gain, offset):
//   sum rho((I(pi(X - tau (turn x X + velocity))) - gain J - offset) / 0.06) / 25 + |d|^2 / s^2
//   X    point of the view with the intensity J, in the camera frame
//   I    intensity of the image
//   tau  capture time of the image row of X, relative to the middle row
//   rho  robust kernel of Geman and McClure
//   s    prior of the rendered pose: 1 cm and 10 mrad
// Every fourth pixel is used. Neighbouring pixels share most of their errors, so 25 of these pixels
// have the weight of one.
//
// `drawn` is the view of the map from `world_from_drawn` by the camera of `sensor`. The size of the
// image is a multiple of the size of the view, and the image is reduced to that size. Returns
// `world_from_drawn` if the image shows fewer than 500 textured points of the view, or if a step is
// not finite.
Rigid3d RegisterColors(const Image<Rgb8>& color, const BlendedView& drawn,
                       const DepthSensor& sensor, const CameraMotion& motion,
                       const Rigid3d& world_from_drawn);

}  // namespace surfit
