#pragma once

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "surfit/run/slam_run.h"
#include "surfit/simulation/camera_path.h"
#include "surfit/simulation/render.h"
#include "testing/pixels.h"
#include "testing/sequence_writer.h"

namespace surfit::testing {

inline constexpr int kFrames = 40;  // of the recordings

// Frame of a simulated phone. Depth has half of the width and height of colour.
struct SimulatedFrame {
  double stamp_s = 0;
  PinholeCamera color_camera, depth_camera;  // with the focal length of this frame
  Rigid3d world_from_camera;                 // camera axes x right, y down, z forward
  Image<float> true_depth_m;
  Image<float> depth_m;            // wrong where confidence is low
  Image<std::uint8_t> confidence;  // 0, 1 and 2
  Image<Rgb8> color;
};

// Depth camera of a lens whose colour image has twice the size. The centre of the top-left pixel is
// (0, 0).
inline PinholeCamera HalfOf(PinholeCamera camera) {
  camera.width /= 2;
  camera.height /= 2;
  camera.fx /= 2;
  camera.fy /= 2;
  camera.cx = (camera.cx - 0.5) / 2;
  camera.cy = (camera.cy - 0.5) / 2;
  return camera;
}

inline PinholeCamera MeanColorCamera() { return {320, 240, 250, 250, 158.5, 121.5, {}}; }

// A walk through a room, recorded by a phone with autofocus: the focal length changes by 1 %. Depth
// is exact, except in two regions of low confidence: there, it is 15 % too large.
inline std::vector<SimulatedFrame> RecordWithPhone(int count, bool changes_focus = true) {
  constexpr double kStart_s = 8123.4, kPi = 3.141592653589793;
  const Scene scene = MakeScene("room", 3);
  const Trajectory path = MakePath(scene, count, 3);
  // The world of a phone: y is up.
  const Rigid3d phone_from_world(
      Eigen::Quaterniond(0, 1, 0, 0) *
          Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitY())),
      {0.3, -1.1, 0.4});
  std::vector<SimulatedFrame> frames;
  for (int i = 0; i < count; ++i) {
    SimulatedFrame frame;
    frame.stamp_s = kStart_s + i / 30.;
    frame.color_camera = MeanColorCamera();
    if (changes_focus) {
      const double wave = std::sin(2 * kPi * i / 15);
      frame.color_camera.fx *= 1 + 0.01 * wave;
      frame.color_camera.fy *= 1 + 0.01 * wave;
      frame.color_camera.cx += 0.8 * wave;
    }
    frame.depth_camera = HalfOf(frame.color_camera);
    const Rigid3d& pose = path[i].world_from_camera;
    frame.world_from_camera = phone_from_world * pose;
    frame.true_depth_m = RenderFrame(scene, frame.depth_camera, pose).depth_m;
    frame.color = RenderFrame(scene, frame.color_camera, pose).color;
    frame.depth_m = frame.true_depth_m;
    frame.confidence = Image<std::uint8_t>(frame.depth_camera.width, frame.depth_camera.height, 2);
    for (const auto [u, v] : PixelsOf(frame.confidence)) {
      const bool is_low = (u / 40 + i / 5) % 4 == 0 && v % 80 < 60;
      if (is_low) frame.depth_m(u, v) *= 1.15f;
      frame.confidence(u, v) = is_low ? 0 : (v % 2 == 0 ? 1 : 2);
    }
    frames.push_back(std::move(frame));
  }
  return frames;
}

// Depth in counts of mm.
inline Image<std::uint16_t> Millimetres(const Image<float>& depth_m) {
  Image<std::uint16_t> counts(depth_m.width(), depth_m.height());
  for (std::size_t i = 0; i < counts.size(); ++i)
    counts[i] = static_cast<std::uint16_t>(std::lround(1000 * depth_m[i]));
  return counts;
}

inline std::string Number(double value) {
  std::ostringstream text;
  text.precision(12);
  text << value;
  return text.str();
}

// Camera-to-world rotation and translation with the camera axes of OpenGL.
inline Rigid3d OpenGlPose(const SimulatedFrame& frame) {
  return frame.world_from_camera * Rigid3d(Eigen::Quaterniond(0, 1, 0, 0), {0, 0, 0});
}

// Tracks all frames. The ground truth are the poses by the phone.
inline SlamRunSummary TrackPhone(const SequenceOptions& sequence,
                                 const std::string& groundtruth = "device") {
  const TempFolder output;
  SlamRunOptions options;
  options.sequence = sequence;
  options.groundtruth = groundtruth;
  options.output = output.path();
  options.pictures = options.final_map = options.refine = false;
  options.threads = 1;
  return RunSlam(options, false, [](const SlamRunProgress&) {});
}

// Error of the poses in m. All frames must be tracked.
inline double ErrorOf(const SlamRunSummary& summary, int frames) {
  EXPECT_EQ(summary.frames_tracked, frames);
  if (!summary.evaluation || !summary.evaluation->ate) {
    ADD_FAILURE() << "no poses for comparison";
    return HUGE_VAL;
  }
  EXPECT_EQ(summary.evaluation->coverage, 1);
  return summary.evaluation->ate->translation_m.rmse;
}

// Recording of a simulated phone in a temporary folder. Tests write its files.
class PhoneTest : public ::testing::Test {
 protected:
  static const std::vector<SimulatedFrame>& Frames() {
    static const auto* const frames = new auto(RecordWithPhone(kFrames));
    return *frames;
  }
  std::unique_ptr<FrameSource> Open() const { return OpenSequence(Options(folder_)); }
  // Tracks a recording. Returns the error of the poses, m.
  static double TrackingError(const SequenceOptions& sequence) {
    const double error_m = ErrorOf(TrackPhone(sequence), kFrames);
    std::printf("ATE %.5f m\n", error_m);
    return error_m;
  }

  TempFolder folder_;
};

}  // namespace surfit::testing
