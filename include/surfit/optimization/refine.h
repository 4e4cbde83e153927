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

// What is known of the given calibration, where that is not what the sensor says
// (RgbdCamera::prior).
struct PriorOptions {
  std::optional<double> focal_share, aspect_share, center_px, inverse_depth_sigma, readout_s;

  // The sensor's prior, but for what is given here.
  CalibrationPrior Over(CalibrationPrior sensor) const;
  // Gives what is not given yet, as the sensor has it.
  void Complete(const CalibrationPrior& sensor);

  void Visit(OptionVisitor& visitor);
};

// "reduced": normal equations of poses and calibration alone, the surfels' own numbers eliminated
// by hand; "ceres": a problem of Ceres with an autodiff residual block for each observation. Both
// minimise the same cost.
std::vector<std::string> RefinementSolverNames();
// How Ceres solves for poses and calibration: "sparse_schur", by a sparse factorisation
// (SuiteSparse's where Ceres has it), or "iterative_schur", by conjugate gradients.
std::vector<std::string> RefinementLinearSolverNames();

// How keyframes are refined.
struct RefinementOptions {
  // What of the calibration is found as well. Depth as a whole keeps its scale: nothing in a
  // sequence tells a small room from a large one.
  bool free_intrinsics = true;    // fx fy cx cy
  bool free_depth_offset = true;  // of inverse depth: c0 of InverseDepthField
  bool free_depth_field = true;   // its other coefficients
  bool free_readout = true;       // of a rolling shutter, where keyframes have a motion
  PriorOptions prior;             // what is not given: CalibrationPrior's defaults

  // A keyframe's image has so many columns of square cells; it has at most one surfel in each.
  int cells_across = 120;
  int min_observations = 3;              // a surfel that fewer keyframes see does not count
  double observation_distance_m = 0.05;  // between a surfel's plane and what a keyframe measures
  double observation_angle_rad = 0.6;    // between their normals
  double max_slant_rad = 1.2;            // of a surface to the ray that sees it
  // Of planes and, with its photometric weight (0 = off, the default), of textures: see Refine().
  ErrorModel error_model;

  // With a calibration that is right as given, the motion from each keyframe to the next counts
  // with these standard deviations: tracking has found it with all frames in between, and all their
  // pixels. 0 = it does not count.
  double motion_sigma_m = 0.0005;
  double motion_sigma_rad = 0.0005;
  // The given calibration is kept if the squared distance of the one that is found from it, by the
  // covariance of that, is not above its mean by more than so many of its standard deviations.
  double calibration_sigmas = 3;
  // What the model leaves out (steps of disparity, bent surfaces, depth that is wrong at edges)
  // shifts what is found, however many pixels agree: fx fy cx cy by about this share of the focal
  // length, depth by this share of 3 m, the readout by this share of a second. It is part of the
  // calibration's covariance.
  double model_error_share = 0.0005;
  // And with it, observation_angle_rad and the kernel's width are these shares of themselves: what
  // is left over of single pixels is about half a sigma. What bends, or is next to a surface, would
  // count as measured of it; a wrong calibration needs both wide, to be found.
  double kept_angle_share = 1. / 3;
  double kept_kernel_share = 0.5;

  // Of a round: one of RefinementSolverNames(), and of "ceres" one of
  // RefinementLinearSolverNames().
  std::string solver = "reduced";
  std::string linear_solver = "sparse_schur";

  int max_rounds = 15;      // of making surfels and moving all
  int max_iterations = 10;  // of Levenberg-Marquardt, in each round
  // And these end when one changes the cost by less than this share: far below the rounds', as some
  // directions hardly matter to the cost.
  double min_relative_step_change = 1e-6;
  // Rounds end when one lowers the cost of its observations by less than this share.
  double min_relative_cost_change = 1e-4;
  // The robust kernel's width is this many times its own in the first round, and half as many in
  // each further one, down to once: what is far apart at first may still be pulled together.
  double kernel_growth = 4;

  // Surfels nearer to each other than this share the errors of normals, which come from a window of
  // pixels: they count, in the covariance of the calibration, as if there were fewer.
  int correlation_px = 7;

  void Visit(OptionVisitor& visitor);
};

enum class RefinementTermination {
  kConverged,      // the cost no longer changes
  kMaxRounds,      // the rounds were used up
  kTooFewSurfels,  // failure: the keyframes do not share enough; nothing was moved
  kFailed,         // failure: the solver gave up; nothing was moved
};

// "converged", "max_rounds", "too_few_surfels", "failed".
std::string ToString(RefinementTermination termination);

// How well what the keyframes measure agrees: root mean squares of what is left over, with the
// weights of the robust kernel.
struct RefinementFit {
  double cost = 0;
  double rms_sigmas = 0;     // in standard deviations of the error model
  double rms_m = 0;          // from point to plane
  double rms_intensity = 0;  // of differences of intensity, from 0 to 1; 0 without any
};

// What one round did: it makes surfels and finds who sees them, and then moves all. The kernel is
// the round's.
struct RefinementRound {
  std::size_t surfels = 0, observations = 0;
  std::size_t texture_observations = 0;  // of two differences each; 0 without photometric weight
  RefinementFit before, after;           // of these observations
  int iterations = 0;
  DepthCalibration calibration;  // after it
};

// The outcome of a refinement.
struct RefinementSummary {
  RefinementTermination termination = RefinementTermination::kFailed;
  DepthCalibration calibration;  // as it was given where refinement failed, or where it is kept
  // Of fx fy cx cy [px], c0 .. c5 [1/m] and the readout [s], 11 x 11, zero of those that were held;
  // empty where refinement failed. From the size of what is left over in the end, the errors of
  // surfels that are correlation_px apart being independent, and from the error of the model.
  Eigen::MatrixXd calibration_covariance;
  // The squared distance, by this covariance, of the calibration that was found from the given one,
  // and beyond which the given one is not kept. Both 0 if nothing was free.
  double calibration_distance = 0, calibration_limit = 0;
  bool calibration_kept = false;  // then poses alone were refined anew, the motion counting
  // So, of each keyframe's pose, 6 x 6: of exp(w) R and t + v, (w [rad], v [m]). Zero of the first,
  // which is held; infinite on the diagonal where nothing ties a keyframe to others.
  std::vector<Eigen::MatrixXd> pose_covariances;
  RefinementFit before, after;          // of surfels made where all was, and where all is
  std::vector<RefinementRound> rounds;  // of both if poses were refined anew

  bool Succeeded() const {
    return termination == RefinementTermination::kConverged ||
           termination == RefinementTermination::kMaxRounds;
  }
};

// Moves the poses of the keyframes and, as the options say, the calibration, to where what the
// keyframes measure of the surfels that they share agrees best:
//   minimise over poses, calibration and displacements d_s of the surfels
//     1/2 sum_(s, k) rho(r_sk^2),  r_sk the PlaneInverseDepth residual.
// With a photometric weight W > 0 in the error model, textured surfels also have two differences of
// intensity as unknowns, and the sum has W/2 rho_I(|r_I|^2), r_I the SurfelTexture residuals, of
// keyframes that see the texture; images are expanded anew in each round.
// These numbers occur in the residuals of their own surfel only, and are eliminated in closed form
// (Schur complement): Levenberg-Marquardt sees poses and calibration alone, with a block for
// each pair of keyframes that share a surfel. The first keyframe's pose is held.
//
// If the calibration that is found is no other than the given one, as far as its covariance tells,
// the given one is kept, and the poses are refined with it from where they were. Then the given
// motion between keyframes counts, too (JointPrior): tracking with a wrong calibration would be
// wrong.
//
// The poses may have been tracked with another calibration than the given one, which the prior is
// about: `start`. The same input gives the same output at any number of threads. `progress` is
// called after each round.
RefinementSummary Refine(const RefinementOptions& options, const DepthCalibration& given,
                         const DepthCalibration& start, std::vector<RefinementKeyframe>* keyframes,
                         const std::function<void(const RefinementRound&)>& progress);
// From the given calibration.
RefinementSummary Refine(const RefinementOptions& options, const DepthCalibration& given,
                         std::vector<RefinementKeyframe>* keyframes,
                         const std::function<void(const RefinementRound&)>& progress);

}  // namespace surfit
