#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "surfit/geometry/inverse_depth_field.h"
#include "surfit/geometry/sensor.h"
#include "surfit/optimization/keyframes.h"
#include "surfit/registration/error_model.h"

namespace surfit {

class OptionVisitor;

// Overrides of RgbdCamera::prior, the prior of the input calibration. 0: no prior. std::nullopt:
// Refine() uses the default of CalibrationPrior. Call Complete() first to use the prior of the
// sensor. Units: see CalibrationPrior.
struct PriorOptions {
  std::optional<double> focal_relative_sigma, aspect_relative_sigma, center_px, inverse_depth_sigma,
      readout_s;

  // Returns `sensor` with these overrides.
  CalibrationPrior Over(CalibrationPrior sensor) const;
  // Sets the empty members to the values of the sensor.
  void Complete(const CalibrationPrior& sensor);

  void Visit(OptionVisitor& visitor);
};

// Solvers of a round. Both minimise the same cost:
// - "reduced": normal equations of poses and calibration, with the surfel parameters eliminated by
//   the Schur complement
// - "ceres": a ceres::Problem with one autodiff residual block per observation
std::vector<std::string> RefinementSolverNames();
// Linear solvers of "ceres": "sparse_schur" (sparse factorisation by
// SparseBackendNames().front()), "iterative_schur" (conjugate gradients).
std::vector<std::string> RefinementLinearSolverNames();

// Options of the joint refinement of keyframe poses and calibration.
struct RefinementOptions {
  // Calibration parameters to estimate. The scale of depth is not observable and is not
  // estimated.
  bool estimate_intrinsics = true;    // fx fy cx cy
  bool estimate_depth_offset = true;  // c0 of InverseDepthField
  bool estimate_depth_field = true;   // other coefficients of InverseDepthField
  bool estimate_readout = true;       // rolling-shutter readout; only if a keyframe has motion
  PriorOptions prior;                 // prior of the input calibration

  // Number of columns of square cells in a keyframe image. Each cell has at most one surfel.
  int cells_across = 120;
  double observation_angle_rad = 0.6;  // maximum angle between the normals
  double max_slant_rad = 1.2;  // maximum angle between the surface normal and the viewing ray
  // Error model of the residuals. A positive photometric weight adds texture residuals: see
  // Refine().
  ErrorModel error_model;

  // Standard deviations of the motion prior between consecutive keyframes. If one is 0, there
  // is no motion prior. The prior is used only if the input calibration is kept or not
  // estimated.
  double motion_sigma_m = 0.0005;
  double motion_sigma_rad = 0.0005;
  // Significance of a new calibration. The input calibration is kept unless the squared
  // Mahalanobis distance exceeds its mean by this number of its standard deviations.
  double calibration_sigmas = 3;
  // Relative systematic error of the model, for example by disparity steps and curved
  // surfaces. Standard deviations of this ratio are added to the covariance of the
  // calibration. They refer to the focal length (fx fy cx cy), 1 / (3 m) (inverse depth) and 1
  // s (readout).
  double model_error_ratio = 0.0005;
  // Factors of `observation_angle_rad` and of the kernel width if only poses are refined.
  // Narrow gates reject points of curved or neighbouring surfaces, but prevent the correction
  // of a wrong calibration.
  double kept_angle_ratio = 1. / 3;
  double kept_kernel_ratio = 0.5;

  // One of RefinementSolverNames(), and for "ceres" one of RefinementLinearSolverNames().
  std::string solver = "reduced";
  std::string linear_solver = "sparse_schur";

  int max_rounds = 15;      // maximum number of rounds: create surfels, then solve
  int max_iterations = 10;  // maximum number of Levenberg-Marquardt iterations per round
  // Relative change of the cost at which the iterations of a round end. Small, because the
  // cost hardly depends on some directions.
  double min_relative_step_change = 1e-6;
  // Relative decrease of the cost below which the rounds end.
  double min_relative_cost_change = 1e-4;
  // Factor of the kernel width in the first round, halved in each round until it is 1. Larger
  // values allow larger initial errors.
  double kernel_growth = 4;

  // Distance within which surfels have correlated normals. If cells are smaller, the
  // covariances are increased by the squared ratio.
  int correlation_px = 7;

  void Visit(OptionVisitor& visitor);
};

// Termination of Refine().
enum class RefinementTermination {
  kConverged,      // relative decrease of the cost in a round below the threshold
  kMaxRounds,      // success with the last poses and calibration
  kTooFewSurfels,  // fewer than 2 keyframes or 100 shared surfels; poses are unchanged
  kFailed,         // solver failure; poses are unchanged
};

// "converged", "max_rounds", "too_few_surfels", "failed".
std::string ToString(RefinementTermination termination);

// Final residuals: root mean squares, weighted by the robust kernel.
struct RefinementFit {
  double cost = 0;           // 1/2 sum of rho, without unit
  double rms_sigmas = 0;     // in standard deviations of the error model
  double rms_m = 0;          // point-to-plane distance
  double rms_intensity = 0;  // intensity difference, in [0, 1]; 0 without texture
};

// Statistics of one round, which creates surfels and then solves. Fits are computed with the
// kernel width of the round.
struct RefinementRound {
  std::size_t surfels = 0, observations = 0;
  std::size_t texture_observations = 0;  // 0 without photometric weight
  RefinementFit before, after;           // before and after solving
  int iterations = 0;
  DepthCalibration calibration;  // after the round
};

// Result of Refine().
struct RefinementSummary {
  RefinementTermination termination = RefinementTermination::kFailed;
  // Estimated calibration. `given` if the input calibration is kept or only poses are refined.
  // `start` after a failed estimation.
  DepthCalibration calibration;
  // Covariance of the estimated calibration: fx fy cx cy [px], c0 .. c5 [1/m] and the readout [s],
  // 11 x 11. 0 for fixed parameters, empty after any failure. Scaled by the variance of the final
  // residuals, plus the error of the model (`model_error_ratio`).
  Eigen::MatrixXd calibration_covariance;
  // Squared Mahalanobis distance of the estimated calibration from the input calibration, and its
  // upper limit for keeping the input calibration. Both are 0 if the calibration is not estimated.
  double calibration_distance = 0, calibration_limit = 0;
  // Decrease of the squared residuals of the first and the last half of the keyframes, in units of
  // their variance. Compares the estimated with the input calibration. `held_out_gains`: with the
  // calibration of the other half. 0 if the calibration is not estimated.
  std::array<double, 2> half_gains = {0, 0}, held_out_gains = {0, 0};
  // `calibration_sigmas` standard deviations of a squared Mahalanobis distance. 0 if the initial
  // calibration differs from the input calibration.
  double gain_limit = 0;
  bool calibration_kept = false;  // the input calibration is kept
  // Covariance of each keyframe pose, 6 x 6, for the perturbation (w [rad], v [m]) in exp(w) R and
  // t + v. 0 for the first keyframe. Infinite diagonal for a keyframe without shared surfels. Empty
  // after any failure, also of the second refinement with the kept calibration.
  std::vector<Eigen::MatrixXd> pose_covariances;
  // Fit at the initial poses and at the final poses, each with its own surfels. `after` is 0 after
  // a failure.
  RefinementFit before, after;
  std::vector<RefinementRound> rounds;  // successful rounds of calibration, then of poses only

  // Returns whether the estimated calibration improves both halves by more than the limit, and
  // whether the sum of `held_out_gains` is above the limit.
  bool AreGainsAboveLimit() const;

  bool Succeeded() const {
    return termination == RefinementTermination::kConverged ||
           termination == RefinementTermination::kMaxRounds;
  }
};

// Refines the keyframe poses and the calibration parameters that `options` selects. Minimises
// the residuals of surfels that several keyframes observe:
//   minimise over poses, calibration and displacements d_s of the surfels
//     1/2 sum_(s, k) rho(r_sk^2),  r_sk the PlaneInverseDepth residual.
// With a photometric weight W > 0, textured surfels have two intensity differences as additional
// parameters. The sum then includes W/2 rho_I(|r_I|^2) with the SurfelTexture residuals r_I.
// Images are linearised again in each round.
//
// Surfel parameters are eliminated by the Schur complement, and Levenberg-Marquardt solves for
// poses and calibration. The first keyframe is fixed.
//
// If the estimated calibration does not differ significantly from `given`, `given` is kept. `given`
// is also kept if the keyframes do not confirm the estimate. The estimate must improve the first
// and the last half of the keyframes. The calibration of one half must also improve the other half:
// see RefinementSummary::AreGainsAboveLimit(). With a kept calibration, the poses are refined again
// from their initial values, with a motion prior between consecutive keyframes. The estimation of
// the calibration does not use this prior: tracking may have used a wrong calibration.
//
// `keyframes` must be in the order of time. `given`: input calibration, the mean of the prior.
// `start`: initial calibration, for example of tracking. Both must have the size of the keyframe
// images, which is not checked. The result is the same for any number of threads. `progress` must
// not be empty. It is called after each round, on the calling thread. Its exceptions are passed on,
// with the poses of the last round. Throws InputError for invalid options.
RefinementSummary Refine(const RefinementOptions& options, const DepthCalibration& given,
                         const DepthCalibration& start, std::vector<RefinementKeyframe>* keyframes,
                         const std::function<void(const RefinementRound&)>& progress);
// As above, with `given` as the initial calibration.
RefinementSummary Refine(const RefinementOptions& options, const DepthCalibration& given,
                         std::vector<RefinementKeyframe>* keyframes,
                         const std::function<void(const RefinementRound&)>& progress);

// Cross-validates a calibration in five folds of consecutive keyframes. Each fold is held out once.
// The calibration of the other folds, with the prior at `given`, is compared with `start`. Returns
// the decrease of the squared residuals of the held-out folds, in units of their variance. Folds
// without redundant observations do not count. `found` and the poses of `keyframes`: results of
// Refine() with the same options. Costs about five linearisations.
double HeldOutGain(const RefinementOptions& options, const DepthCalibration& given,
                   const DepthCalibration& start, const DepthCalibration& found,
                   const std::vector<RefinementKeyframe>& keyframes);

}  // namespace surfit
