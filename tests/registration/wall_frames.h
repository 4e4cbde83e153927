#pragma once

#include "registration/simulated_views.h"
#include "surfit/frame/frame_pyramid.h"

namespace surfit::testing {

// Two frames of a textured wall at 1.5 m that fills the view: its shape leaves open a shift along
// it and a turn about its normal.
struct WallFrames {
  FramePyramid source, target;
  Rigid3d target_from_source;

  explicit WallFrames(const Rigid3d& pose) : target_from_source(pose) {
    const Scene scene = MakeScene("wall");
    Eigen::Matrix3d along_y;
    along_y << 1, 0, 0, 0, 0, 1, 0, -1, 0;
    const Rigid3d world_from_source(along_y, Eigen::Vector3d(0, 0.5, 1));
    const auto frame = [&](const Rigid3d& world_from_camera) {
      ColoredView view = MakeColoredView(scene, world_from_camera);
      AddIntensity(view.color, &view.pyramid);
      return std::move(view.pyramid);
    };
    source = frame(world_from_source);
    target = frame(world_from_source * pose.Inverse());
  }

  // As if the source had been exposed otherwise.
  void ChangeExposure(float gain, float offset) {
    for (FrameLevel& level : source.levels) {
      for (float& value : level.intensity) value = gain * value + offset;
    }
  }
};

// A small motion along the wall: two pixels at the most.
inline Rigid3d AlongTheWall() { return {QuaternionExp<double>({0, 0, 0.02}), {0.015, -0.01, 0}}; }

}  // namespace surfit::testing
