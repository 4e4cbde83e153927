#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <vector>

#include "surfit/core/image.h"
#include "surfit/frame/frame_pyramid.h"
#include "surfit/frame/rgbd_frame.h"
#include "surfit/geometry/pinhole_camera.h"
#include "surfit/geometry/sensor.h"
#include "surfit/simulation/camera_path.h"
#include "surfit/simulation/scene.h"

namespace surfit {

class OptionVisitor;

// Ideal RGB-D images: one ray per pixel centre.
struct Rendering {
  static constexpr std::int32_t kNothing = -1;

  Image<float> depth_m;         // exact z along the optical axis; 0: no surface
  Image<Rgb8> color;            // (0, 0, 0): no surface
  VectorImage normal;           // camera frame, unit length; (0, 0, 0): no surface
  Image<std::int32_t> surface;  // number of the visible surface, or kNothing

  // Surface numbers are unique in the scene. Each flat face has a number. Curved parts of an object
  // share a number.
  static std::int32_t SurfaceOf(const SceneHit& hit) {
    return hit.object * (Shape::kMaxFaces + 1) + hit.face + 1;
  }
  static bool IsFlat(std::int32_t surface) {
    return surface != kNothing && surface % (Shape::kMaxFaces + 1) != 0;
  }
};

// Ray-traces the scene in parallel, without lens distortion. Throws InputError for an invalid
// camera.
Rendering Render(const Scene& scene, const PinholeCamera& camera, const Rigid3d& world_from_camera);

// Like Render(), with an empty colour image.
Rendering RenderGeometry(const Scene& scene, const PinholeCamera& camera,
                         const Rigid3d& world_from_camera);

// Returns world_from_camera at the time of row v. Called from several threads. Must be
// deterministic.
using PoseOfRow = std::function<Rigid3d(int v)>;

// Like RenderGeometry(), for a rolling shutter: each row has its own pose.
Rendering RenderRows(const Scene& scene, const PinholeCamera& camera,
                     const PoseOfRow& world_from_camera);

// Linear light of red, green and blue. 1 saturates a pixel at gain 1.
using LightImage = Image<Eigen::Vector3f>;

// Renders the linear light of a rolling-shutter image. Throws InputError for an invalid camera.
LightImage RenderLight(const Scene& scene, const PinholeCamera& camera,
                       const PoseOfRow& world_from_camera);

// Converts linear light times the channel gains to sRGB. Gains of 1 give the colours of Render().
Image<Rgb8> ToSrgbImage(const LightImage& light, const Eigen::Vector3f& gains);

// Renders depth and colour as a frame of a sequence. Throws InputError for an invalid camera.
RgbdFrame RenderFrame(const Scene& scene, const PinholeCamera& camera,
                      const Rigid3d& world_from_camera, int index = 0, double stamp_s = 0);

// Noise model of a Kinect v1:
// - Handa, Whelan, McDonald and Davison, "A Benchmark for RGB-D Visual Odometry, 3D Reconstruction
//   and SLAM", ICRA 2014
// - Barron and Malik, "Intrinsic Scene Properties from a Single RGB-D Image", CVPR 2013
struct KinectOptions {
  double shift_sd_px = 0.5;         // pixel shift in u and v
  double disparity_sd = 1.0 / 6.0;  // standard deviation of the disparity, in quantisation steps
  double disparity_times_z_cm = 35130;  // disparity in steps = this / z_cm
  double min_depth_m = 0.4;             // smaller depth is missing
  double max_depth_m = 4.5;             // larger depth is missing
  double max_incidence_deg = 80;        // larger angles of incidence are missing
  // Shifts do not cross depth edges above this ratio of the depth.
  double max_edge_ratio = 0.02;

  void Visit(OptionVisitor& visitor);
};

// Simulates the depth (m) of a Kinect from the exact depth. With the default options:
//   z_cm = 35130 / round(35130 / z_cm(u + N(0, 1/2), v + N(0, 1/2)) + N(0, 1/6)).
// Disparity is interpolated linearly. The angle of incidence is from central differences of depth,
// so pixels at depth edges are missing, too. 0: missing, in both images. The same seed gives the
// same noise for any number of threads. Throws InputError for invalid options. Aborts if `depth_m`
// does not have the size of the camera.
Image<float> KinectDepth(const Image<float>& depth_m, const PinholeCamera& camera,
                         std::uint64_t seed, const KinectOptions& options = {});

// Options of the colour camera. Default: global shutter, fixed exposure.
struct ColorOptions {
  double color_readout_s = 0;  // rolling-shutter readout of colour
  double exposure_s = 0;       // exposure time, centred at the capture time
  int exposure_samples = 8;    // rendered samples per exposure
  // Time constants of auto exposure and of auto white balance: ColorGains().
  double auto_exposure_lag_s = 0;       // 0: fixed
  double auto_white_balance_lag_s = 0;  // 0: fixed
  std::vector<double> channel_gains;    // red, green, blue; empty: 1, 1, 1

  // True for a global shutter, no motion blur and fixed gains of 1.
  bool ArePlain() const;
  void Visit(OptionVisitor& visitor);
};

// Computes the gains of the channels per frame from the mean light of each frame:
//   gain = channel gain * exp(e_i + w_i),
//   e_(i+1) = e_i + (1 - exp(-dt / lag)) (log(0.18 / y_i) - e_i).
// y_i is the mean of all channels, and c_i the mean of one channel. w_i follows log(y_i / c_i) by
// the same rule with its own lag. Each frame changes the gains of the next frame, towards a grey
// mean. The gains of the first frame suit its own light.
std::vector<Eigen::Vector3f> ColorGains(const std::vector<Eigen::Vector3d>& mean_light,
                                        double frames_per_second, const ColorOptions& options);

// Moving RGB-D camera with exact measurements and realistic timing, as test data for calibration
// and refinement. Frame i has the timestamp of pose i of the path: the middle of its depth readout.
// Row v of h rows is read ((v + 0.5) / h - 0.5) readout_s later. Colour is captured
// `color_latency_s` earlier, with the pixels of depth and the pose at its capture time.
class MovingCamera {
 public:
  // Keeps a reference to the scene, which must outlive this object. `camera` has the true
  // parameters. Only its depth camera, readout_s, color_latency_s and frames_per_second have an
  // effect. Throws InputError for an invalid camera or invalid options. Aborts for an empty path,
  // and unless timestamps increase.
  MovingCamera(const Scene& scene, const RgbdCamera& camera, const Trajectory& path,
               const ColorOptions& options = {});

  // Renders frame i without noise, in parallel. Depth, normals and surfaces use one pose per row.
  // Aborts if i is out of range.
  Rendering Frame(int i) const;

  // world_from_camera for row v: at its depth readout, and at the middle of its colour exposure.
  Rigid3d DepthPose(int i, int v) const;
  Rigid3d ColorPose(int i, int v) const;
  // Middle of the colour exposure and readout of frame i, s.
  double ColorCaptureTime(int i) const;
  // Gains of red, green and blue of frame i.
  const Eigen::Vector3f& gains(int i) const { return gains_[i]; }

 private:
  Rigid3d PoseAt(double middle_s, double readout_s, int v) const;
  LightImage Light(int i) const;
  std::vector<Eigen::Vector3d> MeanLight() const;

  const Scene& scene_;
  RgbdCamera camera_;
  SmoothPath path_;
  ColorOptions options_;
  std::vector<Eigen::Vector3f> gains_;
};

}  // namespace surfit
