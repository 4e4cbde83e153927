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
// same noise for any number of threads. Throws InputError for invalid options. Throws if `depth_m`
// does not have the size of the camera.
Image<float> KinectDepth(const Image<float>& depth_m, const PinholeCamera& camera,
                         std::uint64_t seed, const KinectOptions& options = {});

// Image of a simulated depth sensor.
struct SensorImage {
  Image<float> depth_m;  // z along the optical axis; 0: missing
  // True standard deviation of the noise of 1/z, 1/m. 0: missing pixel. Systematic errors (bleeding
  // edges, flying pixels, multipath, smoothing) are not included.
  Image<float> inverse_depth_sigma;
  Image<std::uint8_t> confidence;  // 0: low, 1: medium, 2: high; empty: the sensor has none
};

// The following sensors measure depth from exact depth, normals and colour of Render(). Reflectance
// is the luminance of the colour in linear light, so a shadow has the effect of a dark surface. A
// depth edge separates two pixels if a point is farther from the tangent plane of the other point
// than `edge_ratio` times the smaller depth. The same seed gives the same image for any number of
// threads. The functions throw InputError for invalid options. They abort if the images do not have
// the size of the camera.

// Active stereo, for example an Intel RealSense D435. Sources: Keselman et al., "Intel RealSense
// Stereoscopic Depth Cameras", CVPR Workshops 2017. Grunnet-Jepsen et al., "Best-Known-Methods for
// Tuning Intel RealSense D400 Depth Cameras", 2018. Ahn et al., "Analysis and Noise Modeling of the
// Intel RealSense D435 for Mobile Robots", UR 2019.
// - Noise is Gaussian with a constant standard deviation in inverse depth. The noise of two pixels
//   at a distance of r px has the correlation exp(-(r / correlation_px)^2), because their matching
//   windows overlap.
// - Edges bleed: pixels of the background get the depth of a nearer surface in the matching window.
//   The width of the bleeding varies along the edge from 0 to window_px.
// - The background beside the left edge of a nearer surface is occluded in the right image, and
//   missing: baseline_m f (1 / z_near - 1 / z_far) pixels.
// - Matching fails without contrast in the window. The contrast of the surface is the standard
//   deviation of its luminance. The contrast of the projected pattern is
//   projector_contrast reflectance cos(incidence) / z^2.
struct StereoOptions {
  double baseline_m = 0.05;         // D435
  double matcher_focal_px = 424;    // focal length at the resolution of the matching: 848 x 480
  double disparity_sd_px = 0.06;    // standard deviation of the disparity at this resolution
  double correlation_px = 10;       // correlation length of the noise, in pixels of the image
  double window_px = 4;             // radius of the matching window, in pixels of the image
  double edge_ratio = 0.03;         // depth edges
  double edge_loss = 0.35;          // ratio of missing pixels with a depth edge in the window
  double projector_contrast = 0.2;  // standard deviation of luminance on white, frontal, at 1 m
  double min_contrast = 0.005;      // smaller contrast is missing
  double min_contrast_sd = 0.2;     // standard deviation of log(min_contrast) in the image
  double max_incidence_deg = 78;    // larger angles of incidence are missing
  double min_depth_m = 0.28;        // smaller depth is missing
  double max_depth_m = 10;          // larger depth is missing

  // Standard deviation of the noise of 1/z, 1/m.
  double InverseDepthSigma() const { return disparity_sd_px / (baseline_m * matcher_focal_px); }
  void Visit(OptionVisitor& visitor);
};

SensorImage StereoDepth(const Rendering& exact, const PinholeCamera& camera, std::uint64_t seed,
                        const StereoOptions& options = {});

// Noise of a range by active light. The signal S of a surface at range r is
// reflectance cos(incidence) / r^2, and 1 for a white frontal surface at 1 m. Shot noise of signal
// and ambient light A gives
//   sigma^2 = floor_m^2 + shot_m^2 (S + A) / S^2
// (Lange and Seitz, "Solid-State Time-of-Flight Range Camera", IEEE J. Quantum Electronics 2001).
// The noise increases with the range and with 1 / reflectance.
struct RangeNoise {
  double floor_m = 0.0005;  // standard deviation at infinite signal
  double shot_m = 0.0005;   // shot noise at S = 1 without ambient light
  double ambient = 0.01;    // A

  // Standard deviation of a range in m. `reflected` is reflectance times cos(incidence). Infinite
  // without signal.
  double Sigma(double range_m, double reflected) const;
  void Visit(OptionVisitor& visitor);
};

// Continuous-wave time of flight, for example an Azure Kinect. Sources: Toelgyessy et al.,
// "Evaluation of the Azure Kinect and Its Comparison to Kinect V1 and Kinect V2", Sensors 2021.
// Sarbolandi et al., "Kinect Range Sensing", CVIU 2015.
// - Noise is Gaussian and independent per pixel: RangeNoise. The default is near the measured noise
//   of the narrow unbinned mode (0.6 mm at 0.8 m, 0.9 mm at 1.5 m, 1.7 mm at 3 m).
// - Multipath: light that reaches a point x over a visible point y has a longer way, by 2 e with
//   e = (|y| + |y - x| - |x|) / 2 > 0. The range gets the bias sum(a e) / (1 + sum(a)) over all y.
//   a is the irradiance of x by y divided by the direct irradiance, times exp(-(e / l)^2 / 2).
//   Surfaces are diffuse and light has one bounce. l is c / (4 pi modulation_hz). The phases of
//   light with longer ways cancel. Concave creases get a positive bias. Convex edges and planes get
//   none.
// - Flying pixels: `flying_ratio` of the pixels beside a depth edge mix the ranges of both
//   surfaces. The area ratio of the mixture is uniform, and the signals are the weights.
struct TofOptions {
  RangeNoise noise;
  double multipath_gain = 1;   // factor of the irradiance over other surfaces; 0: no multipath
  double modulation_hz = 2e8;  // frequency of the modulated light; l = 0.12 m
  double flying_ratio = 0.5;   // of the pixels beside a depth edge
  double edge_ratio = 0.03;    // depth edges
  double max_sigma_m = 0.017;  // larger noise is missing: dark, oblique and far surfaces
  double min_depth_m = 0.5;    // smaller depth is missing
  double max_depth_m = 5.46;   // larger depth is missing

  void Visit(OptionVisitor& visitor);
};

SensorImage TofDepth(const Rendering& exact, const PinholeCamera& camera, std::uint64_t seed,
                     const TofOptions& options = {});

// Lidar of a phone, for example ARKit's scene depth. Sources: Luetzenburg et al., "Evaluation of
// the Apple iPhone 12 Pro LiDAR", Scientific Reports 2021. Baruch et al., "ARKitScenes", NeurIPS
// 2021. A grid of dots is ranged with RangeNoise. A plane in inverse depth is fitted to the dots
// around each pixel. The weights depend on distance and colour difference (Kopf et al., "Joint
// Bilateral Upsampling", SIGGRAPH 2007). The image is dense and smoothed across depth edges without
// colour edges. Confidence is
// - low without an exact surface, within `edge_px` of a depth edge, and if RangeNoise of the pixel
//   exceeds medium_sigma_m,
// - else medium within 2 `edge_px` of a depth edge, and if RangeNoise exceeds high_sigma_m,
// - else high.
struct LidarOptions {
  RangeNoise noise = {0.004, 0.002, 0.01};
  int dots_across = 24, dots_down = 24;
  double color_scale = 0.1;     // colour difference with the weight exp(-1/2); white minus black: 1
  double edge_ratio = 0.03;     // depth edges
  double edge_px = 3;           // radius of low confidence around depth edges
  double high_sigma_m = 0.015;  // largest RangeNoise for high confidence
  double medium_sigma_m = 0.03;  // largest RangeNoise for medium confidence

  void Visit(OptionVisitor& visitor);
};

SensorImage LidarDepth(const Rendering& exact, const PinholeCamera& camera, std::uint64_t seed,
                       const LidarOptions& options = {});

// Options of the colour camera. Default: global shutter and fixed exposure.
struct ColorOptions {
  double color_readout_s = 0;  // rolling-shutter readout of colour
  double exposure_s = 0;       // exposure time, centred at the capture time
  int exposure_samples = 8;    // rendered samples per exposure
  // Time constants of auto exposure and of auto white balance: ColorGains().
  double auto_exposure_lag_s = 0;       // 0: fixed
  double auto_white_balance_lag_s = 0;  // 0: fixed
  std::vector<double> channel_gains;    // red, green, blue; empty: 1, 1, 1

  // True for a global shutter, no motion blur, no automatic gains and empty channel_gains.
  bool ArePlain() const;
  void Visit(OptionVisitor& visitor);
};

// Computes the gains of the channels per frame from the mean light of each frame:
//   gain = channel gain * exp(e_i + w_i),
//   e_(i+1) = e_i + (1 - exp(-dt / lag)) (log(0.18 / y_i) - e_i).
// y_i is the mean of all channels, and c_i the mean of one channel. w_i follows log(y_i / c_i) by
// the same rule with its own lag. Each frame changes the gains of the next frame, towards a grey
// mean. The gains of the first frame suit its own light. A lag of 0 gives e_i = 0 or w_i = 0. Means
// below 1e-3 are raised to 1e-3. The options are not validated.
std::vector<Eigen::Vector3f> ColorGains(const std::vector<Eigen::Vector3d>& mean_light,
                                        double frames_per_second, const ColorOptions& options);

// Moving RGB-D camera with exact measurements and realistic timing, as test data for calibration
// and refinement. Frame i has the time of pose i of the path: the middle of its depth readout. Row
// v of h rows is read ((v + 0.5) / h - 0.5) readout_s later. Colour is captured `color_latency_s`
// earlier, with the pixels of depth and the pose at its capture time.
class MovingCamera {
 public:
  // Keeps a reference to the scene, which must outlive this object. `camera` has the true
  // parameters. Only its depth camera, readout_s, color_latency_s and frames_per_second have an
  // effect. Throws InputError for an invalid camera or invalid options. Throws for an empty path,
  // and unless its times increase.
  MovingCamera(const Scene& scene, const RgbdCamera& camera, const Trajectory& path,
               const ColorOptions& options = {});

  // Renders frame i without noise, in parallel. Depth, normals and surfaces use one pose per row.
  // Throws if i is out of range, which the functions below do not check.
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
