#include "apps/export/occupancy.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <ostream>

#include "surfit/core/atomic_file.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

constexpr double kLow_m = 0.1, kHigh_m = 1.8;
constexpr double kMargin_m = 0.25;
constexpr int kMaxSide = 10000;
constexpr int kMinSurfels = 3;           // in an occupied cell
constexpr double kMinArea_ratio = 0.05;  // of surfels in an occupied cell, relative to the cell
constexpr double kRayEnd_m = 0.1;        // a ray ends before its surface

class CellCounts {
 public:
  explicit CellCounts(const OccupancyGrid& grid)
      : grid_(grid),
        surfels_(grid.cells.width(), grid.cells.height(), 0),
        area_m2_(grid.cells.width(), grid.cells.height(), 0),
        seen_(grid.cells.width(), grid.cells.height(), 0) {}

  void AddSurfel(const Surfel& surfel) {
    const Eigen::Vector3d p = surfel.position_in_world.cast<double>();
    const Eigen::Vector2i cell = CellOf(p);
    if (!Has(cell)) return;
    if (p.z() >= grid_.low_m && p.z() <= grid_.high_m) {
      ++surfels_(cell.x(), cell.y());
      area_m2_(cell.x(), cell.y()) += 3 * surfel.radius_m * surfel.radius_m;
    } else if (p.z() > -grid_.low_m && p.z() < grid_.low_m && surfel.normal_in_world.z() > 0.8f) {
      ++seen_(cell.x(), cell.y());
    }
  }

  // Marks the cells that the ray crosses within the band.
  void AddRay(Eigen::Vector3d from, const Eigen::Vector3d& surface) {
    const Eigen::Vector3d whole = surface - from;
    const double length_m = whole.norm();
    if (!(length_m > kRayEnd_m)) return;
    Eigen::Vector3d to = surface - kRayEnd_m / length_m * whole;
    if (!Clip(&from, &to)) return;
    const double steps = std::ceil((to - from).head<2>().norm() / (0.5 * grid_.cell_m)) + 1;
    for (int i = 0; i <= static_cast<int>(steps); ++i) {
      const Eigen::Vector2i cell = CellOf(from + i / steps * (to - from));
      if (Has(cell)) ++seen_(cell.x(), cell.y());
    }
  }

  CellState StateOf(int u, int v) const {
    const double cell_m2 = grid_.cell_m * grid_.cell_m;
    if (surfels_(u, v) >= kMinSurfels && area_m2_(u, v) > kMinArea_ratio * cell_m2) {
      return CellState::kOccupied;
    }
    return seen_(u, v) > 0 ? CellState::kFree : CellState::kUnknown;
  }

 private:
  Eigen::Vector2i CellOf(const Eigen::Vector3d& point) const {
    const Eigen::Vector2d at = (point.head<2>() - grid_.origin_m) / grid_.cell_m;
    return {static_cast<int>(std::floor(at.x())), static_cast<int>(std::floor(at.y()))};
  }
  bool Has(const Eigen::Vector2i& cell) const {
    return cell.x() >= 0 && cell.y() >= 0 && cell.x() < grid_.cells.width() &&
           cell.y() < grid_.cells.height();
  }
  // Part of the segment within the band. Returns false if it is empty.
  bool Clip(Eigen::Vector3d* from, Eigen::Vector3d* to) const {
    const double rise = to->z() - from->z();
    double begin = 0, end = 1;
    if (std::abs(rise) < 1e-9) {
      if (from->z() < grid_.low_m || from->z() > grid_.high_m) return false;
    } else {
      double at_low = (grid_.low_m - from->z()) / rise, at_high = (grid_.high_m - from->z()) / rise;
      if (at_low > at_high) std::swap(at_low, at_high);
      begin = std::max(begin, at_low);
      end = std::min(end, at_high);
    }
    if (!(begin < end)) return false;
    const Eigen::Vector3d start = *from, way = *to - *from;
    *from = start + begin * way;
    *to = start + end * way;
    return true;
  }

  const OccupancyGrid& grid_;
  Image<int> surfels_;
  Image<double> area_m2_;
  Image<int> seen_;
};

}  // namespace

UprightMap UprightMapOf(const std::vector<Surfel>& surfels, const RecordedRun& run,
                        const Rigid3d& upright_from_world) {
  UprightMap map;
  const Eigen::Vector3d unknown =
      Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  for (const Surfel& surfel : surfels) {
    Surfel moved = surfel;
    moved.position_in_world =
        (upright_from_world * surfel.position_in_world.cast<double>()).cast<float>();
    moved.normal_in_world = upright_from_world.rotation.cast<float>() * surfel.normal_in_world;
    map.surfels.push_back(moved);
    const auto pose = run.world_from_camera.find(surfel.last_seen);
    map.observers.push_back(pose == run.world_from_camera.end()
                                ? unknown
                                : upright_from_world * pose->second.translation);
  }
  for (const StampedPose& pose : run.trajectory) {
    map.path.push_back(upright_from_world * pose.world_from_camera.translation);
  }
  return map;
}

OccupancyGrid MakeOccupancyGrid(const UprightMap& map) {
  OccupancyGrid grid;
  grid.low_m = kLow_m;
  grid.high_m = kHigh_m;
  Eigen::Vector2d low = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector2d high = -low;
  for (const Surfel& surfel : map.surfels) {
    const Eigen::Vector3d p = surfel.position_in_world.cast<double>();
    if (p.z() > grid.high_m) continue;
    low = low.cwiseMin(p.head<2>());
    high = high.cwiseMax(p.head<2>());
  }
  ThrowIf(!low.allFinite(), "the map has no surfels below ", grid.high_m, " m");
  grid.origin_m = ((low.array() - kMargin_m) / grid.cell_m).floor() * grid.cell_m;
  const Eigen::Vector2d size = (high.array() + kMargin_m - grid.origin_m.array()) / grid.cell_m;
  ThrowIf(!(size.maxCoeff() < kMaxSide), "the map extends over ", size.maxCoeff() * grid.cell_m,
          " m, must be at most ", kMaxSide * grid.cell_m, " m");
  grid.cells = Image<CellState>(static_cast<int>(std::ceil(size.x())),
                                static_cast<int>(std::ceil(size.y())), CellState::kUnknown);
  CellCounts counts(grid);
  constexpr std::size_t kMaxRays = 200000;
  const std::size_t stride = std::max<std::size_t>(1, map.surfels.size() / kMaxRays);
  for (std::size_t i = 0; i < map.surfels.size(); ++i) {
    counts.AddSurfel(map.surfels[i]);
    if (i % stride == 0 && map.observers[i].allFinite()) {
      counts.AddRay(map.observers[i], map.surfels[i].position_in_world.cast<double>());
    }
  }
  for (int v = 0; v < grid.cells.height(); ++v) {
    for (int u = 0; u < grid.cells.width(); ++u) grid.cells(u, v) = counts.StateOf(u, v);
  }
  return grid;
}

void WriteRosMap(const OccupancyGrid& grid, const std::string& folder) {
  constexpr char kOccupied = 0;
  const int width = grid.cells.width(), height = grid.cells.height();
  WriteFileAtomically(folder + "/map.pgm", [&](std::ostream& out) {
    out << "P5\n" << width << ' ' << height << "\n255\n";
    for (int v = height - 1; v >= 0; --v) {
      for (int u = 0; u < width; ++u) {
        const CellState state = grid.cells(u, v);
        out.put(state == CellState::kOccupied
                    ? kOccupied
                    : static_cast<char>(state == CellState::kFree ? 254 : 205));
      }
    }
  });
  WriteFileAtomically(folder + "/map.yaml", [&](std::ostream& out) {
    out.precision(12);
    out << "image: map.pgm\nresolution: " << grid.cell_m << "\norigin: [" << grid.origin_m.x()
        << ", " << grid.origin_m.y()
        << ", 0.0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n";
  });
}

}  // namespace surfit
