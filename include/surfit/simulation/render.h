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

// Where the camera is when it reads row v: world_from_camera, the same whenever it is asked.
using PoseOfRow = std::function<Rigid3d(int v)>;

// What a rolling shutter sees, each row from where the camera is then; without colours.
Rendering RenderRows(const Scene& scene, const PinholeCamera& camera,
                     const PoseOfRow& world_from_camera);

// Linear light, red, green and blue; 1 is the most that colours of gain 1 show.
using LightImage = Image<Eigen::Vector3f>;

// The light that a rolling shutter sees.
LightImage RenderLight(const Scene& scene, const PinholeCamera& camera,
                       const PoseOfRow& world_from_camera);

// The colours of light times the gains of its channels; with gains of 1 those of Render().
Image<Rgb8> Developed(const LightImage& light, const Eigen::Vector3f& gains);

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

// How colours are taken; as a whole image at one moment, with a fixed exposure, by default.
struct ColorOptions {
  double color_readout_s = 0;  // of a rolling shutter; depth's is that of the RgbdCamera
  double exposure_s = 0;       // light is gathered for so long, half of it before the moment
  int exposure_samples = 8;    // moments whose light is averaged
  // The exposure follows the brightness of the image, the gains of red and blue its tint, with such
  // time constants: ColorGains().
  double auto_exposure_lag_s = 0;       // 0 = fixed
  double auto_white_balance_lag_s = 0;  // 0 = fixed
  std::vector<double> channel_gains;    // red, green, blue; empty = 1, 1, 1

  bool ArePlain() const;
  void Visit(OptionVisitor& visitor);
};

// What the light of each frame is multiplied by, where the mean of its light is as given. With
// y_i the mean of all channels and c_i that of one, the gain of the channel is
//   channel gain * exp(e_i + w_i),   e_(i+1) = e_i + (1 - exp(-dt / lag)) (log(0.18 / y_i) - e_i),
// and so w with log(y_i / c_i) and its own lag: each frame tells the next how to be taken (mean
// grey, and a world that is grey on average). The first frame is taken as it asks for itself.
std::vector<Eigen::Vector3f> ColorGains(const std::vector<Eigen::Vector3d>& mean_light,
                                        double frames_per_second, const ColorOptions& options);

// An RGB-D camera that takes frames while it moves along a path, exact but for its timing: what
// calibration and refinement are to find. Frame i has the stamp of the path's pose i, the true
// middle of its depth's readout. Row v of h rows is read (v + 0.5) / h - 0.5 of the readout later.
// The middle of its colours' exposure and readout is color_latency_s earlier. Colours share the
// pixels of depth, but are seen from where the camera is when they are taken.
class MovingCamera {
 public:
  // Keeps a reference to the scene. `camera` as it is in truth. Throws InputError for bad options.
  MovingCamera(const Scene& scene, const RgbdCamera& camera, const Trajectory& path,
               const ColorOptions& options = {});

  // Frame i without noise, in parallel. Depth, normals and surfaces by the poses of their rows.
  Rendering Frame(int i) const;

  // world_from_camera when row v of frame i's depth is read, and of its colours at the middle of
  // that row's exposure.
  Rigid3d DepthPose(int i, int v) const;
  Rigid3d ColorPose(int i, int v) const;
  // The middle of the exposure and readout of frame i's colours.
  double ColorMoment(int i) const;
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
