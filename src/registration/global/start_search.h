#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "registration/global/view_fit.h"
#include "surfit/registration/far_registration.h"
#include "surfit/registration/normal_system.h"

namespace surfit {

// How a pose descends on one pyramid level.
struct DescentOptions {
  int max_steps = 10;
  double max_distance_m = 0.4;      // points farther apart are no pairs; shrinks by 0.85 a step ...
  double max_distance_end_m = 0.2;  // ... down to this
  bool use_brightness = true;
  bool rotation_only = false;
  int stride = 1;         // of the source's columns and rows every n-th is taken
  double damping = 3e-3;  // of a direction that the pairs do not hold, as a share of one they do
};

// Which pairs of points, and which of their residuals.
struct JointOptions {
  double max_distance_m = 0.4;
  bool use_brightness = true;
  int stride = 1;
};

// The normal equations of both residuals of the pairs at a pose.
struct JointSystem {
  Matrix6d hessian = Matrix6d::Zero();
  Vector6d right_side = Vector6d::Zero();
  double weight = 0;               // sum of the weights of the point-to-plane residuals
  double weighted_square_sum = 0;  // sum of these weights times |p'|^2
  int pair_count = 0;

  // Measuring rotations as arc lengths at this distance, metres.
  double RmsDistance() const;
};

// For each pair of points that land on each other, p' = R p + t with the surface (q, n) and the
// target's brightness I at its pixel: the point-to-plane residual n . (p' - q), row [p' x n, n],
// and the brightness residual I(p') - (a J + b), row [p' x d, d] with d = dI/dp'. J is the source's
// brightness, a and b match the means and standard deviations of both (exposure). Both residuals
// have a Geman-McClure kernel.
JointSystem LinearizeJointly(const ViewLevel& source, const ViewLevel& target,
                             const JointOptions& options, const Rigid3d& target_from_source);

// Gauss-Newton steps from a start.
Rigid3d Descend(const ViewLevel& source, const ViewLevel& target, const Rigid3d& start,
                const DescentOptions& options);

// A pose that registration may start from.
struct StartPose {
  Rigid3d target_from_source;
  double score = 0;  // ViewFit::Score() on the level where it was found
};

// Rotations of up to 60 degrees, the nearest to none first: their rotation vectors are a
// body-centred cubic lattice, at most 11 degrees from any rotation in between.
std::vector<Eigen::Quaterniond> RotationGrid();

// Searches for the pose of one view in another's frame on the three coarsest levels of both. Of the
// finer ones as many points are looked at as the coarsest has: their places are more exact, and
// more of them would hardly change where a descent ends.
class StartSearch {
 public:
  // Keeps references: both views must outlive this object. Each has one level at least.
  StartSearch(const ColoredView& source, const ColoredView& target, const ErrorModel& error_model);

  // The rotation about the camera's centre that makes the coarsest images most alike.
  Rigid3d FindRotation() const;

  // Different poses, the best first.
  std::vector<StartPose> FindPoses() const;

  // The finest of the three levels.
  ViewLevel SourceLevel() const { return Source(kFine); }
  ViewLevel TargetLevel() const { return Target(kFine); }

 private:
  enum Stage { kCoarse, kMiddle, kFine };

  int LevelOf(Stage stage) const;
  int StrideOf(Stage stage) const;
  ViewLevel Source(Stage stage) const;
  ViewLevel Target(Stage stage) const;
  double Score(Stage stage, const Rigid3d& pose, int stride = 1) const;
  std::vector<StartPose> FromFeatures() const;
  std::vector<StartPose> FromRotations() const;
  std::vector<StartPose> AlongWeakestDirection(const Rigid3d& pose) const;
  StartPose Improve(const StartPose& start) const;

  const ColoredView& source_;
  const ColoredView& target_;
  ErrorModel error_model_;
  int levels_;
  std::vector<BrightnessLevel> source_brightness_;
  std::vector<BrightnessLevel> target_brightness_;
};

}  // namespace surfit
