#pragma once

#include <cstdint>
#include <map>
#include <utility>

#include "surfit/frame/frame_pyramid.h"
#include "surfit/frame/preprocess.h"
#include "surfit/registration/global_registration.h"
#include "surfit/simulation/camera_path.h"
#include "surfit/simulation/render.h"
#include "surfit/simulation/scene.h"

namespace surfit::testing {

// Two views of a furnished room without noise, at a distance of `gap` frames of a hand-held path.
struct SimulatedViews {
  FramePyramid source, target;
  Rigid3d target_from_source;
};

// Room of a seed and the first poses of a path through it. Rooms are created once and shared by all
// tests.
struct RoomWithPath {
  Scene scene;
  Trajectory path;
};

inline const RoomWithPath& MakeRoomWithPath(int frames, std::uint64_t seed) {
  static std::map<std::pair<int, std::uint64_t>, RoomWithPath> rooms;
  RoomWithPath& room = rooms[{frames, seed}];
  if (room.path.empty()) {
    room.scene = MakeScene("room", seed);
    room.path = MakePath(room.scene, frames, seed);
  }
  return room;
}

inline PinholeCamera ViewCamera() { return {160, 120, 131, 131, 79.5, 59.5, {}}; }

inline SimulatedViews MakeViews(int first, int gap, std::uint64_t seed = 1) {
  const PinholeCamera camera = ViewCamera();
  const auto& [scene, path] = MakeRoomWithPath(first + gap + 1, seed);
  const Rigid3d& source = path[first].world_from_camera;
  const Rigid3d& target = path[first + gap].world_from_camera;
  const auto view = [&](const Rigid3d& pose) {
    return PreprocessDepth(RenderFrame(scene, camera, pose).depth_m, {camera, {}},
                           PreprocessOptions());
  };
  return {view(source), view(target), target.Inverse() * source};
}

struct SimulatedColoredViews {
  ColoredView source, target;
  Rigid3d target_from_source;
};

inline ColoredView MakeColoredView(const Scene& scene, const Rigid3d& world_from_camera) {
  RgbdFrame frame = RenderFrame(scene, ViewCamera(), world_from_camera);
  return {PreprocessDepth(frame.depth_m, {ViewCamera(), {}}, PreprocessOptions()),
          std::move(frame.color)};
}

// The source is a frame of the path, and the target is another view.
inline SimulatedColoredViews MakeTurnedViews(int first, const Rigid3d& target_from_source,
                                             std::uint64_t seed) {
  const auto& [scene, path] = MakeRoomWithPath(first + 1, seed);
  const Rigid3d& source = path[first].world_from_camera;
  return {MakeColoredView(scene, source),
          MakeColoredView(scene, source * target_from_source.Inverse()), target_from_source};
}

inline SimulatedColoredViews MakeColoredViews(int first, int gap, std::uint64_t seed) {
  const Trajectory& path = MakeRoomWithPath(first + gap + 1, seed).path;
  const Rigid3d target_from_source =
      path[first + gap].world_from_camera.Inverse() * path[first].world_from_camera;
  return MakeTurnedViews(first, target_from_source, seed);
}

// Two views of a textured wall at 1.5 m that fills the image. Its geometry does not constrain
// translation along the wall and rotation about its normal.
struct WallScene {
  ColoredView source, target;
  Rigid3d target_from_source;

  explicit WallScene(const Rigid3d& pose) : target_from_source(pose) {
    const Scene scene = MakeScene("wall");
    Eigen::Matrix3d along_y;
    along_y << 1, 0, 0, 0, 0, 1, 0, -1, 0;
    const Rigid3d world_from_source(along_y, Eigen::Vector3d(0, 0.5, 1));
    source = MakeColoredView(scene, world_from_source);
    target = MakeColoredView(scene, world_from_source * pose.Inverse());
  }
};

// The views of WallScene as pyramids with intensities.
struct WallFrames {
  FramePyramid source, target;
  Rigid3d target_from_source;

  explicit WallFrames(const Rigid3d& pose) : target_from_source(pose) {
    WallScene views(pose);
    AddIntensity(views.source.color, &views.source.pyramid);
    AddIntensity(views.target.color, &views.target.pyramid);
    source = std::move(views.source.pyramid);
    target = std::move(views.target.pyramid);
  }

  // Simulates another exposure of the source.
  void ChangeExposure(float gain, float offset) {
    for (FrameLevel& level : source.levels) {
      for (float& value : level.intensity) value = gain * value + offset;
    }
  }
};

// Small motion along the wall: at most two pixels.
inline Rigid3d AlongTheWall() { return {QuaternionExp<double>({0, 0, 0.02}), {0.015, -0.01, 0}}; }

// A tenth of a pixel: a pixel is 11 mm at 1.5 m.
constexpr double kWallToleranceM = 0.0011, kWallToleranceRad = 0.0008;

}  // namespace surfit::testing
