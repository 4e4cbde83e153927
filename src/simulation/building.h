#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "surfit/geometry/rigid3.h"
#include "surfit/simulation/scene.h"

namespace surfit {

// Where what is in a building. Each floor is a ring of four corridors around two rows of rooms,
// with a row on either side of it; x leads along the rows, y across:
//
//   y   outer north rooms
//   |   north corridor
//   |   inner north rooms
//   |   inner south rooms     (west and east corridors at the ends,
//   |   south corridor         a staircase beyond each)
//   +-- outer south rooms
//
// Staircases lead up from their south end to their north end, one flight a floor.
struct BuildingPlan {
  static constexpr double kRoomWidth_m = 5.2, kRoomDepth_m = 4.8, kCorridor_m = 2.2,
                          kStaircase_m = 2.0, kStorey_m = 2.9;

  enum class Row { kOuterSouth, kInnerSouth, kInnerNorth, kOuterNorth };

  // A room's own frame has its doorway in the middle of the wall y = 0.
  struct Place {
    int floor, column;
    Row row;
    Rigid3d world_from_room;
    Eigen::Vector3d doorway;  // on the floor, in the middle of the wall
  };

  // Throws InputError unless each floor has as many rooms.
  explicit BuildingPlan(const BuildingOptions& options);

  double Length() const { return columns * (kRoomWidth_m + kGap_m) - kGap_m; }       // of the rows
  static double Depth() { return 2 * kCorridor_m + 2 * kRoomDepth_m + 3 * kGap_m; }  // of the ring
  static double SouthAisle() { return kCorridor_m / 2; }  // y of the middle of a corridor
  static double NorthAisle() { return Depth() - kCorridor_m / 2; }
  static double WestAisle() { return -kGap_m - kCorridor_m / 2; }  // and x
  double EastAisle() const { return Length() - WestAisle(); }
  double StaircaseAisle(bool east) const;

  static constexpr double kGap_m = 0.4;  // two walls

  int floors, columns;
  std::vector<Place> rooms;
};

// The way through all of it, the corners of a closed curve, at the height of the eyes.
std::vector<Eigen::Vector3d> BuildingRoute(const BuildingPlan& plan);

struct RoomPlan;
// Steps of the flight from a floor to the next, landings, handrails and pictures.
void AddFlight(const RoomPlan& staircase, int floor);

Scene MakeBuilding(std::uint64_t seed, const BuildingOptions& options);

}  // namespace surfit
