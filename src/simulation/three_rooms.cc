#include <array>

#include "simulation/room.h"
#include "simulation/room_plan.h"

namespace surfit {
namespace {

using Eigen::Vector3d;

constexpr double kDoorwayY_m = 2.4;  // in the world: half the depth of a room or little less
constexpr double kCameraZ_m = 1.4;

// Through the doorways at x = first and x = second, on one side of each room there and on the other
// back. How far it goes into the outer rooms makes 21 m of it along x, and about 22.5 m with its
// bends: 1500 frames at 15 mm.
std::vector<Vector3d> Route(double first, double second) {
  constexpr double kLength_m = 21, kSide_m = 0.8, kBesideDoorway_m = 0.7;
  const double reach = (kLength_m - 2 * (second - first)) / 4 - 0.15;
  std::vector<Vector3d> route;
  const auto go = [&](double x, double y) { route.emplace_back(x, kDoorwayY_m + y, kCameraZ_m); };
  const auto pass = [&](double doorway, double direction) {
    go(doorway - direction * kBesideDoorway_m, 0);
    go(doorway + direction * kBesideDoorway_m, 0);
  };
  go(first - 0.6 * reach, -kSide_m);
  pass(first, 1);
  go((first + second) / 2, -kSide_m);
  pass(second, 1);
  go(second + 0.6 * reach, -kSide_m);
  go(second + reach, 0);
  go(second + 0.6 * reach, kSide_m);
  pass(second, -1);
  go((first + second) / 2, kSide_m);
  pass(first, -1);
  go(first - 0.6 * reach, kSide_m);
  go(first - reach, 0);
  return route;
}

}  // namespace

Scene MakeThreeRooms(std::uint64_t seed) {
  constexpr int kRooms = 3, kEastWall = 1, kWestWall = 3;
  constexpr double kBetween_m = 2 * RoomPlan::kThick_m;
  Scene scene;
  Random random(seed);
  std::array<double, kRooms - 1> doorways;  // x of their middles
  double x = 0;
  for (int i = 0; i < kRooms; ++i) {
    RoomPlan room{&scene, &random, random.Uniform(5, 6.5), random.Uniform(4.8, 5.6), {x, 0, 0}};
    if (i > 0) room.doorways.push_back({kWestWall, room.depth_m - kDoorwayY_m});
    if (i + 1 < kRooms) room.doorways.push_back({kEastWall, kDoorwayY_m});
    AddFurnishedRoom(room);
    x += room.width_m + kBetween_m;
    if (i + 1 < kRooms) doorways[i] = x - kBetween_m / 2;
  }
  scene.route = Route(doorways[0], doorways[1]);
  for (const Vector3d& corner : scene.route) scene.camera_space.extend(corner);
  return scene;
}

}  // namespace surfit
