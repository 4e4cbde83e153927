#pragma once

#include <optional>

#include "surfit/registration/icp.h"
#include "surfit/tracking/tracking.h"
#include "tracking/frame_preprocessor.h"
#include "tracking/model_views.h"
#include "tracking/motion_prior.h"
#include "tracking/moving_regions.h"
#include "tracking/tracked.h"

namespace surfit {

// Returns whether the frame has enough points for a registration.
bool HasEnoughDepth(const PreprocessedFrame& frame, const IcpOptions& icp_options);

// Registers frames to reference views, without state of its own.
class FrameRegistration {
 public:
  // Keeps references. `regions` finds moving objects.
  FrameRegistration(const TrackingOptions& options, const MovingRegions& regions)
      : options_(options), regions_(regions) {}

  // Registers a frame and validates the pose. `motion_prior` is the covariance of the left
  // increment at the initial pose. If the registration is rejected, the frame is registered again
  // without the points that move at the initial pose.
  Tracked Register(const PreprocessedFrame& frame, const ReferenceView& reference,
                   const Rigid3d& world_from_initial, const IcpOptions& icp_options,
                   const std::optional<Matrix6d>& motion_prior = std::nullopt) const;

 private:
  struct Target {
    const ReferenceView& reference;
    const IcpOptions& icp;
    std::optional<ExpectedPose> prior;  // in the frame of the reference
  };
  struct Estimate {
    IcpResult icp;  // with the most likely pose
    bool is_weakly_constrained = false;
    std::optional<Matrix6d> covariance;  // of the left increment; only with a motion prior
  };

  // Registers geometrically, and a weakly constrained frame with photometric residuals as well.
  Estimate FromData(const FramePyramid& frame, const Target& target,
                    const Rigid3d& reference_from_initial) const;
  // Combines the registration with the motion prior.
  Estimate MostLikelyPose(const FramePyramid& frame, const Target& target,
                          const Rigid3d& reference_from_initial) const;
  // Validates an estimate. A frame with moving objects is first registered again without them.
  Tracked Validate(const PreprocessedFrame& frame, const Target& target,
                   const Estimate& estimate) const;

  const TrackingOptions& options_;
  const MovingRegions& regions_;
};

}  // namespace surfit
