#pragma once

#include <Eigen/Core>

#include "surfit/geometry/pinhole_camera.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/mapping/surfel_map.h"

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

  Eigen::Vector3f PositionInCamera(const SurfelMap& map, std::size_t i) const {
    return rotation * Eigen::Vector3f(map.x[i], map.y[i], map.z[i]) + translation;
  }
  Eigen::Vector3f NormalInCamera(const SurfelMap& map, std::size_t i) const {
    return rotation * Eigen::Vector3f(map.nx[i], map.ny[i], map.nz[i]);
  }
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

// A few hundred surfels in the camera's frame and its image, as structure of arrays.
struct ProjectedChunk {
  static constexpr int kCapacity = 512;
  // Depths below this, behind the camera included, project to u = v = kOutside.
  static constexpr float kMinDepth = 0.05f;  // metres
  static constexpr float kOutside = -1e6f;   // px

  // Projects the surfels [begin, end), at most kCapacity of them.
  void Project(const SurfelMap& map, const PosedCamera& camera, int begin, int end);

  float x[kCapacity], y[kCapacity], z[kCapacity];  // metres
  float u[kCapacity], v[kCapacity];                // px
};

}  // namespace surfit
