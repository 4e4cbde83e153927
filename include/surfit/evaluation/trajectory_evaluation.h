#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "surfit/evaluation/error_statistics.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/geometry/trajectory.h"

namespace surfit {

class OptionVisitor;

enum class AlignmentStatus {
  kAligned,
  // The points lie on a line or in one spot: other rotations fit as well, with the same residuals.
  kRotationNotUnique,
  // Fewer than 3 points; the transform is the identity.
  kTooFewPoints,
};

// A rigid transform between two sets of points.
struct Alignment {
  AlignmentStatus status = AlignmentStatus::kTooFewPoints;
  Rigid3d target_from_source;
};

// The rigid transform, without scale, that minimises sum |target_i - (R source_i + t)|^2 over
// pairs of points in metres (Horn 1987; Umeyama, PAMI 1991, eq. 39-43 with c = 1). R is a proper
// rotation also where a reflection would fit better.
Alignment AlignPoints(const std::vector<Eigen::Vector3d>& source,
                      const std::vector<Eigen::Vector3d>& target);

// What the ground truth knows of a moment.
struct MatchOptions {
  // Where its stamps are further apart, its nearest pose is taken if it is at most this far: evo's
  // default; the TUM scripts use 0.02.
  double max_difference_s = 0.01;
  // Between two true poses at most this far apart, the pose is interpolated: translation linear,
  // rotation along the shortest arc. At an acceleration a that misses by a max_gap_s^2 / 8 at most,
  // 1 mm at 3 m/s^2; the nearest pose of motion capture at 100 Hz, up to 5 ms away, misses by as
  // much at 0.2 m/s. 0: always the nearest, as evo and the TUM scripts do.
  double max_gap_s = 0.05;

  void Visit(OptionVisitor& visitor);
};

// What the ground truth and the estimate say of the same moment, each in its own world.
struct MatchedPose {
  double stamp_s = 0;  // the estimate's
  Rigid3d ground_truth;
  Rigid3d estimate;
};

// The poses of the estimate at whose stamps the ground truth knows one, in order of time. At a true
// stamp that is the true pose itself, bit for bit.
std::vector<MatchedPose> MatchPoses(const Trajectory& ground_truth, const Trajectory& estimate,
                                    const MatchOptions& options);

std::vector<double> Stamps(const Trajectory& trajectory);

// How far the estimated camera centres are from the true ones, once the estimate as a whole is
// placed as well as a rigid motion can (Sturm et al., IROS 2012, eq. 3-4).
struct AbsoluteTrajectoryError {
  Alignment alignment;            // target: the ground truth's world, source: the estimate's
  ErrorStatistics translation_m;  // of |true centre - aligned centre|
};

// Nothing if fewer than 3 poses match. On a straight path the rotation is not unique, the error is.
std::optional<AbsoluteTrajectoryError> ComputeAbsoluteTrajectoryError(
    const std::vector<MatchedPose>& poses);

// How far an estimated motion is from the true one.
struct PoseError {
  double translation_m = 0;
  double rotation_deg = 0;
};

PoseError ErrorOf(const Rigid3d& estimated, const Rigid3d& truth);

// The interval over which drift is measured.
struct RelativePoseErrorOptions {
  enum class Unit {
    kFrames,  // delta counts matched poses, as in evo and the TUM scripts: lost frames are no steps
    kSeconds,  // the pose whose stamp is nearest to delta later, if off by at most a tenth of delta
  };
  double delta = 1;
  Unit delta_unit = Unit::kFrames;

  void Visit(OptionVisitor& visitor);
};

// Drift over a fixed interval. With P the estimate and Q the ground truth, for every pose i and
// its partner j: E = (Q_i^-1 Q_j)^-1 (P_i^-1 P_j) (Sturm et al., IROS 2012, eq. 1; evo's
// --all_pairs). The TUM script takes the relative poses the other way round, j to i: the same
// rotation, and a translation that differs in second order.
struct RelativePoseError {
  ErrorStatistics translation_m;  // of the length of E's translation
  ErrorStatistics rotation_deg;   // of the angle of E's rotation
};

// Nothing if no two poses are delta apart.
std::optional<RelativePoseError> ComputeRelativePoseError(const std::vector<MatchedPose>& poses,
                                                          const RelativePoseErrorOptions& options);

// How a trajectory is compared with the ground truth.
struct TrajectoryEvaluationOptions {
  MatchOptions match;
  RelativePoseErrorOptions rpe;

  void Visit(OptionVisitor& visitor);
};

// What is said of an estimated trajectory.
struct TrajectoryEvaluation {
  int expected = 0;  // frames that should have a pose: those that the ground truth knows
  int matched = 0;   // poses of the estimate that the ground truth knows
  // matched / expected, at most 1; 0 if nothing is expected. An error over few poses says little.
  double coverage = 0;
  std::optional<AbsoluteTrajectoryError> ate;
  std::optional<RelativePoseError> rpe;
};

// All that is said of an estimated trajectory. frame_stamps_s are the stamps of all frames that the
// estimate was to have a pose for, ascending.
// Throws InputError if the options are not valid.
TrajectoryEvaluation EvaluateTrajectory(const Trajectory& ground_truth, const Trajectory& estimate,
                                        const std::vector<double>& frame_stamps_s,
                                        const TrajectoryEvaluationOptions& options);

// The trajectory with its stamps moved by so much.
Trajectory WithStampsMoved(Trajectory trajectory, double by_s);

// A difference of the clocks of estimate and ground truth.
struct TimeOffset {
  double offset_s = 0;  // to be added to the estimate's stamps
  AbsoluteTrajectoryError ate;
};

// The error of the estimate with an offset that is given. Nothing if fewer than 3 poses match.
std::optional<TimeOffset> EvaluateTimeOffset(const Trajectory& ground_truth,
                                             const Trajectory& estimate, double offset_s,
                                             const MatchOptions& options);

// The offset within 0.1 s either way at which the absolute error is least: what the error would be
// if the clocks were set by the ground truth. It takes out errors of the estimate, too, that look
// like an offset: to be told beside the plain error, never instead of it. Nothing if fewer than 3
// poses match at each offset.
std::optional<TimeOffset> EstimateTimeOffset(const Trajectory& ground_truth,
                                             const Trajectory& estimate,
                                             const MatchOptions& options);

// Fit of a constant offset between two bodies: the ground truth describes another body than the
// estimate, for example a marker or a colour camera beside the depth camera.
struct MountFit {
  Eigen::Vector3d true_body_in_estimated_m = Eigen::Vector3d::Zero();  // in the estimate's body
  double scale = 1;             // true metres per estimated metre; 1 if it is not fitted
  bool is_unique = true;        // false: the path does not determine all parameters
  AbsoluteTrajectoryError ate;  // of the true body's positions
};

// Minimises sum |q_i - R (s p_i + R_i m) - t|^2 over R, t, the offset m and optionally the scale s.
// The estimate has position p_i and rotation R_i, the ground truth has position q_i. The rotations
// of the ground truth are not used. Returns std::nullopt for fewer than 3 poses.
std::optional<MountFit> FitMount(const std::vector<MatchedPose>& poses, bool fit_scale);

// Warning if the offset is longer than 5 cm, or is not unique. Else empty.
std::string MountWarning(const MountFit& fit);

}  // namespace surfit
