#pragma once

#include <cstdint>

#include "surfit/core/image.h"
#include "surfit/frame/frame_pyramid.h"
#include "surfit/frame/rgbd_frame.h"
#include "surfit/geometry/pinhole_camera.h"
#include "surfit/simulation/scene.h"

namespace surfit {

class OptionVisitor;

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

// A Kinect v1, after Handa, Whelan, McDonald and Davison, "A Benchmark for RGB-D Visual Odometry,
// 3D Reconstruction and SLAM", ICRA 2014, and Barron and Malik, "Intrinsic Scene Properties from a
// Single RGB-D Image", CVPR 2013.
struct KinectOptions {
  double shift_sd_px = 0.5;             // random shift of each pixel, in u and in v
  double disparity_sd = 1.0 / 6.0;      // of the disparity, in quantisation steps
  double disparity_times_z_cm = 35130;  // disparity step number = this / z_cm
  double min_depth_m = 0.4;             // nearer is missing
  double max_depth_m = 4.5;             // farther is missing
  double max_incidence_deg = 80;        // seen more obliquely is missing
  double max_edge_ratio =
      0.02;  // shifts do not cross steps of depth beyond this share of the depth

  void Visit(OptionVisitor& visitor);
};

// What a Kinect measures where the exact depth is depth_m:
//   z_cm = 35130 / round(35130 / z_cm(u + N(0, 1/2), v + N(0, 1/2)) + N(0, 1/6)).
// The disparity is interpolated linearly between pixels. The angle of incidence is that of the
// depth image itself (central differences), so that pixels at steps of depth are missing as well.
// 0 = missing, in both images. The same seed gives the same noise, at any number of threads.
Image<float> KinectDepth(const Image<float>& depth_m, const PinholeCamera& camera,
                         std::uint64_t seed, const KinectOptions& options = {});

}  // namespace surfit
