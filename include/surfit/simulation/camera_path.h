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
  // Bounds of the motion between consecutive frames, including the hand tremor. Translation and
  // rotation vary slowly.
  double min_step_m = 0.010;
  double max_step_m = 0.020;
  double min_turn_deg = 0.5;
  double max_turn_deg = 1.5;

  void Visit(OptionVisitor& visitor);
};

// Generates a smooth hand-held camera path: poses world_from_camera in m (x right, y down, z
// forward), at the times i / frames_per_second. The path is in `scene.camera_space`, or repeats
// `scene.route`. The camera looks at `scene.targets` with a level horizon and hand tremor. If
// possible, it keeps 0.5 m from objects.
//
// If possible, 28 % to 45 % of the frames are planar: one or two planes cover at least 80 % of the
// visible pixels. If possible, no frame has more than 95 %. Every tenth frame is tested. In
// buildings, there is no minimum of 28 %.
//
// The same seed gives the same path. Throws InputError for invalid options and if `frames` < 1.
// Throws if the scene has no camera space or fewer than two targets.
Trajectory MakePath(const Scene& scene, int frames, std::uint64_t seed,
                    const PathOptions& options = {});

// Interpolates poses with continuous accelerations, by natural cubic splines of positions and
// quaternions. Extrapolates positions and quaternions linearly before the first and after the last
// pose.
class SmoothPath {
 public:
  // Throws for an empty trajectory, and unless its times increase. A single pose is a constant
  // pose.
  explicit SmoothPath(Trajectory poses);

  // Pose at a time. Bitwise identical to a given pose at its time.
  Rigid3d At(double stamp_s) const;

  const Trajectory& poses() const { return poses_; }

 private:
  using Knot = Eigen::Matrix<double, 7, 1>;  // position in metres, quaternion xyzw

  Trajectory poses_;
  std::vector<Knot> values_, second_derivatives_;
};

}  // namespace surfit
