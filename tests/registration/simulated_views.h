#pragma once

#include <cstdint>
#include <map>
#include <utility>

#include "surfit/frame/preprocess.h"
#include "surfit/simulation/camera_path.h"
#include "surfit/simulation/render.h"
#include "surfit/simulation/scenes.h"

namespace surfit::testing {

// Two views of a furnished room, `gap` frames of a hand-held path apart, without noise.
struct SimulatedViews {
  FramePyramid source, target;
  Rigid3d target_from_source;
};

// The room made by a seed and the first poses of a path through it, made once for all tests.
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

inline SimulatedViews MakeViews(int first, int gap, std::uint64_t seed = 1) {
  PinholeCamera camera;
  camera.width = 160;
  camera.height = 120;
  camera.fx = camera.fy = 131;
  camera.cx = 79.5;
  camera.cy = 59.5;
  const auto& [scene, path] = MakeRoomWithPath(first + gap + 1, seed);
  const Rigid3d& source = path[first].world_from_camera;
  const Rigid3d& target = path[first + gap].world_from_camera;
  const auto view = [&](const Rigid3d& pose) {
    return PreprocessDepth(RenderFrame(scene, camera, pose).depth_m, camera, PreprocessOptions());
  };
  return {view(source), view(target), target.Inverse() * source};
}

}  // namespace surfit::testing
