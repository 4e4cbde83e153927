#include "surfit/core/options.h"

#include <cmath>

#include "surfit/optimization/refine.h"

namespace surfit {

void PriorOptions::Visit(OptionVisitor& v) {
  v.Add(focal_relative_sigma, "focal_relative_sigma",
        "relative standard deviation of the input fx and fy, 0: unknown; empty: prior of the "
        "sensor, also for the following options");
  v.Add(aspect_relative_sigma, "aspect_relative_sigma",
        "relative standard deviation of the input fx / fy");
  v.Add(center_px, "center_px", "standard deviation of the input cx and cy", InUnit("px"));
  v.Add(inverse_depth_sigma, "inverse_depth_sigma",
        "standard deviation of the input correction of inverse depth", InUnit("1/m"));
  v.Add(readout_s, "readout_s", "standard deviation of the input readout", InUnit("s"));
  v.Check([this] { Validate(Over({})); });
}

CalibrationPrior PriorOptions::Over(CalibrationPrior sensor) const {
  sensor.focal_relative_sigma = focal_relative_sigma.value_or(sensor.focal_relative_sigma);
  sensor.aspect_relative_sigma = aspect_relative_sigma.value_or(sensor.aspect_relative_sigma);
  sensor.center_px = center_px.value_or(sensor.center_px);
  sensor.inverse_depth_sigma = inverse_depth_sigma.value_or(sensor.inverse_depth_sigma);
  sensor.readout_s = readout_s.value_or(sensor.readout_s);
  return sensor;
}

void PriorOptions::Complete(const CalibrationPrior& sensor) {
  const CalibrationPrior prior = Over(sensor);
  focal_relative_sigma = prior.focal_relative_sigma;
  aspect_relative_sigma = prior.aspect_relative_sigma;
  center_px = prior.center_px;
  inverse_depth_sigma = prior.inverse_depth_sigma;
  readout_s = prior.readout_s;
}

void RefinementOptions::Visit(OptionVisitor& v) {
  v.Group("refinement");
  v.Add(estimate_intrinsics, "estimate_intrinsics", "estimate fx fy cx cy");
  v.Add(estimate_depth_offset, "estimate_depth_offset", "estimate an offset of inverse depth");
  v.Add(estimate_depth_field, "estimate_depth_field",
        "estimate the variation of the inverse depth error over the image: a quadratic polynomial");
  v.Add(estimate_readout, "estimate_readout",
        "estimate the rolling-shutter readout, if the camera moves");
  v.AddPart(prior, "prior", "prior of the input calibration");
  v.Add(cells_across, "cells_across",
        "number of columns of square cells of a keyframe image, with at most one surfel per cell",
        AtLeast(1));
  v.Add(observation_angle_rad, "observation_angle_rad",
        "maximum angle between the normals of observation and surfel", Positive(), Below(M_PI / 2));
  v.Add(max_slant_rad, "max_slant_rad", "maximum angle between surface normal and viewing ray",
        Positive(), Below(M_PI / 2));
  v.AddPart(error_model, "error_model", "error model and robust kernels",
            OnlyFlags({"photometric_weight"}));
  v.Add(
      motion_sigma_m, "motion_sigma_m",
      "standard deviation of the motion prior between keyframes, if the input calibration is kept",
      ZeroIs("not used"));
  v.Add(motion_sigma_rad, "motion_sigma_rad",
        "standard deviation of the rotation of the motion prior", ZeroIs("not used"));
  v.Add(calibration_sigmas, "calibration_sigmas",
        "significance of a new calibration, in standard deviations: the input calibration is kept "
        "if the estimate differs less",
        AtLeast(0));
  v.Add(
      model_error_ratio, "model_error_ratio",
      "systematic error of the model, as a ratio of the focal length, of the inverse depth at 3 m, "
      "and of a readout of 1 s",
      AtLeast(0));
  v.Add(kept_angle_ratio, "kept_angle_ratio",
        "factor of observation_angle_rad with a kept calibration", Positive(), Between(0, 1));
  v.Add(kept_kernel_ratio, "kept_kernel_ratio",
        "factor of the kernel width with a kept calibration", Positive(), Between(0, 1));
  v.Add(solver, "solver",
        "solver of a round; reduced: Schur complement of the surfels; ceres: ceres::Problem with "
        "one residual block per observation",
        OneOf(RefinementSolverNames()), AsFlag());
  v.Add(linear_solver, "linear_solver",
        "linear solver of ceres: sparse factorisation or conjugate gradients",
        OneOf(RefinementLinearSolverNames()), AsFlag());
  v.Add(max_rounds, "max_rounds", "maximum number of rounds, which select surfels and solve",
        Between(1, 1000));
  v.Add(max_iterations, "max_iterations",
        "maximum number of Levenberg-Marquardt iterations per round", Between(1, 1000));
  v.Add(min_relative_step_change, "min_relative_step_change",
        "relative cost change below which the iterations of a round end", AtLeast(0));
  v.Add(min_relative_cost_change, "min_relative_cost_change",
        "relative cost decrease below which the rounds end", AtLeast(0));
  v.Add(kernel_growth, "kernel_growth",
        "factor of the kernel width in the first round, halved each round", AtLeast(1));
  v.Add(correlation_px, "correlation_px",
        "distance within which surfels share errors of their normals", AtLeast(1));
}

}  // namespace surfit
