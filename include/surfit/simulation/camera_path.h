#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "surfit/geometry/trajectory.h"
#include "surfit/simulation/scene.h"

namespace surfit {

class OptionVisitor;

// How a hand-held camera moves.
struct PathOptions {
  double frames_per_second = 30;
  // Distance and angle between consecutive frames vary slowly inside these bounds, the trembling
  // of the hand included.
  double min_step_m = 0.010;
  double max_step_m = 0.020;
  double min_turn_deg = 0.5;
  double max_turn_deg = 1.5;

  void Visit(OptionVisitor& visitor);
};

// A smooth hand-held camera path of world_from_camera poses through scene.camera_space, or round
// and round along scene.route, the gaze wandering over scene.targets, x right, y down, z forward,
// the horizon level but for a tremble. It keeps half a metre away from objects where the camera
// space allows; and as far as the targets allow, one or two planes hold at least 80 % of what is
// seen in a quarter to a half of the frames, and more than 95 % in none; in a building, where a
// camera has planes enough, in as few as it comes. Throws InputError if frames < 1.
Trajectory MakePath(const Scene& scene, int frames, std::uint64_t seed,
                    const PathOptions& options = {});

// A path between its poses, with continuous accelerations: a natural cubic spline through the
// positions, and one through the quaternions, which are brought to unit length. Before the first
// and after the last pose it goes on as it was going.
class SmoothPath {
 public:
  // Stamps must rise; there must be a pose.
  explicit SmoothPath(Trajectory poses);

  // At a stamp of a pose that pose, bit for bit.
  Rigid3d At(double stamp_s) const;

  const Trajectory& poses() const { return poses_; }

 private:
  using Knot = Eigen::Matrix<double, 7, 1>;  // position in metres, quaternion xyzw

  Trajectory poses_;
  std::vector<Knot> values_, second_derivatives_;
};

}  // namespace surfit
