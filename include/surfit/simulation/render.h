#pragma once

#include <cstdint>

#include "surfit/core/image.h"
#include "surfit/frame/rgbd_frame.h"
#include "surfit/frame/vector_image.h"
#include "surfit/geometry/pinhole_camera.h"
#include "surfit/simulation/scene.h"

namespace surfit {

// What an ideal RGB-D camera sees: one ray through the centre of each pixel.
struct Rendering {
  static constexpr std::int32_t kNothing = -1;

  Image<float> depth_m;  // exact z along the optical axis; 0 where nothing is seen
  Image<Rgb8> color;     // (0, 0, 0) where nothing is seen
  VectorImage normal;    // in the camera's frame, unit length; (0, 0, 0) where nothing is seen
  Image<std::int32_t> surface;  // which surface of the scene is seen, or kNothing

  // Surfaces are numbered through the scene: a flat face has a number of its own, all curved parts
  // of one object share one.
  static std::int32_t SurfaceOf(const SceneHit& hit) {
    return hit.object * (Shape::kMostFaces + 1) + hit.face + 1;
  }
  static bool IsFlat(std::int32_t surface) {
    return surface != kNothing && surface % (Shape::kMostFaces + 1) != 0;
  }
};

// Ray-traces the scene, in parallel over tiles. The camera's distortion is ignored.
Rendering Render(const Scene& scene, const PinholeCamera& camera, const Rigid3d& world_from_camera);

// The same but for the colours, whose image stays empty.
Rendering RenderGeometry(const Scene& scene, const PinholeCamera& camera,
                         const Rigid3d& world_from_camera);

// The same as a frame of a sequence.
RgbdFrame RenderFrame(const Scene& scene, const PinholeCamera& camera,
                      const Rigid3d& world_from_camera, int index = 0, double stamp_s = 0);

}  // namespace surfit
