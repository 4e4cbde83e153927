#pragma once

#include "surfit/frame/camera_motion.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/registration/icp.h"
#include "surfit/tracking/tracking.h"
#include "tracking/feature_watch.h"
#include "tracking/frame_preprocessor.h"
#include "tracking/tracked.h"
#include "tracking/view_comparison.h"

namespace surfit {

// Validates a registration by its residuals and by the views at its pose: free-space violations,
// occlusions and brightness. `moving` is the number of cells in front of the model that belong to
// moving objects.
Verdict ValidateRegistration(const IcpResult& icp, const ViewComparison& views, int moving,
                             const TrackingOptions& options);

// Returns whether a frame with an uncertain or rejected pose may show new surfaces. The frame then
// has few cells behind the model, in contrast to a frame with a wrong pose.
bool MayShowNewSurfaces(const Tracked& tracked);

// Returns whether a hand can move a camera by this motion.
bool IsPossibleMotion(const Rigid3d& motion, double seconds);

// Returns whether two registrations to the map agree. Wrong poses differ by more.
bool AreOnePlace(const Rigid3d& a, const Rigid3d& b);

// Returns whether two registrations agree as closely as a forward and a backward registration.
bool AgreeClosely(const Rigid3d& a, const Rigid3d& b);

// Validates a pose by image features, if a check is due: the frame is lost if most features
// contradict the pose. `since_last` is the camera motion since the last frame.
Tracked ValidateByFeatures(const PreprocessedFrame& frame, Tracked tracked,
                           const CameraMotion& since_last, FeatureWatch* features);

}  // namespace surfit
