#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "surfit/frame/preprocess.h"
#include "surfit/loop_closure/keyframe.h"
#include "surfit/loop_closure/place_index.h"
#include "surfit/simulation/camera_path.h"
#include "surfit/simulation/render.h"
#include "surfit/simulation/scene.h"

namespace surfit::testing {

inline PinholeCamera PlaceCamera() { return {320, 240, 262, 262, 159.5, 119.5, {}}; }

inline RgbdFrame SeenFrom(const Scene& scene, const Rigid3d& world_from_camera, int index = 0) {
  RgbdFrame frame = RenderFrame(scene, PlaceCamera(), world_from_camera, index, index / 30.);
  frame.depth_m = KinectDepth(frame.depth_m, PlaceCamera(), 100 + index);
  return frame;
}

inline Keyframe KeyframeOf(const RgbdFrame& frame, const Rigid3d& world_from_camera) {
  const FramePyramid pyramid =
      PreprocessDepth(frame.depth_m, {PlaceCamera(), {}}, PreprocessOptions());
  return {frame.index, frame.stamp_s, world_from_camera,
          MakePlaceView(pyramid, frame.color, PlaceViewOptions())};
}

inline PlaceIndex IndexOf(const std::vector<Keyframe>& keyframes) {
  PlaceIndex index;
  for (int i = 0; i < static_cast<int>(keyframes.size()); ++i) index.Add(i, keyframes[i].view);
  return index;
}

// Furnished room with a keyframe at every tenth of the first 300 frames of a hand-held path. Rooms
// are created once and shared by all tests.
struct RoomOfKeyframes {
  Scene scene;
  Trajectory path;
  std::vector<Keyframe> keyframes;
};

inline const RoomOfKeyframes& MakeRoomOfKeyframes(std::uint64_t seed) {
  constexpr int kFrames = 300, kStride = 10;
  static std::map<std::uint64_t, RoomOfKeyframes> rooms;
  RoomOfKeyframes& room = rooms[seed];
  if (room.path.empty()) {
    room.scene = MakeScene("room", seed);
    room.path = MakePath(room.scene, kFrames, seed);
    for (int i = 0; i < kFrames; i += kStride) {
      const Rigid3d& pose = room.path[i].world_from_camera;
      room.keyframes.push_back(KeyframeOf(SeenFrom(room.scene, pose, i), pose));
    }
  }
  return room;
}

// View near a keyframe of the room, with its true pose.
struct ViewNearby {
  PlaceView view;
  Rigid3d keyframe_from_view;
};

inline ViewNearby SeeNearby(const RoomOfKeyframes& room, int keyframe,
                            const Rigid3d& keyframe_from_view) {
  const Rigid3d pose = room.keyframes[keyframe].world_from_camera * keyframe_from_view;
  return {KeyframeOf(SeenFrom(room.scene, pose, 1000 + keyframe), pose).view, keyframe_from_view};
}

}  // namespace surfit::testing
