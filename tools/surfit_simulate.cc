// Ray-traces an RGB-D sequence with exact ground truth.

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <iomanip>
#include <iostream>
#include <utility>
#include <vector>

#include "common/console.h"
#include "common/tool_main.h"
#include "simulate/sequence_writer.h"
#include "simulate/simulate_options.h"
#include "simulate/simulated_sensor.h"
#include "simulate/surface_sampler.h"
#include "surfit/core/error.h"
#include "surfit/core/parallel.h"
#include "surfit/frame/rectify_frame.h"
#include "surfit/simulation/camera_path.h"
#include "surfit/simulation/render.h"
#include "surfit/simulation/scene.h"

namespace surfit::tools {
namespace {

// The surface is sampled in every fifth frame. Between these frames the camera moves by 5 to 10 cm.
constexpr int kSurfaceStride = 5;

struct SimulatedFrame {
  Rendering exact;
  SensorImage measured;
};

// Options, camera and renderer of the frames.
struct FrameSimulator {
  const SimulateOptions& options;
  PinholeCamera camera;
  InverseDepthField error;
  SimulatedSensor sensor;
  MovingCamera moving;

  SimulatedFrame Simulate(int index) const {
    SimulatedFrame frame;
    frame.exact = moving.Frame(index);
    const auto seed = (static_cast<std::uint64_t>(options.seed) << 32) + index;
    frame.measured = sensor.Measure(frame.exact, camera, seed);
    if (!error.IsZero()) CorrectDepth(camera, error, &frame.measured.depth_m);
    return frame;
  }

  // Noise of the sensor in evenly spaced frames. Every part of a simulation has the same frames.
  // 0 without known noise.
  double InverseDepthSigma() const {
    constexpr int kMaxFrames = 8;
    MeanNoise noise;
    const int count = sensor.HasKnownNoise() ? std::min(kMaxFrames, options.frames) : 0;
    for (int k = 0; k < count; ++k) {
      const auto frame = (2 * k + 1) * static_cast<std::int64_t>(options.frames) / (2 * count);
      noise.Add(Simulate(static_cast<int>(frame)).measured);
    }
    return noise.Sigma();
  }
};

void ShowProgress(int done, int total, ProgressLine* line) {
  const double fps = done / line->elapsed_s();
  line->Show(Concat("frame ", done, " of ", total, ", ", std::fixed, std::setprecision(1), fps,
                    " fps, ", std::setprecision(0), (total - done) / fps, " s left"),
             done == total);
}

// Range of the frames of a part, starting at part 1; 0: all frames.
std::pair<int, int> FramesOfPart(int part, const SimulateOptions& options) {
  if (part == 0) return {0, options.frames};
  const auto begin = [&](std::int64_t p) {
    return static_cast<int>(p * options.frames / options.parts);
  };
  return {begin(part - 1), begin(part)};
}

std::string FolderOfPart(int part, const SimulateOptions& options) {
  return part == 0 ? options.output : Concat(options.output, ".", part);
}

// Frames are rendered and written in parallel. The surface is collected in frame order.
SurfaceSampler WriteFrames(const FrameSimulator& studio, const Trajectory& path,
                           const SequenceWriter& writer) {
  constexpr int kBatch = 10;
  SurfaceSampler surface(studio.options.surface_grid_m);
  ProgressLine line;
  const int frames = static_cast<int>(path.size());
  const auto [first, past] = FramesOfPart(studio.options.part, studio.options);
  for (int begin = first; begin < past; begin += kBatch) {
    const int end = std::min(past, begin + kBatch);
    std::vector<SimulatedFrame> batch(end - begin);
    ParallelFor(begin, end, 1, [&](int i, int) {
      SimulatedFrame frame = studio.Simulate(i);
      writer.WriteFrame(i, path[i].stamp_s, frame.exact.color, frame.measured.depth_m,
                        frame.measured.confidence);
      if (i % kSurfaceStride == 0 || i + 1 == frames) batch[i - begin] = std::move(frame);
    });
    for (int i = begin; i < end; ++i) {
      const SimulatedFrame& frame = batch[i - begin];
      if (frame.measured.depth_m.empty()) continue;
      surface.Add(frame.exact, frame.measured.depth_m, studio.camera,
                  [&](int v) { return studio.moving.DepthPose(i, v); });
    }
    ShowProgress(end - first, past - first, &line);
  }
  return surface;
}

std::string SurfaceFile(const std::string& folder) { return folder + "/surface.ply"; }

// Parts are joined in their order, so that surface and files are the same as without parts.
SurfaceSampler JoinParts(const SimulateOptions& options, const SequenceWriter& writer) {
  SurfaceSampler surface(options.surface_grid_m);
  for (int part = 1; part <= options.parts; ++part) {
    const std::string folder = FolderOfPart(part, options);
    surface.Add(ReadPly(SurfaceFile(folder)));
    const auto [first, past] = FramesOfPart(part, options);
    const int images = writer.LinkImages(folder), needed = writer.ImagesPerFrame() * (past - first);
    if (images != needed) {
      throw InputError(Concat(folder, " has ", images, " images, must have ", needed,
                              ": render it again with --part=", part, "/", options.parts));
    }
  }
  return surface;
}

// Deletes the joined parts. A part without surface is invalid, so the surface is deleted first.
void RemoveParts(const SimulateOptions& options) {
  for (int part = 1; part <= options.parts; ++part) {
    std::filesystem::remove(SurfaceFile(FolderOfPart(part, options)));
    std::filesystem::remove_all(FolderOfPart(part, options));
  }
}

SequenceTruth TruthOf(const FrameSimulator& studio, const RgbdCamera& camera,
                      const Trajectory& path) {
  SequenceTruth truth;
  truth.camera = camera;
  truth.field = studio.error;
  for (double& coefficient : truth.field.coefficients) coefficient = -coefficient;
  truth.color_readout_s = studio.options.settings.color.color_readout_s;
  truth.exposure_s = studio.options.settings.color.exposure_s;
  for (int i = 0; i < static_cast<int>(path.size()); ++i) {
    truth.color_moments_s.push_back(studio.moving.ColorCaptureTime(i));
    truth.gains.push_back(studio.moving.gains(i));
  }
  return truth;
}

void WriteImuFiles(const SmoothPath& path, ImuSimulation simulation, const SequenceWriter& writer) {
  writer.WriteImu("imu.csv", SimulateImu(path, simulation));
  simulation.has_errors = false;
  writer.WriteImu("imu_exact.csv", SimulateImu(path, simulation));
}

int Run(const SimulateOptions& options) {
  const SensorSettings& settings = options.settings;
  const InverseDepthField error = DepthErrorOf(settings);
  const bool is_numbered = options.format == "icl_nuim";
  if (is_numbered && settings.latency_s != 0) {
    throw InputError(
        "latency_s of --sensor_settings is set, must be 0 with --format=icl_nuim, which replaces "
        "timestamps by frame numbers");
  }
  if (is_numbered && options.imu) {
    throw InputError(
        "--imu is true, must be false with --format=icl_nuim, which replaces timestamps by frame "
        "numbers");
  }
  const ThreadLimit limit(options.threads);
  const Scene scene = MakeScene(options.scene, options.seed, options.building);
  RgbdCamera camera = TrueCameraOf(options), given = CameraYamlOf(settings, camera);
  PathOptions path_options = options.path;
  path_options.frames_per_second = camera.frames_per_second;
  const Trajectory path = MakePath(scene, options.frames, options.seed, path_options);
  const SimulatedSensor sensor(options.sensor);
  const FrameSimulator studio = {
      options, camera.depth, error, sensor, {scene, camera, path, settings.color}};
  if (const double sigma = studio.InverseDepthSigma(); sigma > 0) {
    camera.noise.inverse_depth_sigma = given.noise.inverse_depth_sigma = sigma;
  }
  const ImuSimulation imu = ImuOf(options);
  const std::string output = FolderOfPart(options.part, options);
  const SequenceWriter writer(output, is_numbered ? SequenceLayout::kIclNuim : SequenceLayout::kTum,
                              given, settings.latency_s, sensor.HasConfidence(),
                              options.imu && settings.camera_yaml_imu ? &imu.calibration : nullptr);
  writer.WriteLists(path);
  if (options.imu) WriteImuFiles(SmoothPath(path), imu, writer);
  if (HasUnlistedTruth(settings)) writer.WriteTruth(path, TruthOf(studio, camera, path));
  const SurfaceSampler surface =
      options.join ? JoinParts(options, writer) : WriteFrames(studio, path, writer);
  WritePly(surface.cloud(), SurfaceFile(output));
  if (options.join) RemoveParts(options);
  const auto [first, past] = FramesOfPart(options.part, options);
  std::cout << past - first << " frames and " << surface.cloud().points.size()
            << " points of the exact surface in " << output << std::endl;
  return kDone;
}

}  // namespace
}  // namespace surfit::tools

int main(int argc, char** argv) {
  return surfit::tools::ToolMain(argc, argv,
                                 "simulates an RGB-D sequence (TUM layout) with exact ground "
                                 "truth. The folder --output must be empty, new or of an earlier "
                                 "simulation. Each seed has its own room, path and noise.",
                                 surfit::tools::Run);
}
