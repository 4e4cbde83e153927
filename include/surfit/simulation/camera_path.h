#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "surfit/geometry/trajectory.h"
#include "surfit/simulation/scene.h"

namespace surfit {

class OptionVisitor;

// Options of a hand-held camera motion.
struct PathOptions {
  double frames_per_second = 30;
  // Bounds of the translation and rotation between consecutive frames, including the hand tremor.
  // Both vary slowly.
  double min_step_m = 0.010;
  double max_step_m = 0.020;
  double min_turn_deg = 0.5;
  double max_turn_deg = 1.5;

  void Visit(OptionVisitor& visitor);
};

// Generates a smooth hand-held camera path of world_from_camera poses (x right, y down, z forward).
// It leads through `scene.camera_space`, or repeatedly along `scene.route`. The camera looks at
// `scene.targets` with a level horizon, except for the hand tremor. It keeps a distance of 0.5 m
// from objects if the camera space allows it.
//
// Views with little structure are limited, as far as the targets allow it. One or two planes cover
// at least 80 % of the view in a quarter to a half of the frames, and more than 95 % in no frame.
// In a building, the quarter is not enforced.
//
// The same seed gives the same path. Throws InputError for invalid options and if `frames` < 1.
// Aborts if the scene has no camera space or fewer than two targets.
Trajectory MakePath(const Scene& scene, int frames, std::uint64_t seed,
                    const PathOptions& options = {});

// Interpolates poses with continuous accelerations: natural cubic splines through the positions and
// through the quaternions, which are then normalised. Extrapolates with constant velocity before
// the first and after the last pose.
class SmoothPath {
 public:
  // Aborts unless there is a pose and the timestamps increase.
  explicit SmoothPath(Trajectory poses);

  // Pose at a time. At the timestamp of a pose, that pose is bitwise identical.
  Rigid3d At(double stamp_s) const;

  const Trajectory& poses() const { return poses_; }

 private:
  using Knot = Eigen::Matrix<double, 7, 1>;  // position in metres, quaternion xyzw

  Trajectory poses_;
  std::vector<Knot> values_, second_derivatives_;
};

}  // namespace surfit
