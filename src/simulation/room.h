#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "simulation/item.h"
#include "simulation/random.h"
#include "surfit/simulation/scene.h"

namespace surfit {

// Furnished room. Size, furniture and colours depend on the seed.
Scene MakeRoom(std::uint64_t seed);

// Opening in a wall of a room, see RoomPlan::WallFrame().
struct Doorway {
  static constexpr double kWidth_m = 1.2, kHeight_m = 2.1;
  int wall;             // number of the wall, 0 to 3
  double at_m;          // x of the middle in the wall frame
  double bottom_m = 0;  // z of the lower edge in the wall frame
};

// Item that Line() places at a wall. `add` places the item. The origin of its argument is the
// middle of the width.
struct WallItem {
  double width_m;
  std::function<void(const Item&)> add;
};

// Plan of a rectangular room. Does not own `scene` and the random numbers. AddShell() and the
// furniture require `random`. Several rooms can share a scene.
struct RoomPlan {
  static constexpr double kHeight_m = 2.5;
  static constexpr double kThick_m = 0.2;  // thickness of walls, floor and ceiling, outwards

  Scene* scene;
  Random* random;
  double width_m, depth_m;  // x in [0, width_m], y in [0, depth_m], floor at z = 0
  Eigen::Vector3d corner_in_world = Eigen::Vector3d::Zero();
  std::vector<Doorway> doorways = {};
  double turn_rad = 0;
  double height_m = kHeight_m;
  // Random numbers of pictures and rugs; null: `random`. Rooms with equal `random` have equal
  // furniture.
  Random* pictures = nullptr;
  bool lights_only_itself = false;  // lamps do not light other rooms

  Random* Pictures() const { return pictures != nullptr ? pictures : random; }
  Item Frame() const { return Item(scene, WorldFromRoom()); }
  // Maps the room frame to the world frame: turn about z, then shift, m.
  Rigid3d WorldFromRoom() const {
    return {Eigen::Quaterniond(Eigen::AngleAxisd(turn_rad, Eigen::Vector3d::UnitZ())),
            corner_in_world};
  }
  // Region of PointLight::lit: the room extended by the wall thickness. Without lights_only_itself,
  // the region is empty, which means everywhere.
  Eigen::AlignedBox3d Lit() const;
  // Space between walls, floor and ceiling, in the world frame, m.
  Eigen::AlignedBox3d SpaceInWorld() const;
  // Frame of wall i: x from 0 to WallLength(i) along its lower edge, y into the room, z up. Walls 0
  // to 3 are counterclockwise, seen from above. Wall 0 is on the x axis of the room, from its
  // origin.
  Item WallFrame(int i) const;
  double WallLength(int i) const { return i % 2 == 0 ? width_m : depth_m; }
  // Doorways of a wall by ascending x in the wall frame, then from bottom to top.
  std::vector<Doorway> DoorwaysIn(int wall) const;
  // Adds a doorway in the nearest wall. `point_in_world`: middle of its lower edge.
  void OpenAt(const Eigen::Vector3d& point_in_world);
};

// Adds floor, ceiling, and walls with skirting boards and doorways.
void AddShell(const RoomPlan& room);

// Adds shell, lamp and furniture. Walls with a doorway have only posters.
void AddFurnishedRoom(const RoomPlan& room);

// Adds items along a wall from `from_m` to `to_m`, in random order with random gaps. Items that are
// too wide together extend beyond `to_m`. Wide gaps become camera targets.
void Line(const RoomPlan& room, int wall, double from_m, double to_m,
          std::vector<WallItem> stretches);

// Poster of random size, with a camera target below it.
WallItem PosterItem(const RoomPlan& room);

// Adds shell, lamps, and items along the two long walls.
void AddFurnishedCorridor(const RoomPlan& corridor);

}  // namespace surfit
