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
  // The points lie on a line or coincide: other rotations give the same residuals.
  kRotationNotUnique,
  // Fewer than 3 points; the transform is the identity.
  kTooFewPoints,
};

// Rigid transform between two sets of points.
struct Alignment {
  AlignmentStatus status = AlignmentStatus::kTooFewPoints;
  Rigid3d target_from_source;
};

// Computes the rigid transform without scale that minimises sum |target_i - (R source_i + t)|^2
// (Horn 1987; Umeyama, PAMI 1991, eq. 39-43 with c = 1). Points are in metres. R is a proper
// rotation, even if a reflection fits better. Aborts if the sizes differ or a point is not finite.
Alignment AlignPoints(const std::vector<Eigen::Vector3d>& source,
                      const std::vector<Eigen::Vector3d>& target);

// Options of the association of estimated poses with ground truth.
struct MatchOptions {
  // Largest time to the nearest ground-truth pose, if no pose is interpolated. Default of evo; the
  // TUM scripts use 0.02.
  double max_difference_s = 0.01;
  // Ground truth is interpolated between poses at most this far apart: translation linearly,
  // rotation along the shortest arc. At an acceleration a, the error is at most a max_gap_s^2 / 8:
  // 1 mm at 3 m/s^2. The nearest pose of motion capture at 100 Hz is up to 5 ms away and has this
  // error at 0.2 m/s. 0: the nearest pose, as in evo and the TUM scripts.
  double max_gap_s = 0.05;

  void Visit(OptionVisitor& visitor);
};

// Estimated pose with the ground-truth pose of the same time. Both are world-from-camera, each in
// its own world frame.
struct MatchedPose {
  double stamp_s = 0;  // timestamp of the estimate
  Rigid3d ground_truth;
  Rigid3d estimate;
};

// Estimated poses that have ground truth at their timestamps, by time. At a timestamp of the ground
// truth, the ground-truth pose is returned bitwise identical. Throws InputError for invalid
// options.
std::vector<MatchedPose> MatchPoses(const Trajectory& ground_truth, const Trajectory& estimate,
                                    const MatchOptions& options);

// Timestamps of the poses, s.
std::vector<double> Stamps(const Trajectory& trajectory);

// Absolute trajectory error (ATE): distances of the camera centres after rigid alignment of the
// whole estimate (Sturm et al., IROS 2012, eq. 3-4).
struct AbsoluteTrajectoryError {
  Alignment alignment;  // target: world of the ground truth; source: world of the estimate
  ErrorStatistics translation_m;  // |true centre - aligned centre|
};

// Returns std::nullopt for fewer than 3 poses. On a straight path the rotation is not unique, but
// the error is.
std::optional<AbsoluteTrajectoryError> ComputeAbsoluteTrajectoryError(
    const std::vector<MatchedPose>& poses);

// Difference of two rigid transforms: norm of the translation and angle of the rotation of truth^-1
// * estimated.
struct PoseError {
  double translation_m = 0;
  double rotation_deg = 0;
};

PoseError ErrorOf(const Rigid3d& estimated, const Rigid3d& truth);

// Interval of the relative pose error.
struct RelativePoseErrorOptions {
  enum class Unit {
    kFrames,   // `delta` is a number of matched poses, as in evo and the TUM scripts; lost frames
               // are not counted
    kSeconds,  // `delta` is a time; the nearest pose may deviate by a tenth of `delta`
  };
  double delta = 1;
  Unit delta_unit = Unit::kFrames;

  void Visit(OptionVisitor& visitor);
};

// Relative pose error (RPE): drift over a fixed interval. With the estimate P, the ground truth Q,
// and every pair of poses i and j: E = (Q_i^-1 Q_j)^-1 (P_i^-1 P_j) (Sturm et al., IROS 2012, eq.
// 1; --all_pairs of evo). The TUM script inverts the relative poses: its rotation error is equal,
// and its translation error differs in second order.
struct RelativePoseError {
  ErrorStatistics translation_m;  // norm of the translation of E
  ErrorStatistics rotation_deg;   // rotation angle of E
};

// Returns std::nullopt if no pair of poses is `delta` apart. Throws InputError for invalid options.
std::optional<RelativePoseError> ComputeRelativePoseError(const std::vector<MatchedPose>& poses,
                                                          const RelativePoseErrorOptions& options);

// Options of EvaluateTrajectory().
struct TrajectoryEvaluationOptions {
  MatchOptions match;
  RelativePoseErrorOptions rpe;

  void Visit(OptionVisitor& visitor);
};

// Errors of a trajectory.
struct TrajectoryEvaluation {
  int expected = 0;  // frames that have ground truth
  int matched = 0;   // estimated poses that have ground truth
  // matched / expected, at most 1; 0 without expected frames. Errors are not representative at a
  // low coverage.
  double coverage = 0;
  std::optional<AbsoluteTrajectoryError> ate;
  std::optional<RelativePoseError> rpe;
};

// Computes coverage, ATE and RPE. `frame_stamps_s` are the ascending timestamps of all frames that
// should have an estimated pose. Throws InputError for invalid options.
TrajectoryEvaluation EvaluateTrajectory(const Trajectory& ground_truth, const Trajectory& estimate,
                                        const std::vector<double>& frame_stamps_s,
                                        const TrajectoryEvaluationOptions& options);

// Returns the trajectory with `by_s` added to its timestamps.
Trajectory WithTimeOffset(Trajectory trajectory, double by_s);

// Time offset between estimate and ground truth, with its ATE.
struct TimeOffset {
  double offset_s = 0;  // added to the timestamps of the estimate
  AbsoluteTrajectoryError ate;
};

// ATE with a given time offset. Returns std::nullopt if fewer than 3 poses match. Throws InputError
// for invalid options.
std::optional<TimeOffset> EvaluateTimeOffset(const Trajectory& ground_truth,
                                             const Trajectory& estimate, double offset_s,
                                             const MatchOptions& options);

// Estimates the time offset within +-0.1 s that minimises the ATE. The offset also removes errors
// of the estimate that resemble an offset: report its ATE in addition to the plain ATE, never
// instead of it. Poses without ground truth at one of the tested offsets are not used. Returns
// std::nullopt for fewer than 3 remaining poses. Throws InputError for invalid options.
std::optional<TimeOffset> EstimateTimeOffset(const Trajectory& ground_truth,
                                             const Trajectory& estimate,
                                             const MatchOptions& options);

// Fit of a constant offset between two bodies. The ground truth describes another body than the
// estimate, for example a marker or a colour camera.
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
