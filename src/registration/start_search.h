#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "registration/view_fit.h"
#include "surfit/registration/far_registration.h"

namespace surfit {

// A pose that registration may start from.
struct StartPose {
  Rigid3d target_from_source;
  double score = 0;  // ViewFit::Score() on the level where it was found
};

// Rotations of up to 60 degrees, the nearest to none first: their rotation vectors are a
// body-centred cubic lattice, at most 11 degrees from any rotation in between.
std::vector<Eigen::Quaterniond> RotationGrid();

// Searches for the pose of one view in another's frame on the three coarsest levels of both.
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
  ViewLevel Source(Stage stage) const;
  ViewLevel Target(Stage stage) const;
  double Score(Stage stage, const Rigid3d& pose) const;
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
