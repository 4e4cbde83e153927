#pragma once

#include "registration/simulated_views.h"
#include "surfit/frame/frame_pyramid.h"

namespace surfit::testing {

// Two views of a textured wall at 1.5 m that fills them: its shape leaves open a shift along it and
// a turn about its normal.
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

// They as frames with intensities.
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

  // As if the source had been exposed otherwise.
  void ChangeExposure(float gain, float offset) {
    for (FrameLevel& level : source.levels) {
      for (float& value : level.intensity) value = gain * value + offset;
    }
  }
};

// A small motion along the wall: two pixels at the most.
inline Rigid3d AlongTheWall() { return {QuaternionExp<double>({0, 0, 0.02}), {0.015, -0.01, 0}}; }

// A tenth of a pixel, which is 11 mm at 1.5 m.
constexpr double kWallToleranceM = 0.0011, kWallToleranceRad = 0.0008;

}  // namespace surfit::testing
