#pragma once

#include <Eigen/Core>

#include "surfit/geometry/pinhole_camera.h"
#include "surfit/geometry/rigid3.h"

namespace surfit {

// A pinhole camera at a pose, in single precision, as the loops over pixels and surfels need it.
struct PosedCamera {
  PosedCamera(const PinholeCamera& camera, const Rigid3d& world_from_camera)
      : rotation(world_from_camera.Inverse().rotation.toRotationMatrix().cast<float>()),
        translation(world_from_camera.Inverse().translation.cast<float>()),
        world_rotation(world_from_camera.rotation.toRotationMatrix().cast<float>()),
        world_translation(world_from_camera.translation.cast<float>()),
        width(camera.width),
        height(camera.height),
        fx(static_cast<float>(camera.fx)),
        fy(static_cast<float>(camera.fy)),
        cx(static_cast<float>(camera.cx)),
        cy(static_cast<float>(camera.cy)) {}

  // The point that a pixel sees at a depth.
  Eigen::Vector3f PointAt(int u, int v, float depth) const {
    return {depth * ((static_cast<float>(u) - cx) / fx),
            depth * ((static_cast<float>(v) - cy) / fy), depth};
  }
  Eigen::Vector3f PointInWorld(const Eigen::Vector3f& point_in_camera) const {
    return world_rotation * point_in_camera + world_translation;
  }

  Eigen::Matrix3f rotation;        // camera from world
  Eigen::Vector3f translation;     // camera from world
  Eigen::Matrix3f world_rotation;  // world from camera
  Eigen::Vector3f world_translation;
  int width, height;
  float fx, fy, cx, cy;
};

}  // namespace surfit
