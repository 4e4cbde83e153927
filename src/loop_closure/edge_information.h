#pragma once

#include "surfit/loop_closure/loop_closure.h"
#include "surfit/registration/icp.h"

namespace surfit {

// The information of the edge from keyframe a to b, which is so many frames later and was
// registered to the map: the inverse of the covariance of so many registrations, brought into the
// frame of a, and of the noise between both. Directions that the registration left free are held
// loosely.
Matrix6d OdometryInformation(const IcpResult& icp, int frames, const Rigid3d& a_from_b,
                             const EdgeNoise& noise);

// The information of a loop: the inverse of the covariance of its registration and the noise.
Matrix6d LoopInformation(const Matrix6d& registration_information, const EdgeNoise& noise);

}  // namespace surfit
