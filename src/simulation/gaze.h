#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "simulation/random.h"
#include "surfit/geometry/trajectory.h"
#include "surfit/simulation/scene.h"

namespace surfit {

// Geometric content of a view of 640 x 480 px with a focal length of 525 px. Visible pixels have
// depths of 0.4 to 4.5 m.
struct ViewQuality {
  double visible_ratio = 0;     // visible pixels / pixels
  double two_planes_ratio = 0;  // pixels on the two largest flat faces / visible pixels

  bool IsPlanar() const { return two_planes_ratio >= 0.8; }
  // True if registration would be degenerate.
  bool IsDegenerate() const { return two_planes_ratio > 0.95 || visible_ratio < 0.5; }
};

// Evaluates a view by rendering it at 20 x 15 px.
ViewQuality EvaluateView(const Scene& scene, const Rigid3d& world_from_camera);

struct PathQuality {
  double planar_ratio = 0;
  double degenerate_ratio = 0;
};

// Evaluates every tenth pose. The ratios are NaN for an empty path.
PathQuality EvaluatePath(const Scene& scene, const Trajectory& path);

// Viewing direction that moves continuously from target to target on the unit sphere. It has a
// given speed and turns gradually. In scenes without cells, 80 % of the targets are chosen for
// views of one or two planes, if there are any.
class Gaze {
 public:
  // Keeps a pointer to the scene, which must have at least two targets. `position`: camera in
  // world, m. Equal seeds give equal motions.
  Gaze(const Scene& scene, const Eigen::Vector3d& position, std::uint64_t seed);

  // Changes the choice of the next targets.
  void Reseed(std::uint64_t seed) { random_ = Random(seed); }

  // world_from_camera: z along the gaze, x right, y down, level horizon.
  Eigen::Quaterniond Orientation() const;

  // Moves the gaze by a camera rotation of `turn_rad`. `position`: camera in world, m.
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
  // Orthogonal unit vectors in the world frame (z up): gaze, and direction of its motion.
  Eigen::Vector3d direction_ = Eigen::Vector3d::UnitY(), heading_ = Eigen::Vector3d::UnitX();
};

}  // namespace surfit
