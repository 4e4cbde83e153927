#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "simulation/item.h"
#include "simulation/random.h"
#include "surfit/simulation/scene.h"

namespace surfit {

// A furnished room; what stands where, its size and its colours vary with the seed.
Scene MakeRoom(std::uint64_t seed);

// An opening in a wall, from the floor up, that one can walk through.
struct Doorway {
  static constexpr double kWidth_m = 1.2, kHeight_m = 2.1;
  int wall;     // of RoomPlan::WallFrame()
  double at_m;  // of its middle, along the wall's foot
};

// Where the walls of a room are while it is being furnished.
struct RoomPlan {
  static constexpr double kHeight_m = 2.5;
  static constexpr double kThick_m = 0.2;  // of walls, floor and ceiling, outwards

  Scene* scene;
  Random* random;
  double width_m, depth_m;  // x from 0 to width_m, y from 0 to depth_m, the floor at z = 0
  Eigen::Vector3d corner_in_world = Eigen::Vector3d::Zero();
  std::vector<Doorway> doorways = {};

  Item Frame() const {
    return Item(scene, Rigid3d(Eigen::Quaterniond::Identity(), corner_in_world));
  }
  // Wall i's frame: x from 0 to WallLength(i) along its foot, y into the room, z up.
  Item WallFrame(int i) const;
  double WallLength(int i) const { return i % 2 == 0 ? width_m : depth_m; }
  std::optional<Doorway> DoorwayIn(int wall) const;
};

// Floor, ceiling and four walls with skirting boards, open where there are doorways.
void AddShell(const RoomPlan& room);

// Shell, lamp and furniture; posters beside doorways, and nothing before them.
void AddFurnishedRoom(const RoomPlan& room);

}  // namespace surfit
