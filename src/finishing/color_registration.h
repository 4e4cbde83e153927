#pragma once

#include "mapping/rendering/blended_view.h"
#include "surfit/core/image.h"
#include "surfit/frame/camera_motion.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/geometry/sensor.h"
#include "surfit/mapping/model_renderer.h"
#include "surfit/mapping/surfel_map.h"
#include "surfit/registration/normal_system.h"

namespace surfit {

// Pose of the camera `seconds` after `world_from_camera`, at constant velocity. Negative: before.
Rigid3d ExtrapolatePose(const Rigid3d& world_from_camera, const CameraMotion& motion,
                        double seconds);

// Colour and depth (0: no surfel) of a view by ModelRenderer, which is faster than DrawBlended().
// The map must not have changed since the view was rendered.
BlendedView DrawnDiscs(const ModelView& view, const SurfelMap& map);

// Pose of a colour image before its registration, with the information (1/rad^2, 1/m^2) of the left
// perturbation of camera from world.
struct ExpectedColorPose {
  Rigid3d world_from_color;
  Matrix6d information = Variances(0.01, 0.01).inverse();
};

// Result of RegisterColors(). The costs are mean robust costs of the points at the compared pose
// and at the result, each with its best exposure. 0 and 0 if the pose is not registered.
struct RegisteredColors {
  Rigid3d world_from_color;
  double cost_before = 0, cost_after = 0;

  bool is_registered() const { return cost_before > 0; }
};

// Registers a colour image to a rendered view of the map, and returns the camera pose at the
// capture time of the image. This corrects errors of colour timestamps, interpolated motion and
// weakly constrained poses.
//
// Minimises over the pose increment d and the exposure (gain, offset):
//   sum rho((I(pi(X - tau (turn x X + velocity))) - gain J - offset) / 0.06) / 25 + d^T P d
//   X    point of the view with the intensity J, in the camera frame
//   I    intensity of the image
//   tau  capture time of the image row of X, relative to the middle row
//   rho  robust kernel of Geman and McClure
//   P    information of the expected pose
// Every fourth pixel of the view is used, if it has texture. The divisor 25 accounts for correlated
// errors of neighbouring pixels. The exposure is damped, without a prior.
//
// `drawn` is the rendered view at `world_from_drawn`, with the camera of `sensor`. `color` is the
// measured image, without rolling-shutter correction. The view has the size of
// PinholeCamera::Binned() of the image, which is not checked. Returns the expected pose for fewer
// than 500 visible textured points, or if a step is not finite. `motion`: camera velocity, zero:
// none. `world_from_compared`: pose for RegisteredColors::cost_before. The minimisation runs 12
// Gauss-Newton steps in two passes.
RegisteredColors RegisterColors(const Image<Rgb8>& color, const BlendedView& drawn,
                                const DepthSensor& sensor, const CameraMotion& motion,
                                const Rigid3d& world_from_drawn, const ExpectedColorPose& expected,
                                const Rigid3d& world_from_compared);

}  // namespace surfit
