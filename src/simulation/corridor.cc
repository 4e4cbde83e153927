#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "simulation/item.h"
#include "simulation/random.h"
#include "simulation/room.h"

namespace surfit {
namespace {

using Eigen::Vector3d;

void AddLamps(const RoomPlan& corridor) {
  constexpr double kApart_m = 5, kBelowCeiling_m = 0.3;
  const double length = std::max(corridor.width_m, corridor.depth_m);
  const int lamps = static_cast<int>(std::ceil(length / kApart_m));
  for (int i = 0; i < lamps; ++i) {
    const double share = (i + 0.5) / lamps;
    Vector3d at(corridor.width_m / 2, corridor.depth_m / 2, corridor.height_m);
    (corridor.width_m > corridor.depth_m ? at.x() : at.y()) = share * length;
    corridor.Frame().Add(MakeBox({0.5, 0.5, 0.04}), at - Vector3d(0, 0, 0.02),
                         Plain(Color::Constant(0.8f)), 1.f);
    corridor.scene->lights.push_back(
        {corridor.Frame().InWorld(at - Vector3d(0, 0, kBelowCeiling_m)), 0.7f, false,
         corridor.Lit()});
  }
}

WallItem RandomStretch(const RoomPlan& corridor) {
  Random* random = corridor.random;
  const double width = random->Uniform(0.8, 1.3);
  switch (random->Index(8)) {
    case 0:
      return {width, [=](const Item& at) { AddBookshelf(at, width, random); }};
    case 1:
      return {width, [=](const Item& at) { AddCabinet(at, width, random); }};
    case 2:
      return {0.6, [=](const Item& at) { AddCrates(at, random); }};
    case 3:
      return {0.8, [=](const Item& at) { AddWallShelf(at.At({0, 0, 1.45}), 0.8, random); }};
    case 4:
      return {0.6, [=](const Item& at) { AddPlant(at.At({0, 0.3, 0}), random); }};
    case 5:
      return {0.5, [=](const Item& at) { AddChair(at.At({0, 0.3, 0}), random); }};
    default:
      return PosterItem(corridor);
  }
}

// Fills 75 % of the wall length with items, so that registration is constrained everywhere.
void FurnishWallPart(const RoomPlan& corridor, int wall, double from_m, double to_m) {
  constexpr double kShareOfWall = 0.75;
  double free = kShareOfWall * (to_m - from_m);
  std::vector<WallItem> stretches;
  while (free > 0) {
    WallItem next = RandomStretch(corridor);
    free -= next.width_m;
    if (free > 0) stretches.push_back(std::move(next));
  }
  Line(corridor, wall, from_m, to_m, std::move(stretches));
}

}  // namespace

void AddFurnishedCorridor(const RoomPlan& corridor) {
  constexpr double kCorner_m = 0.15, kBesideDoorway_m = 0.3 + Doorway::kWidth_m / 2;
  AddShell(corridor);
  AddLamps(corridor);
  for (int wall = 0; wall < 4; ++wall) {
    const double length = corridor.WallLength(wall);
    if (length < std::max(corridor.width_m, corridor.depth_m)) continue;  // end walls stay empty
    double from = kCorner_m;
    for (const Doorway& doorway : corridor.DoorwaysIn(wall)) {
      FurnishWallPart(corridor, wall, from, doorway.at_m - kBesideDoorway_m);
      from = doorway.at_m + kBesideDoorway_m;
    }
    FurnishWallPart(corridor, wall, from, length - kCorner_m);
  }
}

}  // namespace surfit
