// Ray-traces an RGB-D sequence with exact ground truth.

#include <gflags/gflags.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iomanip>
#include <iostream>
#include <thread>
#include <vector>

#include "common/lists.h"
#include "common/tool_main.h"
#include "simulate/sequence_writer.h"
#include "simulate/surface_sampler.h"
#include "surfit/core/error.h"
#include "surfit/core/parallel.h"
#include "surfit/frame/correct_depth.h"
#include "surfit/simulation/camera_path.h"
#include "surfit/simulation/render.h"
#include "surfit/simulation/scene.h"

DEFINE_string(output, "", "folder of the sequence; must be empty, new or of a former simulation");
DEFINE_string(
    scene, "room",
    "room, three_rooms (1500 frames lead through them and back), three_planes, wall, sphere "
    "or corridor");
DEFINE_int32(frames, 200, "number of frames");
DEFINE_int32(seed, 4, "another seed gives another room, another path and other noise");
DEFINE_string(sensor, "kinect", "ideal (exact depth) or kinect (noise model of a Kinect v1)");
DEFINE_double(inverse_depth_offset, 0,
              "1/m, what a sensor out of calibration adds to each 1 / z: 0.00667 makes 3 m too "
              "near by 2 %; camera.yaml does not tell");
DEFINE_string(inverse_depth_distortion, "",
              "c1,c2,c3,c4,c5 in 1/m: what it adds besides, c1 x + c2 y + c3 x^2 + c4 x y + c5 y^2 "
              "at the ray (x, y, 1); camera.yaml does not tell");
DEFINE_int32(downsample, 1, "1 to 16: keep every n-th pixel of 640 x 480 in each direction");
DEFINE_bool(image_y_up, false,
            "write the convention of ICL-NUIM: numbered frames, fy < 0, the poses those of the "
            "scene mirrored by diag(1, -1, 1); surface.ply is right-handed all the same");
DEFINE_double(surface_grid_m, 0.005, "distance between the points of surface.ply");
DEFINE_int32(threads, 0, "threads that compute at the same time; 0: as many as the machine has");

namespace surfit::tools {
namespace {

// The surface is sampled in each fifth frame: the camera then has moved by 5 to 10 cm.
constexpr int kSurfaceStride = 5;

void CheckFlags() {
  if (FLAGS_output.empty()) throw InputError("--output is empty, must name a folder");
  if (FLAGS_sensor != "ideal" && FLAGS_sensor != "kinect")
    throw InputError(Concat("--sensor is '", FLAGS_sensor, "', must be 'ideal' or 'kinect'"));
  if (FLAGS_frames < 1)
    throw InputError(Concat("--frames is ", FLAGS_frames, ", must be at least 1"));
  if (FLAGS_seed < 0) throw InputError(Concat("--seed is ", FLAGS_seed, ", must not be negative"));
  if (FLAGS_downsample < 1 || FLAGS_downsample > 16)
    throw InputError(Concat("--downsample is ", FLAGS_downsample, ", must be from 1 to 16"));
  if (!(FLAGS_surface_grid_m >= 0.001))
    throw InputError(
        Concat("--surface_grid_m is ", FLAGS_surface_grid_m, ", must be at least 0.001"));
}

// What the sensor adds to each inverse depth.
InverseDepthField DepthError() {
  constexpr double kLargest = 0.1;
  InverseDepthField error;
  if (!FLAGS_inverse_depth_distortion.empty()) {
    const std::vector<double> varying =
        NumberList("inverse_depth_distortion", FLAGS_inverse_depth_distortion);
    if (varying.size() + 1 != InverseDepthField::kSize)
      throw InputError(Concat("--inverse_depth_distortion is ", FLAGS_inverse_depth_distortion,
                              ", must be five numbers"));
    std::copy(varying.begin(), varying.end(), error.coefficients.begin() + 1);
  }
  error.coefficients[0] = FLAGS_inverse_depth_offset;
  for (const double coefficient : error.coefficients) {
    if (!(std::abs(coefficient) <= kLargest))
      throw InputError(Concat("--inverse_depth_offset and --inverse_depth_distortion have ",
                              coefficient, ", must be from ", -kLargest, " to ", kLargest));
  }
  return error;
}

RgbdCamera SimulatedCamera() {
  RgbdCamera camera;
  camera.depth.width = 640;
  camera.depth.height = 480;
  camera.depth.fx = camera.depth.fy = 525;
  camera.depth.cx = 319.5;
  camera.depth.cy = 239.5;
  camera.depth = camera.depth.Subsampled(FLAGS_downsample);
  return camera;
}

struct SimulatedFrame {
  Rendering exact;
  Image<float> depth_m;
};

SimulatedFrame Simulate(const Scene& scene, const PinholeCamera& camera,
                        const InverseDepthField& error, const Rigid3d& pose, int index) {
  SimulatedFrame frame;
  frame.exact = Render(scene, camera, pose);
  const auto seed = (static_cast<std::uint64_t>(FLAGS_seed) << 32) + index;
  frame.depth_m = FLAGS_sensor == "ideal" ? frame.exact.depth_m
                                          : KinectDepth(frame.exact.depth_m, camera, seed);
  if (!error.IsZero()) CorrectDepth(camera, error, &frame.depth_m);
  return frame;
}

class Progress {
 public:
  explicit Progress(int total) : total_(total) {}
  void Show(int done) const {
    const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - start_;
    const double fps = done / passed.count();
    std::cerr << "\rframe " << done << " of " << total_ << ", " << std::fixed
              << std::setprecision(1) << fps << " fps, " << std::setprecision(0)
              << (total_ - done) / fps << " s left   " << (done == total_ ? "\n" : "")
              << std::flush;
  }

 private:
  int total_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

// Frames are rendered and written side by side, the surface is collected in their order.
SurfaceSampler WriteFrames(const Scene& scene, const PinholeCamera& camera,
                           const InverseDepthField& error, const Trajectory& path,
                           const SequenceWriter& writer) {
  constexpr int kBatch = 10;
  SurfaceSampler surface(FLAGS_surface_grid_m);
  const Progress progress(static_cast<int>(path.size()));
  const int frames = static_cast<int>(path.size());
  for (int begin = 0; begin < frames; begin += kBatch) {
    const int end = std::min(frames, begin + kBatch);
    std::vector<SimulatedFrame> batch(end - begin);
    ParallelFor(begin, end, 1, [&](int i, int) {
      SimulatedFrame frame = Simulate(scene, camera, error, path[i].world_from_camera, i);
      writer.WriteFrame(i, path[i].stamp_s, frame.exact.color, frame.depth_m);
      if (i % kSurfaceStride == 0 || i + 1 == frames) batch[i - begin] = std::move(frame);
    });
    for (int i = begin; i < end; ++i) {
      const SimulatedFrame& frame = batch[i - begin];
      if (frame.depth_m.empty()) continue;
      surface.Add(frame.exact, frame.depth_m, camera, path[i].world_from_camera);
    }
    progress.Show(end);
  }
  return surface;
}

int Run() {
  CheckFlags();
  const InverseDepthField error = DepthError();
  const ThreadLimit limit(FLAGS_threads == 0
                              ? static_cast<int>(std::max(1u, std::thread::hardware_concurrency()))
                              : FLAGS_threads);
  const Scene scene = MakeScene(FLAGS_scene, FLAGS_seed);
  const RgbdCamera camera = SimulatedCamera();
  PathOptions path_options;
  path_options.frames_per_second = camera.frames_per_second;
  const Trajectory path = MakePath(scene, FLAGS_frames, FLAGS_seed, path_options);
  const SequenceWriter writer(
      FLAGS_output, FLAGS_image_y_up ? SequenceLayout::kIclNuim : SequenceLayout::kTum, camera);
  writer.WriteLists(path);
  const SurfaceSampler surface = WriteFrames(scene, camera.depth, error, path, writer);
  WritePly(surface.cloud(), FLAGS_output + "/surface.ply");
  std::cout << path.size() << " frames and " << surface.cloud().points.size()
            << " points of the exact surface in " << FLAGS_output << std::endl;
  return kDone;
}

}  // namespace
}  // namespace surfit::tools

int main(int argc, char** argv) {
  return surfit::tools::ToolMain(argc, argv,
                                 "simulates an RGB-D sequence (TUM layout) with exact ground truth",
                                 &surfit::tools::Run);
}
