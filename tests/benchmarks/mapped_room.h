#pragma once

#include <cstddef>
#include <utility>

#include "surfit/frame/preprocess.h"
#include "surfit/mapping/fusion.h"
#include "surfit/mapping/surfel_map.h"
#include "surfit/simulation/camera_path.h"
#include "surfit/simulation/render.h"
#include "surfit/simulation/scene.h"

namespace surfit::testing {

// Map of about 500,000 surfels from frames of a simulated room, and the next frame.
struct MappedRoom {
  static constexpr int kFrames = 20;
  PinholeCamera camera{640, 480, 525, 525, 319.5, 239.5, {}};
  SurfelMap map;
  RgbdFrame next;
  FrameLevel next_surface;
  Rigid3d world_from_next;

  MappedRoom() {
    const Scene scene = MakeScene("room", 1);
    const Trajectory path = MakePath(scene, kFrames + 1, 1);
    Fusion fusion({});
    for (next.index = 0;; ++next.index) {
      world_from_next = path[next.index].world_from_camera;
      Rendering image = Render(scene, camera, world_from_next);
      next.depth_m = KinectDepth(image.depth_m, camera, next.index);
      next.color = std::move(image.color);
      next_surface = PreprocessDepth(next.depth_m, {camera, {}}, {}).levels[0];
      if (next.index == kFrames) return;
      fusion.Fuse(next, next_surface, world_from_next, &map);
    }
  }

  // Adds surfels behind the camera until the map has `count` surfels: a wall of 20 m width with a
  // spacing of 5 mm.
  void GrowElsewhere(std::size_t count, SurfelMap* grown) const {
    Surfel far = map[map.Ids().front()];
    far.confidence = FusionOptions().min_inactive_confidence;
    const Eigen::Vector3f from = world_from_next.translation.cast<float>();
    const Eigen::Vector3f backwards = -world_from_next.rotation.matrix().col(2).cast<float>();
    constexpr int kColumns = 4000;
    for (std::size_t i = grown->size() - map.size(); grown->size() < count; ++i) {
      const Eigen::Vector3f wall(static_cast<float>(i / kColumns), static_cast<float>(i % kColumns),
                                 0);
      far.position_in_world = from + 20 * backwards + 0.005f * wall;
      grown->Append(far);
    }
  }
};

}  // namespace surfit::testing
