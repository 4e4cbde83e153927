#pragma once

#include "surfit/loop_closure/loop_closure.h"
#include "surfit/registration/icp.h"

namespace surfit {

// Information of the odometry edge from keyframe a to keyframe b, in the frame of a. It is the
// inverse of the accumulated registration covariance plus the noise. `frames` is the number of
// frames from a to b. Unobservable directions have a large variance.
Matrix6d OdometryInformation(const IcpResult& icp, int frames, const Rigid3d& a_from_b,
                             const EdgeNoise& noise);

// Information of a loop closure: the inverse of its registration covariance plus the noise.
Matrix6d LoopInformation(const Matrix6d& registration_information, const EdgeNoise& noise);

}  // namespace surfit
