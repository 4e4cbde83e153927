#include "simulation/gaze.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numeric>

#include "surfit/geometry/rigid3.h"
#include "surfit/simulation/render.h"

namespace surfit {

ViewQuality EvaluateView(const Scene& scene, const Rigid3d& world_from_camera) {
  PinholeCamera camera;  // 640 x 480 px at 1/32 of the resolution
  camera.width = 20;
  camera.height = 15;
  camera.fx = camera.fy = 525.0 / 32;
  camera.cx = 9.5;
  camera.cy = 7;
  const Rendering image = RenderGeometry(scene, camera, world_from_camera);
  int seen = 0;
  std::map<std::int32_t, int> pixels_on_face;
  for (std::size_t i = 0; i < image.depth_m.size(); ++i) {
    if (image.depth_m[i] < 0.4f || image.depth_m[i] > 4.5f) continue;
    ++seen;
    if (Rendering::IsFlat(image.surface[i])) ++pixels_on_face[image.surface[i]];
  }
  std::vector<int> largest(2, 0);
  for (const auto& [face, pixels] : pixels_on_face) largest.push_back(pixels);
  std::partial_sort(largest.begin(), largest.begin() + 2, largest.end(), std::greater<int>());
  return {static_cast<double>(seen) / image.depth_m.size(),
          static_cast<double>(largest[0] + largest[1]) / std::max(1, seen)};
}

PathQuality EvaluatePath(const Scene& scene, const Trajectory& path) {
  constexpr std::size_t kFramesApart = 10;
  PathQuality quality;
  int views = 0, planar = 0, bare = 0;
  for (std::size_t i = 0; i < path.size(); i += kFramesApart, ++views) {
    const ViewQuality view = EvaluateView(scene, path[i].world_from_camera);
    if (view.IsPlanar()) ++planar;
    if (view.IsDegenerate()) ++bare;
  }
  quality.planar_ratio = static_cast<double>(planar) / views;
  quality.degenerate_ratio = static_cast<double>(bare) / views;
  return quality;
}

namespace {

using Eigen::Vector3d;

Eigen::Quaterniond LevelOrientation(const Vector3d& gaze) {
  Eigen::Matrix3d world_from_camera;
  const Vector3d right = gaze.cross(Vector3d::UnitZ()).normalized();
  world_from_camera << right, gaze.cross(right), gaze;
  return Eigen::Quaterniond(world_from_camera);
}

double Angle(const Vector3d& a, const Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

// True if the target is farther than 0.6 m and its elevation allows a level horizon.
bool InSight(const Vector3d& to_target) {
  const double elevation = std::asin(to_target.z() / to_target.norm());
  return to_target.norm() > 0.6 && elevation > -52 * kRadPerDeg && elevation < 25 * kRadPerDeg;
}

}  // namespace

Gaze::Gaze(const Scene& scene, const Vector3d& position, std::uint64_t seed)
    : scene_(&scene), random_(seed) {
  ChooseTarget(position);
  direction_ = (scene_->targets[target_] - position).normalized();
  heading_ = direction_.cross(Vector3d::UnitZ()).normalized();
  ChooseTarget(position);
}

Eigen::Quaterniond Gaze::Orientation() const { return LevelOrientation(direction_); }

void Gaze::Advance(const Vector3d& position, double turn_rad) {
  constexpr double kReached_rad = 9 * kRadPerDeg;
  constexpr int kMaxFrames = 90;
  const Vector3d to_target = scene_->targets[target_] - position;
  if (Angle(direction_, to_target) < kReached_rad || ++frames_on_target_ > kMaxFrames ||
      !InSight(to_target)) {
    ChooseTarget(position);
  }
  Steer((scene_->targets[target_] - position).normalized());
  // Finds the arc for which the camera rotates by turn_rad. At high or low elevations, the camera
  // rotates more than its viewing direction.
  constexpr int kIterations = 10;
  const Eigen::Quaterniond before = Orientation();
  const Vector3d direction = direction_, heading = heading_;
  double arc = turn_rad;
  for (int i = 0; i < kIterations; ++i) {
    direction_ = std::cos(arc) * direction + std::sin(arc) * heading;
    heading_ = std::cos(arc) * heading - std::sin(arc) * direction;
    arc *= turn_rad / RotationAngle<double>(before.conjugate() * Orientation());
  }
}

bool Gaze::MayTurnTo(const Vector3d& to_target) const {
  constexpr double kFar_m = 3.5, kFarthestTurn_rad = 100 * kRadPerDeg;
  return InSight(to_target) && to_target.norm() < kFar_m &&
         Angle(direction_, to_target) < kFarthestTurn_rad;
}

// Indices of the targets in cells within 0.5 m. If there are none, indices of all targets.
std::vector<int> Gaze::TargetsFrom(const Vector3d& position) const {
  constexpr double kAtDoorway_m = 0.5;
  std::vector<int> targets;
  for (const SceneCell& cell : scene_->cells) {
    if (cell.space.exteriorDistance(position) > kAtDoorway_m) continue;
    targets.insert(targets.end(), cell.targets.begin(), cell.targets.end());
  }
  if (!targets.empty()) return targets;
  targets.resize(scene_->targets.size());
  std::iota(targets.begin(), targets.end(), 0);
  return targets;
}

// Chooses the next target. Prefers targets in front of the camera, and views of a random kind
// (planar or not).
void Gaze::ChooseTarget(const Vector3d& position) {
  const double planar_choices = scene_->cells.empty() ? 0.8 : 0;
  constexpr int kAttempts = 40, kMaxViews = 12;
  const bool want_planar = random_.Uniform() < planar_choices;
  const int last = target_;
  const std::vector<int> targets = TargetsFrom(position);
  int views = 0;
  for (int i = 0; i < kAttempts && views < kMaxViews; ++i) {
    const int candidate = targets[random_.Index(static_cast<int>(targets.size()))];
    const Vector3d to_target = scene_->targets[candidate] - position;
    if (candidate == last || (i < kAttempts / 2 && !MayTurnTo(to_target))) continue;
    target_ = candidate;
    ++views;
    const ViewQuality view =
        EvaluateView(*scene_, Rigid3d(LevelOrientation(to_target.normalized()), position));
    if (!view.IsDegenerate() && view.IsPlanar() == want_planar) break;
  }
  frames_on_target_ = 0;
}

void Gaze::Steer(const Vector3d& to_target) {
  constexpr double kMaxTurn_rad = 7 * kRadPerDeg;
  const double wanted =
      std::atan2(direction_.cross(heading_).dot(to_target), heading_.dot(to_target));
  const double turn = std::clamp(wanted, -kMaxTurn_rad, kMaxTurn_rad);
  heading_ = (Eigen::AngleAxisd(turn, direction_) * heading_).normalized();
}

}  // namespace surfit
