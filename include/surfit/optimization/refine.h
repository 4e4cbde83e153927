#pragma once

#include <Eigen/Core>
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

// Overrides of the prior of the input calibration. Empty members keep the value of the sensor
// (RgbdCamera::prior).
struct PriorOptions {
  std::optional<double> focal_relative_sigma, aspect_relative_sigma, center_px, inverse_depth_sigma,
      readout_s;

  // Returns the prior of the sensor with these overrides.
  CalibrationPrior Over(CalibrationPrior sensor) const;
  // Sets the empty members to the values of the sensor.
  void Complete(const CalibrationPrior& sensor);

  void Visit(OptionVisitor& visitor);
};

// Solvers of a round, with the same cost:
// - "reduced": normal equations of poses and calibration, with the surfel parameters eliminated by
//   the Schur complement
// - "ceres": a ceres::Problem with one autodiff residual block per observation
std::vector<std::string> RefinementSolverNames();
// Linear solvers of "ceres": "sparse_schur" (sparse factorisation, SuiteSparse if Ceres has it) or
// "iterative_schur" (conjugate gradients).
std::vector<std::string> RefinementLinearSolverNames();

// Options of the joint refinement of keyframe poses and calibration.
struct RefinementOptions {
  // Calibration parameters to estimate. The overall scale of depth is fixed, because it is not
  // observable.
  bool estimate_intrinsics = true;    // fx fy cx cy
  bool estimate_depth_offset = true;  // c0 of InverseDepthField
  bool estimate_depth_field = true;   // other coefficients of InverseDepthField
  bool estimate_readout = true;       // rolling-shutter readout; only if a keyframe has motion
  PriorOptions prior;                 // default: CalibrationPrior

  // Number of columns of square cells of a keyframe image. Each cell has at most one surfel.
  int cells_across = 120;
  int min_observations = 3;  // minimum number of keyframes that observe a surfel
  // Maximum distance of a measured point from the surfel plane.
  double observation_distance_m = 0.05;
  double observation_angle_rad = 0.6;  // maximum angle between the normals
  double max_slant_rad = 1.2;  // maximum angle between the surface normal and the viewing ray
  // Error model of the plane residuals. With a photometric weight (0: off, the default), texture
  // residuals are added: see Refine().
  ErrorModel error_model;

  // Standard deviations of the motion prior between consecutive keyframes. The prior is used only
  // if the input calibration is kept. Tracking has estimated this motion from all frames in
  // between. If one is 0: no motion prior.
  double motion_sigma_m = 0.0005;
  double motion_sigma_rad = 0.0005;
  // Keeps the input calibration unless the estimate differs significantly. The squared Mahalanobis
  // distance must exceed its mean by more than this many of its standard deviations.
  double calibration_sigmas = 3;
  // Relative systematic error of the model (disparity steps, curved surfaces, depth edges). It does
  // not decrease with the number of pixels. It adds standard deviations to the covariance of the
  // calibration. They are this ratio of the focal length (fx fy cx cy), of 1 / (3 m) (inverse
  // depth) and of 1 s (readout).
  double model_error_ratio = 0.0005;
  // Factors of `observation_angle_rad` and of the kernel width if the input calibration is kept.
  // Residuals of single pixels are then about half a sigma, and wider gates would accept points of
  // curved or neighbouring surfaces. The estimation of a wrong calibration needs wide gates.
  double kept_angle_ratio = 1. / 3;
  double kept_kernel_ratio = 0.5;

  // One of RefinementSolverNames(), and for "ceres" one of RefinementLinearSolverNames().
  std::string solver = "reduced";
  std::string linear_solver = "sparse_schur";

  int max_rounds = 15;      // maximum number of rounds: create surfels, then solve
  int max_iterations = 10;  // maximum number of Levenberg-Marquardt iterations per round
  // Iterations end if the relative change of the cost is at most this. It is far below the
  // threshold of the rounds, because the cost hardly depends on some directions.
  double min_relative_step_change = 1e-6;
  // Rounds end if the relative decrease of the cost is below this.
  double min_relative_cost_change = 1e-4;
  // Factor of the kernel width in the first round, halved in each round until it is 1. Allows a
  // larger initial error.
  double kernel_growth = 4;

  // Distance within which surfels share the errors of their normals, which use a window of pixels.
  // In the covariance of the calibration, these surfels count as fewer observations.
  int correlation_px = 7;

  void Visit(OptionVisitor& visitor);
};

enum class RefinementTermination {
  kConverged,      // relative decrease of the cost below the threshold
  kMaxRounds,      // last poses and calibration
  kTooFewSurfels,  // failure: too few shared surfels; poses are unchanged
  kFailed,         // solver failure; poses are unchanged
};

// "converged", "max_rounds", "too_few_surfels", "failed".
std::string ToString(RefinementTermination termination);

// Final residuals: root mean squares, weighted by the robust kernel.
struct RefinementFit {
  double cost = 0;
  double rms_sigmas = 0;     // in standard deviations of the error model
  double rms_m = 0;          // point-to-plane distance
  double rms_intensity = 0;  // difference of intensity, in [0, 1]; 0 without texture
};

// Statistics of one round, which creates surfels with their observations and then solves. Fits are
// computed with the kernel of the round.
struct RefinementRound {
  std::size_t surfels = 0, observations = 0;
  std::size_t texture_observations = 0;  // of two differences each; 0 without photometric weight
  RefinementFit before, after;           // fit of these observations
  int iterations = 0;
  DepthCalibration calibration;  // after the round
};

// Result of Refine().
struct RefinementSummary {
  RefinementTermination termination = RefinementTermination::kFailed;
  // Estimated calibration. It is `given` if the input calibration is kept or only poses are
  // refined, and `start` after a failed estimation.
  DepthCalibration calibration;
  // Covariance of fx fy cx cy [px], c0 .. c5 [1/m] and the readout [s], 11 x 11. 0 for fixed
  // parameters, empty after a failure. It is scaled by the final residuals, where surfels at a
  // distance of `correlation_px` have independent errors. It includes the error of the model.
  Eigen::MatrixXd calibration_covariance;
  // Squared Mahalanobis distance of the estimated calibration from the input calibration, and its
  // upper limit for keeping the input calibration. Both are 0 if the calibration is not estimated.
  double calibration_distance = 0, calibration_limit = 0;
  bool calibration_kept = false;  // the input calibration is kept, and only poses are refined
  // Covariance of each keyframe pose, 6 x 6, of (w [rad], v [m]) in exp(w) R and t + v. 0 for the
  // first keyframe, which is fixed. Infinite on the diagonal for a keyframe without shared surfels.
  // Empty after a failure.
  std::vector<Eigen::MatrixXd> pose_covariances;
  // Fit with surfels of the initial poses, and fit with surfels of the final poses. `after` is 0
  // after a failure.
  RefinementFit before, after;
  std::vector<RefinementRound> rounds;  // all rounds, including the rounds of a second refinement

  bool Succeeded() const {
    return termination == RefinementTermination::kConverged ||
           termination == RefinementTermination::kMaxRounds;
  }
};

// Refines the keyframe poses and, by the options, the calibration. Minimises the residuals of
// shared surfels:
//   minimise over poses, calibration and displacements d_s of the surfels
//     1/2 sum_(s, k) rho(r_sk^2),  r_sk the PlaneInverseDepth residual.
// With a photometric weight W > 0 in the error model, textured surfels have two differences of
// intensity as additional parameters. The sum then includes W/2 rho_I(|r_I|^2) with the
// SurfelTexture residuals r_I of keyframes that see the texture. Images are linearised again in
// each round.
//
// The parameters of a surfel occur only in the residuals of this surfel, and are eliminated in
// closed form (Schur complement). Levenberg-Marquardt solves for poses and calibration only, with
// one block per pair of keyframes that share a surfel. The first keyframe is fixed.
//
// If the estimated calibration does not differ significantly from the input calibration, the input
// calibration is kept. The poses are then refined again from their initial values, with a motion
// prior between consecutive keyframes. The estimation of the calibration does not use this prior,
// because it comes from tracking with a possibly wrong calibration.
//
// The prior of the calibration refers to `given`. The poses were tracked with `start`. The result
// is the same for any number of threads. `progress` is called after each round, on the calling
// thread. Throws InputError for invalid options. Fewer than 2 keyframes are a failure,
// kTooFewSurfels.
RefinementSummary Refine(const RefinementOptions& options, const DepthCalibration& given,
                         const DepthCalibration& start, std::vector<RefinementKeyframe>* keyframes,
                         const std::function<void(const RefinementRound&)>& progress);
// Refines with `given` as the initial calibration.
RefinementSummary Refine(const RefinementOptions& options, const DepthCalibration& given,
                         std::vector<RefinementKeyframe>* keyframes,
                         const std::function<void(const RefinementRound&)>& progress);

}  // namespace surfit
