#pragma once

#include "surfit/geometry/sensor.h"

namespace surfit {

// Sequences whose image y axis points up (fy < 0; ICL-NUIM) have left-handed camera and world
// frames. S = diag(1, -1, 1) mirrors both: a point x becomes S x, and with |fy| it keeps its pixel,
//   v = fy y/z + cy = |fy| (-y)/z + cy,
// so that images stay as they are. Mirroring twice gives the original back.

// S pose S: the same motion between mirrored frames. Its rotation matrix S R S turns by R's angle
// about -S axis (an axis is a pseudovector), hence the quaternion (-x, y, -z, w).
inline Rigid3d Mirrored(const Rigid3d& pose) {
  const Eigen::Quaterniond& q = pose.rotation;
  const Eigen::Vector3d& t = pose.translation;
  return Rigid3d(Eigen::Quaterniond(q.w(), -q.x(), q.y(), -q.z()), {t.x(), -t.y(), t.z()});
}

// The same lens before mirrored points: fy and the tangential coefficient p1 change sign.
inline PinholeCamera Mirrored(PinholeCamera camera) {
  camera.fy = -camera.fy;
  camera.distortion[2] = -camera.distortion[2];
  return camera;
}

inline RgbdCamera Mirrored(RgbdCamera camera) {
  camera.depth = Mirrored(camera.depth);
  camera.color = Mirrored(camera.color);
  camera.color_from_depth = Mirrored(camera.color_from_depth);
  return camera;
}

}  // namespace surfit
