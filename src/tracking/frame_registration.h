#pragma once

#include <optional>

#include "surfit/registration/icp.h"
#include "surfit/tracking/tracking.h"
#include "tracking/frame_preprocessor.h"
#include "tracking/model_views.h"
#include "tracking/motion/motion_prior.h"
#include "tracking/moving_regions.h"
#include "tracking/tracked.h"

namespace surfit {

// Returns the number of pixels with a normal outside of `moving`.
int CountNormals(const PreprocessedFrame& frame, const CellMask& moving = {});

// Returns whether at least IcpOptions::min_inliers pixels have a normal.
bool HasEnoughDepth(const PreprocessedFrame& frame, const IcpOptions& icp_options);

// Registers a frame to a view and validates the result. Thread-safe while options and regions do
// not change.
class FrameRegistration {
 public:
  // Keeps references to the arguments.
  FrameRegistration(const TrackingOptions& options, const MovingRegions& regions)
      : options_(options), regions_(regions) {}

  // `is_hurried`: treats fewer frames as weakly constrained, because frames arrive too fast.
  void Hurry(bool is_hurried) { is_hurried_ = is_hurried; }
  bool is_hurried() const { return is_hurried_; }

  // Registers `frame` to `reference` from the camera pose `world_from_initial`. `motion`:
  // uncertainty of this pose. The result then combines prior and registration. A rejected frame is
  // registered again without the objects that move relative to the initial pose.
  //
  // A failed registration is lost, with the verdict kRejected. An uncertain result has a pose.
  Tracked Register(const PreprocessedFrame& frame, const ReferenceView& reference,
                   const Rigid3d& world_from_initial, const IcpOptions& icp_options,
                   const std::optional<MotionUncertainty>& motion = std::nullopt) const;

 private:
  struct Target {
    const ReferenceView& reference;
    const IcpOptions& icp;
    std::optional<ExpectedPose> prior;  // in the frame of the reference
    MotionUncertainty motion;           // of the prior
  };
  struct Estimate {
    IcpResult icp;       // pose: combined with the motion prior; all else: without it
    IcpOptions options;  // of the registration
    Rigid3d registered;  // pose without the motion prior
    bool is_weakly_constrained = false;
    std::vector<Vector6d> degenerate_directions;  // of the registration by depth
    std::optional<Matrix6d> covariance;           // of the left increment; only with a motion prior
    double squared_difference = 0;                // of `registered` from the motion prior
  };

  bool IsWeaklyConstrained(const IcpResult& icp) const;
  // Registers a weakly constrained frame again with photometric residuals.
  Estimate FromData(const FramePyramid& frame, const Target& target,
                    const Rigid3d& reference_from_initial) const;
  Estimate MostLikelyPose(const FramePyramid& frame, const Target& target,
                          const Rigid3d& reference_from_initial) const;
  void MinimizeWithPrior(const FramePyramid& frame, const Target& target, const PriorTerm& prior,
                         Estimate* estimate) const;
  // If the frame has moving objects, registers the frame again without them first.
  Tracked Validate(const PreprocessedFrame& frame, const Target& target,
                   const Estimate& estimate) const;

  const TrackingOptions& options_;
  const MovingRegions& regions_;
  bool is_hurried_ = false;
};

}  // namespace surfit
