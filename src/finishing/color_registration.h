#pragma once

#include "mapping/rendering/blended_view.h"
#include "surfit/core/image.h"
#include "surfit/frame/camera_motion.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/geometry/sensor.h"
#include "surfit/mapping/model_renderer.h"
#include "surfit/mapping/surfel_map.h"

namespace surfit {

// Where the camera is at `seconds` after the moment of a pose that it moves so at.
Rigid3d PoseAfter(const Rigid3d& world_from_camera, const CameraMotion& motion, double seconds);

// A picture of the map by the discs of ModelRenderer, which takes less time than DrawBlended().
BlendedView DrawDiscs(const SurfelMap& map, const DepthSensor& sensor,
                      const Rigid3d& world_from_view, ModelRenderer* renderer);

// Where the camera was when it took a colour image, as far as a picture of a map from about there
// tells. The stamps of colours are not exact, nor is the motion from depth's moment to theirs, nor
// a pose along what shapes do not hold. With a point X that the picture shows with intensity J,
//   minimise over the pose's increment d, gain and offset of the exposure
//     sum rho((I(pi(X - tau (turn x X + velocity)) - gain J - offset) / 0.06) / 25 + |d|^2 / s^2,
// I the image, tau the time of the row that shows it from the middle row on, rho of Geman and
// McClure. Neighbouring pixels share most of their errors: of each fourth one, 25 count as one. The
// pose that the picture was drawn from, by the sensor, is right to s = 1 cm and 10 mrad; it is
// returned where too little is seen. The image has the size of the picture, or a multiple of it,
// and is made as small.
Rigid3d RegisterColors(const Image<Rgb8>& color, const BlendedView& drawn,
                       const DepthSensor& sensor, const CameraMotion& motion,
                       const Rigid3d& world_from_drawn);

}  // namespace surfit
