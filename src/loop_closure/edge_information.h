#pragma once

#include "surfit/loop_closure/loop_closure.h"
#include "surfit/registration/icp.h"

namespace surfit {

// Information matrix (PoseGraphEdge::information) of the odometry edge from keyframe a to keyframe
// b, in the frame of a. `frames` is the number of frames from a to b, at least 1. `icp` is the
// registration of b to the map; it stands for the registrations of all these frames. The covariance
// is the accumulated registration covariance plus the noise. Unobservable directions get a prior of
// 0.1 rad and 0.1 m.
Matrix6d OdometryInformation(const IcpResult& icp, int frames, const Rigid3d& a_from_b,
                             const EdgeNoise& noise);

// Information matrix of the edge of a relocalisation, from keyframe a to the relocalised keyframe
// b, in the frame of a. `icp` is the registration of b to the map. The covariance is the
// registration covariance of correlated points plus the noise of a loop closure.
Matrix6d RelocalizationInformation(const IcpResult& icp, const Rigid3d& a_from_b,
                                   const EdgeNoise& noise);

// Information matrix of a loop closure, for GlobalRegistrationResult::information. The covariance
// is the registration covariance plus the noise, with the same prior. Both matrices are in the
// frame of the target keyframe.
Matrix6d LoopInformation(const Matrix6d& registration_information, const EdgeNoise& noise);

}  // namespace surfit
