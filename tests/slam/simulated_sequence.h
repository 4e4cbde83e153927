#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "surfit/simulation/camera_path.h"
#include "surfit/simulation/render.h"
#include "surfit/simulation/scene.h"
#include "surfit/slam/slam.h"

namespace surfit::testing {

inline PinholeCamera SimulatedCamera() { return {160, 120, 131.25, 131.25, 79.5, 59.5, {}}; }

struct SimulatedSequence {
  PinholeCamera camera = SimulatedCamera();
  std::vector<RgbdFrame> frames;
  std::vector<Rigid3d> world_from_camera;
};

enum class Sensor { kIdeal, kKinect };

// Renders every `stride`-th frame with the true camera. Timestamps are late by the latency of the
// camera.
inline SimulatedSequence Simulate(const std::string& name, std::uint64_t seed, int frames,
                                  Sensor sensor, const RgbdCamera& camera,
                                  const ColorOptions& color = {}, int stride = 1) {
  const Scene scene = MakeScene(name, seed);
  const Trajectory path = MakePath(scene, frames, seed);
  const MovingCamera moving(scene, camera, path, color);
  SimulatedSequence sequence;
  sequence.camera = camera.depth;
  for (int i = 0; i < frames; i += stride) {
    Rendering image = moving.Frame(i);
    RgbdFrame frame;
    frame.index = i;
    frame.stamp_s = frame.color_stamp_s = path[i].stamp_s + camera.latency_s;
    frame.depth_m = sensor == Sensor::kIdeal ? std::move(image.depth_m)
                                             : KinectDepth(image.depth_m, camera.depth, seed + i);
    frame.color = std::move(image.color);
    sequence.frames.push_back(std::move(frame));
    sequence.world_from_camera.push_back(path[i].world_from_camera);
  }
  return sequence;
}

inline SimulatedSequence Simulate(const std::string& name, std::uint64_t seed, int frames,
                                  Sensor sensor, const PinholeCamera& camera = SimulatedCamera(),
                                  int stride = 1) {
  RgbdCamera plain;
  plain.depth = camera;
  return Simulate(name, seed, frames, sensor, plain, {}, stride);
}

inline SimulatedSequence SimulateRoom(std::uint64_t seed, int frames, Sensor sensor) {
  return Simulate("room", seed, frames, sensor);
}

// Result of Slam over all frames, from the pose of the first camera.
struct SlamRun {
  std::vector<FrameReport> reports;
  SurfelMap map;
};

inline SlamRun RunSlam(const SimulatedSequence& sequence, const SlamOptions& options,
                       const Rigid3d& world_from_first_camera) {
  Slam slam({sequence.camera, {}}, options, world_from_first_camera);
  SlamRun run;
  for (const RgbdFrame& frame : sequence.frames) run.reports.push_back(slam.Process(frame));
  run.map = slam.map();
  return run;
}

struct PoseErrors {
  double rms_m = 0;
  double max_m = 0;
  double max_rad = 0;
};

// Errors of camera positions and orientations, without alignment: both trajectories start at the
// same pose.
inline PoseErrors ErrorsOf(const SlamRun& run, const std::vector<Rigid3d>& truth) {
  PoseErrors errors;
  double square_sum = 0;
  for (std::size_t i = 0; i < run.reports.size(); ++i) {
    const Rigid3d error = truth[i].Inverse() * run.reports[i].world_from_camera;
    square_sum += error.translation.squaredNorm();
    errors.max_m = std::max(errors.max_m, error.translation.norm());
    errors.max_rad = std::max(errors.max_rad, RotationAngle(error.rotation));
  }
  errors.rms_m = std::sqrt(square_sum / static_cast<double>(run.reports.size()));
  return errors;
}

// Expects bitwise identical poses of two lists of frames.
template <typename Frame>
void ExpectSamePoses(const std::vector<Frame>& a, const std::vector<Frame>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].world_from_camera.Matrix(), b[i].world_from_camera.Matrix()) << i;
  }
}

inline const SimulatedSequence& IdealRoom() {
  constexpr int kFrames = 25;
  static const auto* const room = new SimulatedSequence(SimulateRoom(1, kFrames, Sensor::kIdeal));
  return *room;
}

inline RgbdFrame Blank(int index) {
  RgbdFrame frame = IdealRoom().frames[index];
  frame.depth_m = Image<float>(frame.depth_m.width(), frame.depth_m.height(), 0.f);
  return frame;
}

// At 160 x 120, a pixel is 1 / 131 rad, 15 mm at the typical depth of 2 m.
inline constexpr double kPixelRad = 1 / 131.25;
inline constexpr double kPixelAt2m = 2 * kPixelRad;

}  // namespace surfit::testing
