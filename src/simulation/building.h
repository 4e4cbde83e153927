#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "surfit/geometry/rigid3.h"
#include "surfit/simulation/scene.h"

namespace surfit {

// Floor plan of a building. Each floor is a ring of four corridors around two rows of rooms, with
// another row on each side. x is along the rows, y is across:
//
//   y   outer north rooms
//   |   north corridor
//   |   inner north rooms
//   |   inner south rooms     (west and east corridors at the ends,
//   |   south corridor         a staircase beyond each)
//   +-- outer south rooms
//
// Staircases go up from their south end to their north end, one flight per floor.
struct BuildingPlan {
  static constexpr double kRoomWidth_m = 5.2, kRoomDepth_m = 4.8, kCorridor_m = 2.2,
                          kStaircase_m = 2.0, kStorey_m = 2.9;

  enum class Row { kOuterSouth, kInnerSouth, kInnerNorth, kOuterNorth };

  // Room. In the room frame, the doorway is in the middle of the wall y = 0. `column` counts from
  // the west, `floor` from the bottom, both from 0. `doorway` is in the world frame, m.
  struct Place {
    int floor, column;
    Row row;
    Rigid3d world_from_room;
    Eigen::Vector3d doorway;
  };

  // Throws InputError unless all floors have the same number of rooms.
  explicit BuildingPlan(const BuildingOptions& options);

  // Size of the block of rooms along x and y, m, with the south and north corridors.
  double Length() const { return columns * (kRoomWidth_m + kGap_m) - kGap_m; }
  static double Depth() { return 2 * kCorridor_m + 2 * kRoomDepth_m + 3 * kGap_m; }
  // Centre lines of the corridors, m: y of south and north corridors, x of west and east corridors.
  static double SouthAisle() { return kCorridor_m / 2; }
  static double NorthAisle() { return Depth() - kCorridor_m / 2; }
  static double WestAisle() { return -kGap_m - kCorridor_m / 2; }
  double EastAisle() const { return Length() - WestAisle(); }
  // x of the centre line of a staircase, m.
  double StaircaseAisle(bool east) const;

  static constexpr double kGap_m = 0.4;  // thickness of the wall between two cells

  int floors, columns;  // columns: rooms per row
  std::vector<Place> rooms;
};

// Control points of a closed camera path through all rooms, at eye height. World frame, m.
std::vector<Eigen::Vector3d> BuildingRoute(const BuildingPlan& plan);

struct RoomPlan;
// Adds the flight from `floor` to the next floor: steps, landings, handrails and pictures.
// `staircase`: plan of the whole staircase, from the ground floor.
void AddFlight(const RoomPlan& staircase, int floor);

// Building with furnished rooms, and a camera route through all of them. Rooms 2 k and 2 k + 1 have
// equal furniture and different pictures. Throws InputError like BuildingPlan.
Scene MakeBuilding(std::uint64_t seed, const BuildingOptions& options);

}  // namespace surfit
