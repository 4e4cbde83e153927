#pragma once

#include <Eigen/Core>

#include "mapping/map/block_lanes.h"
#include "surfit/geometry/pinhole_camera.h"
#include "surfit/geometry/rigid3.h"

namespace surfit {

// Camera intrinsics (px) and pose in single precision.
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

  // Transforms a point from the camera to the world frame, m.
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

// surfels with a smaller depth are not visible
constexpr float kMinDepth = 0.05f;  // metres

// Surfel centres of a block in the camera frame, m. Unused places have any values.
struct BlockCentres {
  alignas(32) PerSurfel<float> x, y, z;
  // Inverse depth (1/m) and pixel; invalid if z <= kMinDepth.
  alignas(32) PerSurfel<float> rho, u, v;
};

inline void FindCentres(const SurfelBlock& block, const PosedCamera& camera, BlockCentres* c) {
  // Positions in the block are multiples of a step from its origin.
  const Eigen::Matrix3f r = SmallCoordinate::kStep * camera.rotation;
  const Eigen::Vector3f t =
      camera.rotation * Eigen::Map<const Eigen::Vector3f>(block.origin) + camera.translation;
  const float fx = camera.fx, fy = camera.fy, cx = camera.cx, cy = camera.cy;
  const float r00 = r(0, 0), r01 = r(0, 1), r02 = r(0, 2), tx = t.x();
  const float r10 = r(1, 0), r11 = r(1, 1), r12 = r(1, 2), ty = t.y();
  const float r20 = r(2, 0), r21 = r(2, 1), r22 = r(2, 2), tz = t.z();
  for (int k = 0; k < SurfelBlock::kCapacity; ++k) {
    const auto x = static_cast<float>(block.x[k]), y = static_cast<float>(block.y[k]),
               z = static_cast<float>(block.z[k]);
    const float in_x = r00 * x + r01 * y + r02 * z + tx;
    const float in_y = r10 * x + r11 * y + r12 * z + ty;
    const float in_z = r20 * x + r21 * y + r22 * z + tz;
    const float rho = 1.f / (in_z > kMinDepth ? in_z : 1.f);
    c->x[k] = in_x;
    c->y[k] = in_y;
    c->z[k] = in_z;
    c->rho[k] = rho;
    c->u[k] = fx * in_x * rho + cx;
    c->v[k] = fy * in_y * rho + cy;
  }
}

struct BlockNormals {
  alignas(32) PerSurfel<float> x, y, z;
};

inline void FindNormals(const SurfelBlock& block, const PosedCamera& camera, BlockNormals* n) {
  const Eigen::Matrix3f r = camera.rotation;
  const float r00 = r(0, 0), r01 = r(0, 1), r02 = r(0, 2);
  const float r10 = r(1, 0), r11 = r(1, 1), r12 = r(1, 2);
  const float r20 = r(2, 0), r21 = r(2, 1), r22 = r(2, 2);
  for (int k = 0; k < SurfelBlock::kCapacity; ++k) {
    const float x = SmallUnit::ToFloat(block.nx[k]), y = SmallUnit::ToFloat(block.ny[k]),
                z = SmallUnit::ToFloat(block.nz[k]);
    n->x[k] = r00 * x + r01 * y + r02 * z;
    n->y[k] = r10 * x + r11 * y + r12 * z;
    n->z[k] = r20 * x + r21 * y + r22 * z;
  }
}

}  // namespace surfit
