#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "simulation/random.h"
#include "surfit/geometry/trajectory.h"
#include "surfit/simulation/scene.h"

namespace surfit {

// What a depth camera of 640 x 480 pixels and a focal length of 525 px holds on to in one view.
// Only what lies 0.4 to 4.5 m away counts as seen.
struct ViewQuality {
  double seen_share = 0;        // of the pixels
  double two_planes_share = 0;  // of the seen pixels: those on the two largest flat faces

  bool IsPlanar() const { return two_planes_share >= 0.8; }
  // Leaves a depth camera without hold.
  bool IsBare() const { return two_planes_share > 0.95 || seen_share < 0.5; }
};

ViewQuality JudgeView(const Scene& scene, const Rigid3d& world_from_camera);

// What a camera path shows, judged by some of its frames.
struct PathQuality {
  double planar_share = 0;  // of the views
  double bare_share = 0;    // of the views
};

PathQuality JudgePath(const Scene& scene, const Trajectory& path);

// A gaze that glides from target to target and never rests: it moves on the sphere of directions
// at a given speed and only steers, turning its heading little by little towards the target. Often
// it seeks a view of hardly more than one or two planes, otherwise any other.
class Gaze {
 public:
  // Keeps a pointer to the scene, which must have two targets at least.
  Gaze(const Scene& scene, const Eigen::Vector3d& position, std::uint64_t seed);

  // Goes on to other targets from here: changes the random choices to come.
  void Reseed(std::uint64_t seed) { random_ = Random(seed); }

  // World from camera: z along the gaze, x right, y down, the horizon level.
  Eigen::Quaterniond Orientation() const;

  // Moves on so that the orientation turns by this angle.
  void Advance(const Eigen::Vector3d& position, double turn_rad);

 private:
  void ChooseTarget(const Eigen::Vector3d& position);
  std::vector<int> TargetsFrom(const Eigen::Vector3d& position) const;
  bool MayTurnTo(const Eigen::Vector3d& to_target) const;
  void Steer(const Eigen::Vector3d& to_target);

  const Scene* scene_;
  Random random_;
  int target_ = -1;
  int frames_on_target_ = 0;
  // Unit vectors in the world's frame, z up, at right angles: where the gaze is, and where on the
  // sphere it moves to.
  Eigen::Vector3d direction_ = Eigen::Vector3d::UnitY(), heading_ = Eigen::Vector3d::UnitX();
};

}  // namespace surfit
