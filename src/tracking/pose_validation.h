#pragma once

#include "surfit/frame/camera_motion.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/registration/global_registration.h"
#include "surfit/registration/icp.h"
#include "surfit/tracking/tracking.h"
#include "tracking/feature_watch.h"
#include "tracking/frame_preprocessor.h"
#include "tracking/tracked.h"
#include "tracking/view_comparison.h"

namespace surfit {

// Validates a registration by inlier ratio, RMSE, free-space violations, occlusions and brightness.
// `views` is the comparison at the registered pose. `moving`: number of moving cells in front of
// the model. Rejects a failed registration, and a view without static cells to compare.
Verdict ValidateRegistration(const IcpResult& icp, const ViewComparison& views, int moving,
                             const TrackingOptions& options);

// Returns whether new surfaces may be the reason for an uncertain or rejected pose. Then few
// cells are behind the model. At a wrong pose, more cells are behind it.
bool MayShowNewSurfaces(const Tracked& tracked);

// Largest motion of a hand-held camera in this time: 0.1 m + 3 m/s and 0.2 rad + 6 rad/s.
MotionBound PossibleMotion(double seconds);

// Returns whether two poses agree within 5 cm and 0.05 rad.
bool AreOnePlace(const Rigid3d& a, const Rigid3d& b);

// Returns whether two poses agree within the forward-backward consistency bounds of FitCriteria.
bool AgreeClosely(const Rigid3d& a, const Rigid3d& b);

// Runs the feature check if it is due or the pose was found by search. Marks the frame as lost if
// most features contradict the pose. `since_last`: camera velocity since the last frame. Call for
// every frame, also if it is lost: the corners are followed in each frame. Sets `has_two_motions`
// if the check ran.
Tracked ValidateByFeatures(const PreprocessedFrame& frame, Tracked tracked,
                           const CameraMotion& since_last, FeatureWatch* features);

}  // namespace surfit
