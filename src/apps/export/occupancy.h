#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "output/recorded_run.h"
#include "surfit/core/image.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/mapping/surfel_block.h"

namespace surfit {

enum class CellState : std::uint8_t { kUnknown, kFree, kOccupied };

// Occupancy of a band of heights. Row 0 has the smallest y.
struct OccupancyGrid {
  Image<CellState> cells;
  double cell_m = 0.05;
  Eigen::Vector2d origin_m = Eigen::Vector2d::Zero();  // lower left corner of the cell (0, 0)
  double low_m = 0, high_m = 0;                        // band above the floor
};

// Wall of a floor plan, in m.
struct WallLine {
  Eigen::Vector2d begin, end;
};

// Surfels and camera centres in the upright world frame.
struct UprightMap {
  std::vector<Surfel> surfels;
  // Camera centre of the frame that has seen each surfel last; not finite: unknown. One value per
  // surfel, which is not checked.
  std::vector<Eigen::Vector3d> observers;
  std::vector<Eigen::Vector3d> path;  // of the camera
};

// Surfels and cameras of a run, moved by `upright_from_world`.
UprightMap UprightMapOf(const std::vector<Surfel>& surfels, const RecordedRun& run,
                        const Rigid3d& upright_from_world);

// Occupied cells have at least three surfels in the band of heights from 0.1 m above the floor to
// 1.8 m. Free cells are crossed by a ray from a camera to a surfel within this band, or have floor.
// Throws InputError if the grid would have more than 10000 rows or columns, and without surfels
// below 1.8 m.
OccupancyGrid MakeOccupancyGrid(const UprightMap& map);

// Lines along which vertical surfaces of the band are plane for at least 0.4 m in length and
// height, the longest first.
std::vector<WallLine> FindWallLines(const UprightMap& map, const OccupancyGrid& grid);

// Writes map.pgm and map.yaml of the ROS map_server: 0 occupied, 254 free, 205 unknown; the first
// row has the largest y. Throws InputError with the path if writing fails.
void WriteRosMap(const OccupancyGrid& grid, const std::string& folder);

// Writes a floor plan as SVG: cells, walls, camera path and a scale bar. Throws InputError with the
// path if writing fails.
void WriteFloorPlan(const OccupancyGrid& grid, const std::vector<WallLine>& walls,
                    const std::vector<Eigen::Vector3d>& path, const std::string& file);

}  // namespace surfit
