// The options of this module.
#include "surfit/core/options.h"

#include <cmath>

#include "surfit/optimization/refine.h"

namespace surfit {

void PriorOptions::Visit(OptionVisitor& v) {
  v.Add(focal_share, "focal_share",
        "standard deviation of the given fx and fy, as a share of them, 0 = unknown; empty: what "
        "is known of the sensor, as for the next ones",
        AsFlag("prior_focal_share"));
  v.Add(aspect_share, "aspect_share", "and of the given fx / fy", AsFlag("prior_aspect_share"));
  v.Add(center_px, "center_px", "and of the given cx and cy", InUnit("px"),
        AsFlag("prior_center_px"));
  v.Add(inverse_depth_sigma, "inverse_depth_sigma", "and of the given correction of inverse depth",
        InUnit("1/m"), AsFlag("prior_inverse_depth"));
  v.Add(readout_s, "readout_s", "and of the given readout", InUnit("s"), AsFlag("prior_readout_s"));
  v.Check([this] { Validate(Over({})); });
}

CalibrationPrior PriorOptions::Over(CalibrationPrior sensor) const {
  sensor.focal_share = focal_share.value_or(sensor.focal_share);
  sensor.aspect_share = aspect_share.value_or(sensor.aspect_share);
  sensor.center_px = center_px.value_or(sensor.center_px);
  sensor.inverse_depth_sigma = inverse_depth_sigma.value_or(sensor.inverse_depth_sigma);
  sensor.readout_s = readout_s.value_or(sensor.readout_s);
  return sensor;
}

void PriorOptions::Complete(const CalibrationPrior& sensor) {
  const CalibrationPrior prior = Over(sensor);
  focal_share = prior.focal_share;
  aspect_share = prior.aspect_share;
  center_px = prior.center_px;
  inverse_depth_sigma = prior.inverse_depth_sigma;
  readout_s = prior.readout_s;
}

void RefinementOptions::Visit(OptionVisitor& v) {
  v.Group("refinement");
  v.Add(free_intrinsics, "free_intrinsics", "estimate fx fy cx cy as well", Everyday());
  v.Add(free_depth_offset, "free_depth_offset", "estimate an offset of inverse depth as well",
        Everyday());
  v.Add(free_depth_field, "free_depth_field",
        "estimate as well how the error of inverse depth varies over the image: a quadratic "
        "polynomial",
        Everyday());
  v.Add(free_readout, "free_readout",
        "estimate the readout of a rolling shutter as well, where the camera moves", Everyday());
  v.AddPart(prior, "prior", "what is known of the given calibration");
  v.Add(cells_across, "cells_across",
        "columns of square cells of a keyframe's image, with at most one surfel in each",
        AtLeast(1), AsFlag());
  v.Add(min_observations, "min_observations", "surfels that fewer keyframes see do not count",
        AtLeast(2));
  v.Add(observation_distance_m, "observation_distance_m",
        "keyframes observe surfels whose plane is this near", Positive());
  v.Add(observation_angle_rad, "observation_angle_rad", "and whose normal differs by at most this",
        Positive(), Below(M_PI / 2));
  v.Add(max_slant_rad, "max_slant_rad", "angle between a surface's normal and the ray that sees it",
        Positive(), Below(M_PI / 2));
  v.AddPart(error_model, "error_model", "what residuals are worth",
            OnlyFlags({"photometric_weight", "intensity_sigma"}));
  v.Add(motion_sigma_m, "motion_sigma_m",
        "standard deviation of the tracked motion between keyframes where the calibration is kept",
        ZeroIs("not used"));
  v.Add(motion_sigma_rad, "motion_sigma_rad", "and of its rotation", ZeroIs("not used"));
  v.Add(calibration_sigmas, "calibration_sigmas",
        "the given calibration is kept unless the estimate differs by more than expected, plus "
        "this many standard deviations",
        AtLeast(0));
  v.Add(model_error_share, "model_error_share",
        "error of the model, as a share of focal length, depth and a second of readout",
        AtLeast(0));
  v.Add(kept_angle_share, "kept_angle_share",
        "observation_angle_rad shrinks to this share with a kept one", Positive(), Between(0, 1));
  v.Add(kept_kernel_share, "kept_kernel_share", "and the robust kernel's width to this", Positive(),
        Between(0, 1));
  v.Add(solver, "solver",
        "solver of a round; reduced: surfels eliminated by hand; ceres: Ceres over a residual "
        "block for each observation",
        OneOf(RefinementSolverNames()), AsFlag("refinement_solver"));
  v.Add(linear_solver, "linear_solver",
        "how ceres solves for poses and calibration: by a sparse factorisation or conjugate "
        "gradients",
        OneOf(RefinementLinearSolverNames()), AsFlag("refinement_linear_solver"));
  v.Add(max_rounds, "max_rounds", "rounds of choosing surfels and solving for all at most",
        Between(1, 1000), AsFlag());
  v.Add(max_iterations, "max_iterations", "iterations of Levenberg-Marquardt in each round",
        Between(1, 1000));
  v.Add(min_relative_step_change, "min_relative_step_change",
        "iterations of a round end where the cost changes by a smaller share", AtLeast(0));
  v.Add(min_relative_cost_change, "min_relative_cost_change",
        "rounds end where the cost changes by a smaller share", AtLeast(0));
  v.Add(kernel_growth, "kernel_growth",
        "the robust kernel starts this many times as wide, and halves each round", AtLeast(1));
  v.Add(correlation_px, "correlation_px",
        "surfels nearer to each other share errors of their normals", AtLeast(1));
}

}  // namespace surfit
