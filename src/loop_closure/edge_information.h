#pragma once

#include "surfit/loop_closure/loop_closure.h"
#include "surfit/registration/icp.h"

namespace surfit {

// Information matrix of the odometry edge from keyframe a to keyframe b, in the frame of a.
// `frames` is the number of frames from a to b. The covariance is the accumulated registration
// covariance plus the noise.
Matrix6d OdometryInformation(const IcpResult& icp, int frames, const Rigid3d& a_from_b,
                             const EdgeNoise& noise);

// Information matrix of a loop closure. The covariance is the registration covariance plus the
// noise.
Matrix6d LoopInformation(const Matrix6d& registration_information, const EdgeNoise& noise);

}  // namespace surfit
