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

// Uniqueness of an alignment.
enum class AlignmentStatus {
  kAligned,
  // The points of one set are collinear or coincide, or the best fit is a reflection with several
  // nearest rotations. Other rotations have the same residuals. The transform is one of the
  // minimisers.
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
// rotation, even if a reflection fits better. Throws if the sizes differ, or if one of at least 3
// points is not finite.
Alignment AlignPoints(const std::vector<Eigen::Vector3d>& source,
                      const std::vector<Eigen::Vector3d>& target);

// Options of the association of estimated poses with ground truth.
struct MatchOptions {
  // Maximum time difference to the nearest ground-truth pose, if no pose is interpolated, s.
  // Default of evo; the TUM scripts use 0.02.
  double max_difference_s = 0.01;
  // Maximum interval of ground-truth poses for interpolation, s. 0: nearest pose, as in evo
  // and the TUM scripts. Interpolation is linear for translations and slerp for rotations. At
  // an acceleration a, its error is at most a max_gap_s^2 / 8: 1 mm at 3 m/s^2.
  double max_gap_s = 0.05;

  void Visit(OptionVisitor& visitor);
};

// Estimated pose and ground-truth pose of the same time, both world_from_camera. The world
// frames may differ.
struct MatchedPose {
  double stamp_s = 0;  // time of the estimated pose
  Rigid3d ground_truth;
  Rigid3d estimate;
};

// Associates estimated poses with ground truth by InterpolatePose(), in the order of the estimate.
// Estimated poses without ground truth at their time are omitted. Ground truth must be ascending.
// Several estimated poses can match one ground-truth pose, unlike in the TUM scripts. Throws
// InputError for invalid options.
std::vector<MatchedPose> MatchPoses(const Trajectory& ground_truth, const Trajectory& estimate,
                                    const MatchOptions& options);

// Times of the poses, s.
std::vector<double> Stamps(const Trajectory& trajectory);

// Absolute trajectory error (ATE): distances of the camera centres after rigid alignment of the
// trajectories (Sturm et al., IROS 2012, eq. 3-4).
struct AbsoluteTrajectoryError {
  Alignment alignment;  // target: world of the ground truth; source: world of the estimate
  ErrorStatistics translation_m;  // |true centre - aligned centre|
};

// Computes the ATE. Returns std::nullopt for fewer than 3 poses. On a straight path, the
// rotation of the alignment is not unique, but the error is. Throws if a position is not finite.
std::optional<AbsoluteTrajectoryError> ComputeAbsoluteTrajectoryError(
    const std::vector<MatchedPose>& poses);

// Translation norm and rotation angle of truth^-1 * estimated.
struct PoseError {
  double translation_m = 0;
  double rotation_deg = 0;
};

// Error of a pose. `estimated` and `truth` map the camera to the same frame.
PoseError ErrorOf(const Rigid3d& estimated, const Rigid3d& truth);

// Interval of the relative pose error.
struct RelativePoseErrorOptions {
  enum class Unit {
    // `delta` is a number of matched poses, as in evo and the TUM scripts. Frames without a match
    // are not included.
    kFrames,
    // `delta` is a time in s. The pair of pose i is the pose nearest to the time of i plus `delta`.
    // A time difference above 10 % of `delta` gives no pair.
    kSeconds,
  };
  double delta = 1;  // positive; an integer below 1e9 for kFrames
  Unit delta_unit = Unit::kFrames;

  void Visit(OptionVisitor& visitor);
};

// Relative pose error (RPE): drift over a fixed interval, for all pairs of poses i and j at this
// interval. With the estimate P and the ground truth Q, E = (Q_i^-1 Q_j)^-1 (P_i^-1 P_j) (Sturm et
// al., IROS 2012, eq. 1; --all_pairs of evo). The TUM script inverts the relative poses: its
// translation error differs by up to the rotation error (rad) times the relative translation.
struct RelativePoseError {
  ErrorStatistics translation_m;  // norm of the translation of E
  ErrorStatistics rotation_deg;   // rotation angle of E
};

// Computes the RPE. For kSeconds, `poses` must be ordered by time, which is not checked. Returns
// std::nullopt without a pair of poses at the interval `delta`. Throws InputError for invalid
// options.
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
  int expected = 0;  // number of frames with ground truth, including lost frames
  int matched = 0;   // number of estimated poses with ground truth
  // matched / expected, at most 1; 0 without expected frames. The errors are not
  // representative if the coverage is low.
  double coverage = 0;
  std::optional<AbsoluteTrajectoryError> ate;
  std::optional<RelativePoseError> rpe;
};

// Computes coverage, ATE and RPE. Both trajectories must be ordered by time. `frame_stamps_s`:
// capture times of all frames of the recording, including lost frames. ATE and RPE are std::nullopt
// as in their functions. Throws if an estimated position is not finite. Throws InputError for
// invalid options.
TrajectoryEvaluation EvaluateTrajectory(const Trajectory& ground_truth, const Trajectory& estimate,
                                        const std::vector<double>& frame_stamps_s,
                                        const TrajectoryEvaluationOptions& options);

// Returns the trajectory with `by_s` (s) added to its times.
Trajectory WithTimeOffset(Trajectory trajectory, double by_s);

// Time offset between estimate and ground truth, with its ATE.
struct TimeOffset {
  double offset_s = 0;  // added to the times of the estimate
  AbsoluteTrajectoryError ate;
};

// Computes the ATE with a time offset. Returns std::nullopt if fewer than 3 poses match. Throws
// InputError for invalid options.
std::optional<TimeOffset> EvaluateTimeOffset(const Trajectory& ground_truth,
                                             const Trajectory& estimate, double offset_s,
                                             const MatchOptions& options);

// Estimates the time offset within +-0.1 s that minimises the ATE. The offset can also
// compensate tracking errors: report this ATE in addition to the plain ATE, not instead of it.
// The search tests a grid of 5 ms, and then refines the best offset to 0.01 ms. It uses only poses
// that have ground truth at all offsets of the grid. The returned ATE uses all matched poses.
// Returns std::nullopt for fewer than 3 poses in the search. Throws InputError for invalid options.
std::optional<TimeOffset> EstimateTimeOffset(const Trajectory& ground_truth,
                                             const Trajectory& estimate,
                                             const MatchOptions& options);

// Fitted lever arm between the estimated body and the body of the ground truth, for example a
// marker.
struct MountFit {
  Eigen::Vector3d true_body_in_estimated_m = Eigen::Vector3d::Zero();  // m, see FitMount()
  double scale = 1;  // true metres per estimated metre; 1 if not fitted
  // False: a parameter is not observable on this path. The fit starts at m = 0 and s = 1, and does
  // not move along unobservable directions.
  bool is_unique = true;
  AbsoluteTrajectoryError ate;  // residuals of the fit; alignment: R, t, always kAligned
};

// Fits the lever arm m. Minimises sum |q_i - R (s p_i + R_i m) - t|^2 over R, t, m and, with
// `fit_scale`, the scale s. The estimate has positions p_i and rotations R_i. The ground truth has
// positions q_i. Its rotations are not used. Returns std::nullopt for fewer than 3 poses. Throws if
// a position is not finite.
std::optional<MountFit> FitMount(const std::vector<MatchedPose>& poses, bool fit_scale);

// Warning text if the lever arm is longer than 5 cm or the fit is not unique. Empty otherwise.
std::string MountWarning(const MountFit& fit);

}  // namespace surfit
