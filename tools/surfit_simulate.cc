// Ray-traces an RGB-D sequence with exact ground truth.

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <iostream>
#include <thread>
#include <vector>

#include "common/console.h"
#include "common/tool_main.h"
#include "simulate/sequence_writer.h"
#include "simulate/surface_sampler.h"
#include "surfit/core/error.h"
#include "surfit/core/parallel.h"
#include "surfit/frame/prepare_frame.h"
#include "surfit/simulation/camera_path.h"
#include "surfit/simulation/render.h"
#include "surfit/simulation/scene.h"

namespace surfit::tools {
namespace {

// The surface is sampled in each fifth frame: the camera then has moved by 5 to 10 cm.
constexpr int kSurfaceStride = 5;

struct Options {
  std::string output;
  std::string scene = "room";
  int frames = 200;
  int seed = 4;
  std::string sensor = "kinect";
  double inverse_depth_offset = 0;
  std::vector<double> inverse_depth_distortion;
  int downsample = 1;
  bool image_y_up = false;
  double surface_grid_m = 0.005;
  int threads = 0;

  void Visit(OptionVisitor& v) {
    v.Add(output, "output", "folder of the sequence; must be empty, new or of a former simulation",
          Required(), AsFlag());
    v.Add(scene, "scene", "scene; three_rooms: 1500 frames lead through them and back",
          OneOf(SceneNames()), AsFlag());
    v.Add(frames, "frames", "number of frames", AtLeast(1), AsFlag());
    v.Add(seed, "seed", "another seed gives another room, another path and other noise", AtLeast(0),
          AsFlag());
    v.Add(sensor, "sensor", "exact depth, or the noise model of a Kinect v1",
          OneOf({"ideal", "kinect"}), AsFlag());
    v.Add(inverse_depth_offset, "inverse_depth_offset",
          "what a sensor out of calibration adds to each 1 / z: 0.00667 makes 3 m too near by 2 %; "
          "camera.yaml does not tell",
          Between(-0.1, 0.1), InUnit("1/m"), AsFlag());
    v.Add(inverse_depth_distortion, "inverse_depth_distortion",
          "c1,c2,c3,c4,c5: what it adds besides, c1 x + c2 y + c3 x^2 + c4 x y + c5 y^2 at the ray "
          "(x, y, 1); camera.yaml does not tell",
          InUnit("1/m"), AsFlag());
    v.Add(downsample, "downsample", "keep every n-th pixel of 640 x 480 in each direction",
          Between(1, 16), AsFlag());
    v.Add(image_y_up, "image_y_up",
          "write the convention of ICL-NUIM: numbered frames, fy < 0, the poses those of the scene "
          "mirrored by diag(1, -1, 1); surface.ply is right-handed all the same",
          AsFlag());
    v.Add(surface_grid_m, "surface_grid_m", "distance between the points of surface.ply",
          AtLeast(0.001), AsFlag());
    v.Add(threads, "threads", "threads that compute at the same time", Between(0, 1024),
          ZeroIs("as many as the machine has"), AsFlag());
  }
};

// What the sensor adds to each inverse depth.
InverseDepthField DepthError(const Options& options) {
  constexpr double kLargest = 0.1;
  InverseDepthField error;
  const std::vector<double>& varying = options.inverse_depth_distortion;
  if (!varying.empty() && varying.size() + 1 != InverseDepthField::kSize)
    throw InputError(
        Concat("--inverse_depth_distortion is ", OptionToText(varying), ", must be five numbers"));
  std::copy(varying.begin(), varying.end(), error.coefficients.begin() + 1);
  error.coefficients[0] = options.inverse_depth_offset;
  for (const double coefficient : varying) {
    if (!(std::abs(coefficient) <= kLargest))
      throw InputError(Concat("--inverse_depth_distortion has ", coefficient, ", must be from ",
                              -kLargest, " to ", kLargest));
  }
  return error;
}

RgbdCamera SimulatedCamera(int downsample) {
  RgbdCamera camera;
  camera.depth.width = 640;
  camera.depth.height = 480;
  camera.depth.fx = camera.depth.fy = 525;
  camera.depth.cx = 319.5;
  camera.depth.cy = 239.5;
  camera.depth = camera.depth.Subsampled(downsample);
  return camera;
}

struct SimulatedFrame {
  Rendering exact;
  Image<float> depth_m;
};

SimulatedFrame Simulate(const Options& options, const Scene& scene, const PinholeCamera& camera,
                        const InverseDepthField& error, const Rigid3d& pose, int index) {
  SimulatedFrame frame;
  frame.exact = Render(scene, camera, pose);
  const auto seed = (static_cast<std::uint64_t>(options.seed) << 32) + index;
  frame.depth_m = options.sensor == "ideal" ? frame.exact.depth_m
                                            : KinectDepth(frame.exact.depth_m, camera, seed);
  if (!error.IsZero()) CorrectDepth(camera, error, &frame.depth_m);
  return frame;
}

void ShowProgress(int done, int total, ProgressLine* line) {
  const double fps = done / line->elapsed_s();
  line->Show(Concat("frame ", done, " of ", total, ", ", std::fixed, std::setprecision(1), fps,
                    " fps, ", std::setprecision(0), (total - done) / fps, " s left"),
             done == total);
}

// Frames are rendered and written side by side, the surface is collected in their order.
SurfaceSampler WriteFrames(const Options& options, const Scene& scene, const PinholeCamera& camera,
                           const InverseDepthField& error, const Trajectory& path,
                           const SequenceWriter& writer) {
  constexpr int kBatch = 10;
  SurfaceSampler surface(options.surface_grid_m);
  ProgressLine line;
  const int frames = static_cast<int>(path.size());
  for (int begin = 0; begin < frames; begin += kBatch) {
    const int end = std::min(frames, begin + kBatch);
    std::vector<SimulatedFrame> batch(end - begin);
    ParallelFor(begin, end, 1, [&](int i, int) {
      SimulatedFrame frame = Simulate(options, scene, camera, error, path[i].world_from_camera, i);
      writer.WriteFrame(i, path[i].stamp_s, frame.exact.color, frame.depth_m);
      if (i % kSurfaceStride == 0 || i + 1 == frames) batch[i - begin] = std::move(frame);
    });
    for (int i = begin; i < end; ++i) {
      const SimulatedFrame& frame = batch[i - begin];
      if (frame.depth_m.empty()) continue;
      surface.Add(frame.exact, frame.depth_m, camera, path[i].world_from_camera);
    }
    ShowProgress(end, static_cast<int>(path.size()), &line);
  }
  return surface;
}

int Run(const Options& options) {
  const InverseDepthField error = DepthError(options);
  const ThreadLimit limit(options.threads == 0
                              ? static_cast<int>(std::max(1u, std::thread::hardware_concurrency()))
                              : options.threads);
  const Scene scene = MakeScene(options.scene, options.seed);
  const RgbdCamera camera = SimulatedCamera(options.downsample);
  PathOptions path_options;
  path_options.frames_per_second = camera.frames_per_second;
  const Trajectory path = MakePath(scene, options.frames, options.seed, path_options);
  const SequenceWriter writer(
      options.output, options.image_y_up ? SequenceLayout::kIclNuim : SequenceLayout::kTum, camera);
  writer.WriteLists(path);
  const SurfaceSampler surface = WriteFrames(options, scene, camera.depth, error, path, writer);
  WritePly(surface.cloud(), options.output + "/surface.ply");
  std::cout << path.size() << " frames and " << surface.cloud().points.size()
            << " points of the exact surface in " << options.output << std::endl;
  return kDone;
}

}  // namespace
}  // namespace surfit::tools

int main(int argc, char** argv) {
  return surfit::tools::ToolMain(argc, argv,
                                 "simulates an RGB-D sequence (TUM layout) with exact ground truth",
                                 surfit::tools::Run);
}
