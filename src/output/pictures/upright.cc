#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/median.h"
#include "output/pictures/pictures.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

constexpr double kPiOverTwo = 1.57079632679489662;
constexpr double kPlaneThickness_m = 0.03;  // half thickness of a plane with noise
constexpr double kMinPlaneArea_m2 = 0.1;
constexpr double kMinHorizontalArea_m2 = 0.3;
constexpr double kMinSigma_rad = 0.1 * kRadPerDeg;
constexpr double kMaxSigma_rad = 1.0 * kRadPerDeg;
// Tilt of built surfaces and of planes in maps.
constexpr double kPlaneSigma_rad = 0.4 * kRadPerDeg;

struct WeightedPoint {
  Eigen::Vector3d position, normal;
  double area_m2 = 0;
};

// Surfels overlap, so the sum of their areas is too large. This sample has one point per occupied
// cube, with the area of the cross section of the cube.
std::vector<WeightedPoint> SampleOf(const std::vector<Surfel>& surfels) {
  constexpr double kEdge_m = 0.03;
  struct Cell {
    std::array<std::int64_t, 3> cube;
    std::size_t index;
  };
  std::vector<Cell> cells;
  cells.reserve(surfels.size());
  for (std::size_t i = 0; i < surfels.size(); ++i) {
    std::array<std::int64_t, 3> cube;
    for (int k = 0; k < 3; ++k) {
      cube[k] = static_cast<std::int64_t>(std::floor(surfels[i].position_in_world[k] / kEdge_m));
    }
    cells.push_back({cube, i});
  }
  std::sort(cells.begin(), cells.end(), [](const Cell& a, const Cell& b) {
    return a.cube != b.cube ? a.cube < b.cube : a.index < b.index;
  });
  std::vector<WeightedPoint> sample;
  for (std::size_t begin = 0; begin < cells.size();) {
    std::size_t end = begin;
    Eigen::Vector3d position = Eigen::Vector3d::Zero(), normal = Eigen::Vector3d::Zero();
    for (; end < cells.size() && cells[end].cube == cells[begin].cube; ++end) {
      position += surfels[cells[end].index].position_in_world.cast<double>();
      normal += surfels[cells[end].index].normal_in_world.cast<double>();
    }
    const auto count = static_cast<double>(end - begin);
    // Cubes with surfels of different directions are edges.
    constexpr double kMinCommonNormal = 0.9;
    if (normal.norm() > kMinCommonNormal * count) {
      normal.normalize();
      // A plane crosses about max(|n|) cubes per edge length squared of its area.
      sample.push_back(
          {position / count, normal, kEdge_m * kEdge_m * normal.cwiseAbs().maxCoeff()});
    }
    begin = end;
  }
  return sample;
}

// Plane through points: the direction n and the inertia of its points along the plane.
struct Plane {
  Eigen::Vector3d normal, center;
  double area_m2 = 0;
  // Mean squares of the coordinates along the two axes of the plane, and the axes.
  Eigen::Vector3d long_axis, short_axis;
  double long_m2 = 0, short_m2 = 0;
};

// Fits a plane to the points near `start`, iteratively.
std::optional<Plane> FitPlane(const std::vector<WeightedPoint>& points, Plane plane) {
  constexpr int kPasses = 4;
  const double min_cosine = std::cos(12 * kRadPerDeg);
  for (int pass = 0; pass < kPasses; ++pass) {
    double area = 0;
    Eigen::Vector3d center = Eigen::Vector3d::Zero();
    Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
    for (const WeightedPoint& p : points) {
      if (p.normal.dot(plane.normal) < min_cosine) continue;
      const Eigen::Vector3d from_center = p.position - plane.center;
      if (std::abs(from_center.dot(plane.normal)) > kPlaneThickness_m) continue;
      area += p.area_m2;
      center += p.area_m2 * from_center;
      second += p.area_m2 * from_center * from_center.transpose();
    }
    if (!(area > kMinPlaneArea_m2)) return {};
    center /= area;
    const Eigen::Matrix3d covariance = second / area - center * center.transpose();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(covariance);
    Eigen::Vector3d normal = axes.eigenvectors().col(0);
    if (normal.dot(plane.normal) < 0) normal = -normal;
    if (normal.dot(plane.normal) < min_cosine) return {};
    plane.center += center;
    plane.normal = normal;
    plane.area_m2 = area;
    plane.short_axis = axes.eigenvectors().col(1);
    plane.long_axis = axes.eigenvectors().col(2);
    plane.short_m2 = axes.eigenvalues()[1];
    plane.long_m2 = axes.eigenvalues()[2];
  }
  return plane;
}

// Finds parallel planes, the largest first. Uses points whose normal is within `gate_rad` of
// `direction`. The planes are the peaks of a histogram of the offsets along `direction`. A point
// belongs to one plane.
std::vector<Plane> PlanesAlong(const std::vector<WeightedPoint>& points,
                               const Eigen::Vector3d& direction, double gate_rad) {
  constexpr double kBin_m = 0.02;
  constexpr int kMaxPlanes = 12;
  std::vector<WeightedPoint> left;
  for (const WeightedPoint& p : points) {
    if (p.normal.dot(direction) > std::cos(gate_rad)) left.push_back(p);
  }
  std::vector<Plane> planes;
  while (static_cast<int>(planes.size()) < kMaxPlanes && !left.empty()) {
    double low = left.front().position.dot(direction), high = low;
    for (const WeightedPoint& p : left) {
      low = std::min(low, p.position.dot(direction));
      high = std::max(high, p.position.dot(direction));
    }
    std::vector<double> bins(static_cast<std::size_t>((high - low) / kBin_m) + 3, 0);
    for (const WeightedPoint& p : left) {
      bins[static_cast<std::size_t>((p.position.dot(direction) - low) / kBin_m) + 1] += p.area_m2;
    }
    std::size_t best = 1;
    const auto around = [&](std::size_t i) { return bins[i - 1] + bins[i] + bins[i + 1]; };
    for (std::size_t i = 1; i + 1 < bins.size(); ++i) {
      if (around(i) > around(best)) best = i;
    }
    if (around(best) < kMinPlaneArea_m2) break;
    const double offset = low + (static_cast<double>(best) - 0.5) * kBin_m;
    Plane start;
    start.normal = direction;
    start.center = Eigen::Vector3d::Zero();
    double area = 0;
    for (const WeightedPoint& p : left) {
      if (std::abs(p.position.dot(direction) - offset) > 1.5 * kBin_m) continue;
      start.center += p.area_m2 * p.position;
      area += p.area_m2;
    }
    start.center /= area;
    const std::optional<Plane> plane = FitPlane(left, start);
    if (plane) planes.push_back(*plane);
    const Plane used = plane.value_or(start);
    const std::size_t before = left.size();
    left.erase(std::remove_if(left.begin(), left.end(),
                              [&](const WeightedPoint& p) {
                                return std::abs((p.position - used.center).dot(used.normal)) <
                                           2 * kPlaneThickness_m ||
                                       std::abs(p.position.dot(direction) - offset) <= 1.5 * kBin_m;
                              }),
               left.end());
    if (left.size() == before) break;
  }
  return planes;
}

// Replaces a direction repeatedly by the mean of the normals around it, with decreasing angles.
Eigen::Vector3d Narrow(const std::vector<WeightedPoint>& points, Eigen::Vector3d direction) {
  for (const double gate_deg : {45., 30., 20., 12., 8., 5., 5.}) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const WeightedPoint& p : points) {
      if (p.normal.dot(direction) > std::cos(gate_deg * kRadPerDeg)) sum += p.area_m2 * p.normal;
    }
    if (!(sum.norm() > 0)) break;
    direction = sum.normalized();
  }
  return direction;
}

// Upward direction with the largest horizontal planes. The result of each narrowing depends on its
// start, so several starts within 30 degrees of `up` are tried.
Eigen::Vector3d DominantUp(const std::vector<WeightedPoint>& points, const Eigen::Vector3d& up) {
  const Eigen::Vector3d x = up.unitOrthogonal(), y = up.cross(x);
  Eigen::Vector3d best = up;
  double best_area = -1;
  for (int ring = 0; ring <= 2; ++ring) {
    for (int k = 0; k < (ring == 0 ? 1 : 6); ++k) {
      const double tilt = 15 * ring * kRadPerDeg, azimuth = k * kPiOverTwo * 4 / 6;
      const Eigen::Vector3d start =
          std::cos(tilt) * up + std::sin(tilt) * (std::cos(azimuth) * x + std::sin(azimuth) * y);
      const Eigen::Vector3d direction = Narrow(points, start);
      double area = 0;
      for (const WeightedPoint& p : points) {
        if (std::abs(p.normal.dot(direction)) > std::cos(6 * kRadPerDeg)) area += p.area_m2;
      }
      // Prefers a direction near that of the cameras.
      const double score = area * std::pow(std::max(0., direction.dot(up)), 2);
      if (score > best_area) {
        best_area = score;
        best = direction;
      }
    }
  }
  return best;
}

// Azimuth of the walls about `up`, relative to `x`: a quarter of the argument of the mean of exp(4
// i azimuth). `strength`: length of the mean, 1 for perfect walls at right angles.
struct WallAzimuth {
  double azimuth_rad = 0, strength = 0, area_m2 = 0;
};
WallAzimuth FindWallAzimuth(const std::vector<WeightedPoint>& points, const Eigen::Vector3d& up,
                            const Eigen::Vector3d& x) {
  const Eigen::Vector3d y = up.cross(x);
  double sum_cos = 0, sum_sin = 0, area = 0;
  const auto add = [&](const WeightedPoint& p) {
    const double azimuth = std::atan2(p.normal.dot(y), p.normal.dot(x));
    sum_cos += p.area_m2 * std::cos(4 * azimuth);
    sum_sin += p.area_m2 * std::sin(4 * azimuth);
    area += p.area_m2;
  };
  for (const WeightedPoint& p : points) {
    if (std::abs(p.normal.dot(up)) < std::sin(10 * kRadPerDeg)) add(p);
  }
  WallAzimuth result;
  result.area_m2 = area;
  if (!(area > 0)) return result;
  result.strength = std::hypot(sum_cos, sum_sin) / area;
  result.azimuth_rad = std::atan2(sum_sin, sum_cos) / 4;
  // Repeats the estimate without surfaces that are oblique to the axes.
  for (const double gate_deg : {15., 8., 5.}) {
    const double before = result.azimuth_rad;
    sum_cos = sum_sin = area = 0;
    for (const WeightedPoint& p : points) {
      if (std::abs(p.normal.dot(up)) > std::sin(10 * kRadPerDeg)) continue;
      const double azimuth = std::atan2(p.normal.dot(y), p.normal.dot(x));
      if (std::abs(std::remainder(azimuth - before, kPiOverTwo)) < gate_deg * kRadPerDeg) add(p);
    }
    if (area > 0) result.azimuth_rad = std::atan2(sum_sin, sum_cos) / 4;
  }
  return result;
}

// Adds a measurement of the direction `g` to normal equations of its tilt about two axes.
class TiltEquations {
 public:
  explicit TiltEquations(const Eigen::Vector3d& up) : up_(up) {
    axes_.col(0) = up.unitOrthogonal();
    axes_.col(1) = up.cross(axes_.col(0));
  }

  // Adds the rows of a plane. The extent of its points determines the weight.
  void Add(const Plane& plane, bool is_horizontal) {
    // g = up + axes t. Horizontal: (n x g) = 0 along both axes of the plane. Wall: n . g = 0.
    Eigen::Vector3d normal = plane.normal;
    if (is_horizontal) {
      if (normal.dot(up_) < 0) normal = -normal;
      AddRow(plane.long_axis, normal, WeightOf(plane.long_m2));
      AddRow(plane.short_axis, normal, WeightOf(plane.short_m2));
    } else {
      // The vertical extent of a wall constrains its tilt.
      const double vertical_m2 = std::pow(plane.long_axis.dot(up_), 2) * plane.long_m2 +
                                 std::pow(plane.short_axis.dot(up_), 2) * plane.short_m2;
      AddRow(normal, Eigen::Vector3d::Zero(), WeightOf(vertical_m2));
    }
  }

  struct Solution {
    Eigen::Vector3d up;
    double sigma_rad;
  };
  Solution Solve() const {
    Solution solution = {up_, std::numeric_limits<double>::infinity()};
    const Eigen::Matrix2d inverse = hessian_.inverse();
    if (!inverse.allFinite()) return solution;
    Eigen::Vector2d tilt = Eigen::Vector2d::Zero();
    // Robust weights: tilted planes have less weight.
    Eigen::Matrix2d hessian = hessian_;
    double chi2 = 0;
    for (int pass = 0; pass < 10; ++pass) {
      hessian.setZero();
      Eigen::Vector2d gradient = Eigen::Vector2d::Zero();
      chi2 = 0;
      for (const Row& row : rows_) {
        const double residual = row.value + row.by_tilt.dot(tilt);
        const double share2 = residual * residual * row.weight / 4, s = 1 + share2;
        const double weight = row.weight / (s * s);
        hessian += weight * row.by_tilt * row.by_tilt.transpose();
        gradient += weight * residual * row.by_tilt;
        chi2 += weight * residual * residual;
      }
      const Eigen::Vector2d step = hessian.ldlt().solve(-gradient);
      if (!step.allFinite()) return solution;
      tilt += step;
    }
    const double redundancy = std::max(1., static_cast<double>(rows_.size()) - 2);
    const double factor = std::max(1., chi2 / redundancy);
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(hessian);
    solution.up = (up_ + axes_ * tilt).normalized();
    solution.sigma_rad =
        std::max(kMinSigma_rad, std::sqrt(factor / std::max(1e-12, axes.eigenvalues()[0])));
    return solution;
  }

 private:
  struct Row {
    Eigen::Vector2d by_tilt;
    double value, weight;
  };

  // The standard deviation of the tilt is kPlaneSigma_rad for an extent of some metres, and larger
  // for a smaller extent.
  static double WeightOf(double lever_m2) {
    constexpr double kPointSigma_m = 0.004;  // systematic error across a plane
    const double by_lever = kPointSigma_m * kPointSigma_m / std::max(lever_m2, 1e-6);
    return 1 / (kPlaneSigma_rad * kPlaneSigma_rad + by_lever);
  }

  // Residual (g - target) . direction.
  void AddRow(const Eigen::Vector3d& direction, const Eigen::Vector3d& target, double weight) {
    const Row row = {axes_.transpose() * direction, (up_ - target).dot(direction), weight};
    rows_.push_back(row);
    hessian_ += weight * row.by_tilt * row.by_tilt.transpose();
  }

  Eigen::Vector3d up_;
  Eigen::Matrix<double, 3, 2> axes_;
  std::vector<Row> rows_;
  Eigen::Matrix2d hessian_ = Eigen::Matrix2d::Zero();
};

// Planes for the direction of gravity.
struct RoomPlanes {
  std::vector<Plane> level;  // facing up or down
  std::vector<Plane> walls;
};

RoomPlanes FindPlanes(const std::vector<WeightedPoint>& points, const Eigen::Vector3d& up) {
  constexpr double kGate_rad = 6 * kRadPerDeg;
  RoomPlanes planes;
  for (const double sign : {1., -1.}) {
    for (const Plane& plane : PlanesAlong(points, sign * up, kGate_rad)) {
      planes.level.push_back(plane);
    }
  }
  const Eigen::Vector3d x = up.unitOrthogonal();
  const WallAzimuth walls = FindWallAzimuth(points, up, x);
  for (int quarter = 0; quarter < 4; ++quarter) {
    const double azimuth = walls.azimuth_rad + quarter * kPiOverTwo;
    const Eigen::Vector3d normal = std::cos(azimuth) * x + std::sin(azimuth) * up.cross(x);
    for (const Plane& plane : PlanesAlong(points, normal, kGate_rad)) {
      planes.walls.push_back(plane);
    }
  }
  return planes;
}

// Lowest large plane that faces up.
const Plane* FindFloor(const std::vector<Plane>& level, const Eigen::Vector3d& up,
                       const Trajectory& cameras) {
  std::vector<double> heights;
  for (const StampedPose& pose : cameras)
    heights.push_back(pose.world_from_camera.translation.dot(up));
  const double camera_height = MedianOf(std::move(heights));
  double most = 0;
  for (const Plane& plane : level) {
    if (plane.normal.dot(up) > 0) most = std::max(most, plane.area_m2);
  }
  const Plane* floor = nullptr;
  for (const Plane& plane : level) {
    constexpr double kMinRatio = 0.1;  // of the largest plane that faces up
    if (plane.normal.dot(up) < 0 || plane.area_m2 < kMinRatio * most) continue;
    if (plane.center.dot(up) > camera_height) continue;
    if (!floor || plane.center.dot(up) < floor->center.dot(up)) floor = &plane;
  }
  return floor;
}

}  // namespace

UprightResult FindUpright(const std::vector<Surfel>& surfels, const Trajectory& cameras) {
  constexpr double kMinCommonUp = 0.5;  // minimum length of the mean upward axis of the cameras
  if (surfels.empty() || cameras.empty()) return {{}, "the map is empty"};
  Eigen::Vector3d camera_up = Eigen::Vector3d::Zero();
  for (const StampedPose& pose : cameras) {
    camera_up -= pose.world_from_camera.rotation * Eigen::Vector3d::UnitY();
  }
  camera_up /= static_cast<double>(cameras.size());
  if (camera_up.norm() < kMinCommonUp) {
    return {{}, "the cameras have no common upward direction"};
  }
  const std::vector<WeightedPoint> points = SampleOf(surfels);
  Eigen::Vector3d up = DominantUp(points, camera_up.normalized());
  RoomPlanes planes;
  TiltEquations::Solution solution = {up, 0};
  for (int pass = 0; pass < 2; ++pass) {
    planes = FindPlanes(points, solution.up);
    TiltEquations equations(solution.up);
    for (const Plane& plane : planes.level) equations.Add(plane, true);
    for (const Plane& plane : planes.walls) equations.Add(plane, false);
    solution = equations.Solve();
  }
  up = solution.up;
  UprightWorld world;
  world.sigma_rad = solution.sigma_rad;
  world.horizontal_planes = static_cast<int>(planes.level.size());
  world.walls = static_cast<int>(planes.walls.size());
  for (const Plane& plane : planes.level) world.horizontal_area_m2 += plane.area_m2;
  if (world.horizontal_area_m2 < kMinHorizontalArea_m2) {
    return {
        {},
        Concat("the map has ", std::round(100 * world.horizontal_area_m2) / 100,
               " m2 of horizontal planes, at least ", kMinHorizontalArea_m2, " m2 are necessary")};
  }
  if (!(world.sigma_rad <= kMaxSigma_rad)) {
    return {{}, "floor and walls of the map give no common direction of gravity"};
  }
  const Plane* const floor = FindFloor(planes.level, up, cameras);
  if (!floor) return {{}, "the map has no floor or table below the cameras"};
  world.floor_area_m2 = floor->area_m2;

  // Start from the axis of the run that is most horizontal.
  int most_horizontal = 0;
  for (int k = 1; k < 3; ++k) {
    if (std::abs(up[k]) < std::abs(up[most_horizontal])) most_horizontal = k;
  }
  Eigen::Vector3d x = Eigen::Vector3d::Unit(most_horizontal);
  x = (x - x.dot(up) * up).normalized();
  const WallAzimuth azimuth = FindWallAzimuth(points, up, x);
  constexpr double kMinStrength = 0.3, kMinWallArea_m2 = 0.5;
  world.walls_give_axes = azimuth.strength > kMinStrength && azimuth.area_m2 > kMinWallArea_m2;
  if (world.walls_give_axes) {
    const double turn = std::remainder(azimuth.azimuth_rad, kPiOverTwo);
    x = (std::cos(turn) * x + std::sin(turn) * up.cross(x)).normalized();
  }
  Eigen::Matrix3d rotation;
  rotation.row(0) = x;
  rotation.row(1) = up.cross(x);
  rotation.row(2) = up;
  // The centre of the floor is at z = 0.
  world.upright_from_world = Rigid3d(rotation, {0, 0, -floor->center.dot(up)});
  return {world, ""};
}

}  // namespace surfit
