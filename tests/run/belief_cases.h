#pragma once

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "surfit/geometry/trajectory.h"
#include "surfit/io/sequence.h"
#include "surfit/simulation/camera_path.h"
#include "surfit/simulation/render.h"
#include "surfit/slam/slam.h"
#include "testing/shared_data.h"

namespace surfit::testing {

// Frames in memory, with ground-truth poses where available.
struct Recording {
  DepthSensor sensor;
  std::vector<RgbdFrame> frames;
  std::vector<std::optional<Rigid3d>> truth;
  // Final drift of a run over all frames against the ground truth, with equal first poses. The
  // ground truth of the kitchen is a map of another system from the same depth.
  double drift_m = 0, drift_rad = 0;

  void Add(const Recording& other, std::size_t i) {
    frames.push_back(other.frames[i]);
    truth.push_back(other.truth[i]);
  }
};

inline Recording Recorded(const std::string& name, int downsample = 2, int stride = 1) {
  constexpr double kTurn_rad = 3 * kRadPerDeg;
  SequenceOptions options;
  options.path = SharedData(name);
  options.stride = stride;
  options.rectify.downsample = downsample;
  const auto source = OpenSequence(options);
  Recording recording;
  recording.sensor = source->info().sensor();
  if (name == "tum_fr1_desk") recording.drift_m = 0.06, recording.drift_rad = kTurn_rad;
  if (name == "seven_scenes_kitchen") recording.drift_m = 0.13, recording.drift_rad = kTurn_rad;
  while (std::optional<ReadResult> read = source->Next()) {
    if (!read->frame) continue;
    recording.truth.push_back(InterpolatePose(source->info().ground_truth, read->stamp_s));
    recording.frames.push_back(*std::move(read->frame));
  }
  return recording;
}

inline Recording Every(const Recording& all, int stride) {
  Recording kept;
  kept.sensor = all.sensor, kept.drift_m = all.drift_m, kept.drift_rad = all.drift_rad;
  for (std::size_t i = 0; i < all.frames.size(); i += stride) kept.Add(all, i);
  return kept;
}

// Concatenates parts of a recording at 30 Hz. The camera jumps between two parts.
inline Recording Joined(const Recording& all, const std::vector<std::pair<int, int>>& parts) {
  Recording joined;
  joined.sensor = all.sensor, joined.drift_m = all.drift_m, joined.drift_rad = all.drift_rad;
  for (const auto& [begin, end] : parts) {
    for (int i = begin; i < end && i < static_cast<int>(all.frames.size()); ++i) {
      joined.Add(all, i);
      RgbdFrame& frame = joined.frames.back();
      frame.index = static_cast<int>(joined.frames.size()) - 1;
      frame.stamp_s = frame.color_stamp_s = frame.index / 30.;
    }
  }
  return joined;
}

// Adds a textured object in front of the camera that occludes `share` of the view, starting at
// frame `begin`. It moves with the camera, and sideways by +-0.15 m.
inline Recording Hidden(Recording recording, double share, int begin) {
  const PinholeCamera& camera = recording.sensor.camera;
  constexpr double kDistance_m = 0.55;
  const double half_x_m = std::sqrt(share) / 2 * camera.width / camera.fx * kDistance_m;
  const double half_y_m = std::sqrt(share) / 2 * camera.height / camera.fy * kDistance_m;
  for (int i = begin; i < static_cast<int>(recording.frames.size()); ++i) {
    RgbdFrame& frame = recording.frames[i];
    const double phase = 2 * M_PI * i / 60, shift_m = 0.15 * std::sin(phase);
    const double distance_m = kDistance_m + 0.05 * std::sin(1.3 * phase);
    for (int v = 0; v < camera.height; ++v) {
      for (int u = 0; u < camera.width; ++u) {
        const Eigen::Vector3d ray = camera.Ray(u, v);
        const double x = ray.x() * distance_m - shift_m, y = ray.y() * distance_m;
        if (std::abs(x) > half_x_m || std::abs(y) > half_y_m) continue;
        const double bump = std::sin(25 * x) * std::cos(20 * y);
        frame.depth_m(u, v) = static_cast<float>(distance_m + 0.04 * bump);
        const auto grey = static_cast<std::uint8_t>(130 + 60 * bump + 40 * std::sin(110 * x));
        frame.color(u, v) = {grey, static_cast<std::uint8_t>(255 - grey), 90};
      }
    }
  }
  return recording;
}

inline Texture Stripes(double period_m) {
  return [period_m](const Eigen::Vector3d& point) {
    const bool is_light = std::sin(2 * M_PI * point.z() / period_m) > 0;
    return is_light ? Eigen::Vector3f(0.7f, 0.2f, 0.15f) : Eigen::Vector3f(0.15f, 0.2f, 0.5f);
  };
}

// Adds a person of 1.75 m height at this floor position.
inline void AddPerson(const Eigen::Vector2d& at, double stride_m, Scene* scene) {
  const auto add = [&](const ShapePtr& shape, double x, double z, double period_m) {
    const Eigen::Vector3d place(at.x() + x, at.y(), z);
    scene->Add(shape, Rigid3d(Eigen::Quaterniond::Identity(), place), Stripes(period_m));
  };
  add(MakeSphere(0.12), 0, 1.63, 0.09);
  add(MakeCapsule(0.2, 0.5), 0, 0.95, 0.13);
  add(MakeCapsule(0.09, 0.7), stride_m, 0.1, 0.2);
  add(MakeCapsule(0.09, 0.7), -stride_m, 0.1, 0.2);
}

inline RgbdFrame KinectFrame(const Scene& scene, const PinholeCamera& camera,
                             const StampedPose& pose, std::uint64_t seed, int index) {
  RgbdFrame frame = RenderFrame(scene, camera, pose.world_from_camera, index, pose.stamp_s);
  frame.depth_m = KinectDepth(frame.depth_m, camera, (seed << 32) + index);
  return frame;
}

inline Recording SimulatedKinect() {
  Recording recording;
  recording.sensor.camera = {320, 240, 262.5, 262.5, 159.5, 119.5, {}};
  return recording;
}

// A Kinect in a furnished room. A person walks in front of it, starting at frame `people_from`.
// Renders every `stride`-th frame.
inline Recording Simulated(std::uint64_t seed, int frames, int people_from, int stride = 1) {
  Recording recording = SimulatedKinect();
  const Scene room = MakeScene("room", seed);
  const Trajectory path = MakePath(room, frames, seed);
  for (int i = 0; i < frames; i += stride) {
    const StampedPose& pose = path[i];
    Scene scene = room;
    const Rigid3d& world_from_camera = pose.world_from_camera;
    if (i >= people_from) {
      const double phase = 2 * M_PI * i / 90;
      const Eigen::Vector3d at = world_from_camera * Eigen::Vector3d(0.7 * std::sin(phase), 0,
                                                                     1.3 + 0.3 * std::cos(phase));
      AddPerson(at.head<2>(), 0.2 * std::sin(4 * phase), &scene);
    }
    recording.frames.push_back(KinectFrame(scene, recording.sensor.camera, pose, seed, i));
    recording.truth.emplace_back(world_from_camera);
  }
  return recording;
}

// A Kinect moves from one room into a similar room and back. Every pose in the second room is wrong
// with respect to the map of the first room.
inline Recording InTwoRooms(std::uint64_t seed, std::uint64_t other_seed) {
  constexpr int kHere = 40, kThere = 30, kBack = 20;
  Recording recording = SimulatedKinect();
  const auto add = [&](std::uint64_t room_seed, int begin, int end, double beside_m) {
    const Scene room = MakeScene("room", room_seed);
    const Trajectory path = MakePath(room, kHere, room_seed);
    for (int i = begin; i < end; ++i) {
      const int index = static_cast<int>(recording.frames.size());
      const Rigid3d& truth = path[i].world_from_camera;
      recording.frames.push_back(
          KinectFrame(room, recording.sensor.camera, {index / 30., truth}, seed, index));
      recording.truth.emplace_back(
          Rigid3d(truth.rotation, truth.translation + Eigen::Vector3d(beside_m, 0, 0)));
    }
  };
  add(seed, 0, kHere, 0);
  add(other_seed, 0, kThere, 100);
  add(seed, kHere - kBack, kHere, 0);
  return recording;
}

// Statistics of frames with ground truth. A pose is correct within 10 cm and 5 degrees, plus the
// drift of the recording.
struct Verdicts {
  int frames = 0;
  int believed = 0;  // accepted frames: every state except lost
  int wrong = 0;     // accepted frames with a wrong pose
  int apart = 0;     // frames with two motions, see frames_apart
  int missed = 0;    // lost frames whose rejected pose is correct
  double max_m = 0;  // largest error of accepted frames

  double CalledRight() const {
    const int right = believed - wrong + missed;
    return right > 0 ? static_cast<double>(believed - wrong) / right : 1;
  }
  Verdicts& operator+=(const Verdicts& other) {
    frames += other.frames, believed += other.believed, wrong += other.wrong;
    apart += other.apart;
    missed += other.missed, max_m = std::max(max_m, other.max_m);
    return *this;
  }
};

// Pose of a frame when it is known, and the pose that is expected from the ground truth.
struct JudgedPose {
  bool is_believed = false;
  Rigid3d world_from_camera, expected;
};

// Expected poses. Each piece of the trajectory has a world frame of its own, so its first frame
// with ground truth is the reference.
class ExpectedPoses {
 public:
  ExpectedPoses(const Recording& recording, const PoseStore& poses)
      : recording_(recording), poses_(poses), piece_of_keyframe_(poses.PieceOfKeyframe()) {}

  // Returns the expected pose of a frame in the piece of a keyframe; std::nullopt without ground
  // truth.
  std::optional<Rigid3d> At(int frame_index, int keyframe) const {
    if (!recording_.truth[frame_index]) return std::nullopt;
    const Rigid3d& truth = *recording_.truth[frame_index];
    for (const PosedFrame& first : poses_.frames()) {
      const std::size_t i = PositionOf(first);
      if (piece_of_keyframe_[first.keyframe] != piece_of_keyframe_[keyframe]) continue;
      if (!recording_.truth[i]) continue;
      return first.world_from_camera * recording_.truth[i]->Inverse() * truth;
    }
    return truth;
  }

  // Returns the position in the recording.
  std::size_t PositionOf(const PosedFrame& frame) const {
    std::size_t i = 0;
    while (recording_.frames[i].index != frame.index) ++i;
    return i;
  }

 private:
  const Recording& recording_;
  const PoseStore& poses_;
  std::vector<int> piece_of_keyframe_;
};

// Evaluates online poses: at the time of the frame, or after confirmation by the next frame. Slam
// starts at the true pose.
inline Verdicts Judge(const Recording& recording, const SlamOptions& options = {}) {
  constexpr double kRight_m = 0.1, kRight_rad = 5 * kRadPerDeg;
  Slam slam(recording.sensor, options, recording.truth.at(0).value());
  Verdicts verdicts;
  std::vector<std::optional<JudgedPose>> judged(recording.frames.size());
  std::size_t posed = 0;  // judged frames of the back end
  for (std::size_t i = 0; i < recording.frames.size(); ++i) {
    const FrameReport report = slam.Process(recording.frames[i]);
    verdicts.apart += report.has_two_motions;
    const std::vector<PosedFrame>& frames = slam.backend()->poses().frames();
    const ExpectedPoses expected(recording, slam.backend()->poses());
    for (; posed < frames.size(); ++posed) {
      const std::size_t at = expected.PositionOf(frames[posed]);
      const auto pose = expected.At(static_cast<int>(at), frames[posed].keyframe);
      if (pose) judged[at] = {true, frames[posed].world_from_camera, *pose};
    }
    if (report.HasPose() || frames.empty()) continue;
    const auto pose = expected.At(static_cast<int>(i), frames.back().keyframe);
    if (pose) judged[i] = {false, report.world_from_camera, *pose};
  }
  for (std::size_t i = 0; i < judged.size(); ++i) {
    if (!recording.truth[i]) continue;
    ++verdicts.frames;
    if (!judged[i]) continue;
    const Rigid3d error = judged[i]->expected.Inverse() * judged[i]->world_from_camera;
    const bool is_believed = judged[i]->is_believed;
    const bool is_right = error.translation.norm() <= kRight_m + recording.drift_m &&
                          RotationAngle(error.rotation) <= kRight_rad + recording.drift_rad;
    verdicts.believed += is_believed;
    verdicts.wrong += is_believed && !is_right;
    verdicts.missed += !is_believed && is_right;
    if (is_believed) verdicts.max_m = std::max(verdicts.max_m, error.translation.norm());
    if (is_believed && !is_right) {
      std::printf("wrong: frame %zu, %.0f mm, %.1f degrees\n", i, 1e3 * error.translation.norm(),
                  RotationAngle(error.rotation) / kRadPerDeg);
    }
  }
  return verdicts;
}

// Prints a row of the table in docs/understand.md.
inline void Print(const std::string& name, const Verdicts& verdicts) {
  std::printf("| %s | %d | %d | %d | %d | %.1f | %.0f | %d |\n", name.c_str(), verdicts.frames,
              verdicts.believed, verdicts.wrong, verdicts.missed, 100 * verdicts.CalledRight(),
              1e3 * verdicts.max_m, verdicts.apart);
  std::fflush(stdout);
}

}  // namespace surfit::testing
