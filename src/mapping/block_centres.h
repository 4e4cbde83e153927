#pragma once

#include "mapping/per_surfel.h"
#include "mapping/posed_camera.h"

namespace surfit {

// Surfels with less depth than this, those behind the camera included, are not seen.
constexpr float kMinDepth = 0.05f;  // metres

// Where a camera sees the surfels of a block.
struct BlockCentres {
  alignas(32) PerSurfel<float> x, y, z;  // in the camera frame, metres
  // Inverse depth, 1/m, and px; meaningless where z is not above kMinDepth.
  alignas(32) PerSurfel<float> rho, u, v;
};

inline void FindCentres(const SurfelBlock& block, const PosedCamera& camera, BlockCentres* c) {
  const Eigen::Matrix3f r = camera.rotation;
  const Eigen::Vector3f t = camera.translation;
  const float fx = camera.fx, fy = camera.fy, cx = camera.cx, cy = camera.cy;
  const float r00 = r(0, 0), r01 = r(0, 1), r02 = r(0, 2), tx = t.x();
  const float r10 = r(1, 0), r11 = r(1, 1), r12 = r(1, 2), ty = t.y();
  const float r20 = r(2, 0), r21 = r(2, 1), r22 = r(2, 2), tz = t.z();
  for (int k = 0; k < SurfelBlock::kCapacity; ++k) {
    const float x = block.x[k], y = block.y[k], z = block.z[k];
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

// The normals in the camera frame.
struct BlockNormals {
  alignas(32) PerSurfel<float> x, y, z;
};

inline void FindNormals(const SurfelBlock& block, const PosedCamera& camera, BlockNormals* n) {
  const Eigen::Matrix3f r = camera.rotation;
  const float r00 = r(0, 0), r01 = r(0, 1), r02 = r(0, 2);
  const float r10 = r(1, 0), r11 = r(1, 1), r12 = r(1, 2);
  const float r20 = r(2, 0), r21 = r(2, 1), r22 = r(2, 2);
  for (int k = 0; k < SurfelBlock::kCapacity; ++k) {
    const float x = block.nx[k], y = block.ny[k], z = block.nz[k];
    n->x[k] = r00 * x + r01 * y + r02 * z;
    n->y[k] = r10 * x + r11 * y + r12 * z;
    n->z[k] = r20 * x + r21 * y + r22 * z;
  }
}

}  // namespace surfit
