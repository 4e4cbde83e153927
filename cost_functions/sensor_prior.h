#pragma once

#include "cost_functions/pose_error.h"

namespace surfit {

// Measured pose Z = world_from_sensor of a sensor with a known offset P = pose_from_sensor, six
// residuals. The error of the pose X = world_from_pose is E = Z^-1 X P, as in EDGE_SE3_PRIOR of
// g2o. The residuals are U (rotation vector of E [rad], translation of E [m]), in standard
// deviations, with U^T U = information (1/rad^2, 1/m^2). The parameter block is X (pose.h).
class SensorPrior {
 public:
  SensorPrior(const Rigid3d& pose_from_sensor, const Rigid3d& world_from_sensor,
              const PoseInformation& information)
      : pose_from_sensor_(pose_from_sensor),
        sensor_from_world_(world_from_sensor.Inverse()),
        whiten_(information) {}

  template <typename T>
  bool operator()(const T* world_from_pose, T* residuals) const {
    whiten_(sensor_from_world_.cast<T>() *
                (PoseFromBlock(world_from_pose) * pose_from_sensor_.cast<T>()),
            residuals);
    return true;
  }

 private:
  Rigid3d pose_from_sensor_, sensor_from_world_;
  WhitenedPoseError whiten_;
};

}  // namespace surfit
