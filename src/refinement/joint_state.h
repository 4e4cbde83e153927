#pragma once

#include <Eigen/Core>
#include <vector>

#include "surfit/geometry/rigid3.h"
#include "surfit/refinement/depth_calibration.h"

namespace surfit {

// What is to be found, but for the surfels' own numbers.
struct JointState {
  std::vector<Rigid3d> world_from_camera;
  DepthCalibration calibration;
};

// Poses as the rows use them. The state must outlive it.
struct PlacedPoses {
  explicit PlacedPoses(const JointState& joint) : state(joint) {
    for (const Rigid3d& pose : joint.world_from_camera) {
      rotations.push_back(pose.rotation.toRotationMatrix());
    }
  }

  const JointState& state;
  std::vector<Eigen::Matrix3d> rotations;
};

}  // namespace surfit
