#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "simulation/item.h"
#include "simulation/random.h"
#include "surfit/simulation/scene.h"

namespace surfit {

// A furnished room; what stands where, its size and its colours vary with the seed.
Scene MakeRoom(std::uint64_t seed);

// An opening in a wall, 2.1 m high, that one can walk through.
struct Doorway {
  static constexpr double kWidth_m = 1.2, kHeight_m = 2.1;
  int wall;             // of RoomPlan::WallFrame()
  double at_m;          // of its middle, along the wall's foot
  double bottom_m = 0;  // above the wall's foot
};

// Something that takes up a stretch of wall.
struct Stretch {
  double width_m;
  std::function<void(const Item&)> add;
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
  double turn_rad = 0;  // of the room about its corner
  double height_m = kHeight_m;
  // Rooms alike are furnished by equal `random`; what is painted on pictures and rugs is of this,
  // unless null.
  Random* pictures = nullptr;
  bool keeps_light = false;  // its lamps light it alone

  Random* Pictures() const { return pictures != nullptr ? pictures : random; }
  Item Frame() const { return Item(scene, WorldFromRoom()); }
  Rigid3d WorldFromRoom() const {
    return {Eigen::Quaterniond(Eigen::AngleAxisd(turn_rad, Eigen::Vector3d::UnitZ())),
            corner_in_world};
  }
  // What its lamps light, for PointLight::lit: half of each doorway as well.
  Eigen::AlignedBox3d Lit() const;
  // What is between the walls.
  Eigen::AlignedBox3d SpaceInWorld() const;
  // Wall i's frame: x from 0 to WallLength(i) along its foot, y into the room, z up.
  Item WallFrame(int i) const;
  double WallLength(int i) const { return i % 2 == 0 ? width_m : depth_m; }
  // From left to right, and from the floor up.
  std::vector<Doorway> DoorwaysIn(int wall) const;
  // A doorway at this place of the floor, in the wall that is nearest.
  void OpenAt(const Eigen::Vector3d& point_in_world);
};

// Floor, ceiling and four walls with skirting boards, open where there are doorways.
void AddShell(const RoomPlan& room);

// Shell, lamp and furniture; posters beside doorways, and nothing before them.
void AddFurnishedRoom(const RoomPlan& room);

// Puts the stretches side by side in random order along the wall, from one place of it to another,
// with random gaps, which are worth a look where they are wide.
void Line(const RoomPlan& room, int wall, double from_m, double to_m,
          std::vector<Stretch> stretches);

// A picture on the wall, and a look at it.
Stretch PosterStretch(const RoomPlan& room);

// Shell, lamps, and things along the walls that leave the middle free.
void AddFurnishedCorridor(const RoomPlan& corridor);

}  // namespace surfit
