#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "registration/global/view_fit.h"
#include "surfit/registration/global_registration.h"
#include "surfit/registration/normal_system.h"

namespace surfit {

// Options of the joint alignment on one pyramid level.
struct DescentOptions {
  int max_steps = 10;
  double max_distance_m = 0.4;      // initial distance gate; times 0.85 per step
  double max_distance_end_m = 0.2;  // final distance gate
  bool use_brightness = true;
  int stride = 1;         // subsampling of source rows and columns
  double damping = 3e-3;  // relative to the information of a well constrained direction
};

// See DescentOptions for the members.
struct JointOptions {
  double max_distance_m = 0.4;
  bool use_brightness = true;
  int stride = 1;
};

// Normal equations of the point-to-plane and brightness residuals at a pose, for the left
// perturbation (w [rad], v [m]) in the target frame.
struct JointSystem {
  Matrix6d hessian = Matrix6d::Zero();
  Vector6d right_side = Vector6d::Zero();
  double weight = 0;               // sum of the weights of the point-to-plane residuals
  double weighted_square_sum = 0;  // sum of these weights times |p'|^2
  int pair_count = 0;

  // RMS of |p'|, m: length that converts rotations to arc lengths.
  double RmsDistance() const;
};

// Linearises both residuals for all projective correspondences. p' = R p + t is the source point,
// (q, n) is the surface at its target pixel, and I is the target brightness.
// - point-to-plane residual: n . (p' - q), row [p' x n, n]
// - brightness residual: I(p') - (a J + b), row [p' x d, d] with d = dI/dp'
// J is the source brightness. Gain a and offset b equalise mean and standard deviation (exposure).
// Both residuals have a Geman-McClure kernel.
JointSystem LinearizeJointly(const ViewLevel& source, const ViewLevel& target,
                             const JointOptions& options, const Rigid3d& target_from_source);

// Damped Gauss-Newton iterations from an initial pose target_from_source. Ends early after a small
// step, or with too few correspondences.
Rigid3d Descend(const ViewLevel& source, const ViewLevel& target, const Rigid3d& start,
                const DescentOptions& options);

struct CandidatePose {
  Rigid3d target_from_source;
  double score = 0;  // ViewFit::Score() on the level of the search
};

// Rotations of up to 60 degrees in ascending order of the angle. The rotation vectors form a
// body-centred cubic lattice. Every rotation of up to 49 degrees is within 11 degrees of a lattice
// point.
std::vector<Eigen::Quaterniond> RotationGrid();

// Largest angle from a rotation of up to 49 degrees to the grid, rad.
constexpr double kGridAngleRad = 11 * kRadPerDeg;

// Global search for the relative pose of two views, on the three coarsest levels of both pyramids.
// All levels are subsampled to the number of points of the coarsest level. Points of finer levels
// are more accurate, and a larger number of points would not change the result.
class InitialPoseSearch {
 public:
  // Keeps references: both views must outlive this object. Each pyramid needs at least one level.
  // Aborts if a colour image does not have the size of the finest level. Const functions are
  // thread-safe.
  InitialPoseSearch(const ColoredView& source, const ColoredView& target,
                    const ErrorModel& error_model);

  // Up to 8 distinct poses within `bound`, in descending order of their scores. Not empty without a
  // bound.
  std::vector<CandidatePose> FindPoses(const MotionBound& bound = {}) const;

  // Finest of the three levels.
  ViewLevel SourceLevel() const { return Source(kFine); }
  ViewLevel TargetLevel() const { return Target(kFine); }

 private:
  enum Stage { kCoarse, kMiddle, kFine };

  int LevelOf(Stage stage) const;
  int StrideOf(Stage stage) const;
  ViewLevel Source(Stage stage) const;
  ViewLevel Target(Stage stage) const;
  double Score(Stage stage, const Rigid3d& pose, int stride = 1) const;
  std::vector<CandidatePose> FromFeatures() const;
  std::vector<CandidatePose> FromRotations(const MotionBound& bound) const;
  std::vector<CandidatePose> AlongWeakestDirection(const Rigid3d& pose,
                                                   const MotionBound& bound) const;
  CandidatePose Improve(const CandidatePose& start) const;

  const ColoredView& source_;
  const ColoredView& target_;
  ErrorModel error_model_;
  int levels_;
  std::vector<BrightnessLevel> source_brightness_;
  std::vector<BrightnessLevel> target_brightness_;
};

}  // namespace surfit
