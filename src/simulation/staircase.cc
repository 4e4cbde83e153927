#include <cmath>

#include "simulation/building.h"
#include "simulation/item.h"
#include "simulation/random.h"
#include "simulation/room.h"

namespace surfit {
namespace {

using Eigen::Vector3d;

constexpr int kSteps = 20;
constexpr double kRise_m = BuildingPlan::kStorey_m / kSteps;
constexpr double kThick_m = 0.25;

double Tread(const RoomPlan& staircase) {
  return (staircase.depth_m - 2 * BuildingPlan::kCorridor_m) / kSteps;
}

void AddSteps(const RoomPlan& staircase, const Item& flight, bool on_ground) {
  const double width = staircase.width_m, tread = Tread(staircase);
  const Texture wood = RandomWood(0, staircase.random);
  for (int i = 1; i <= kSteps; ++i) {
    const double y = BuildingPlan::kCorridor_m + (i - 1) * tread, top = i * kRise_m;
    const double bottom = on_ground ? 0 : top - kRise_m - kThick_m;
    flight.Box({0, y, bottom}, {width, y + tread, top}, wood);
  }
  const double y = staircase.depth_m - BuildingPlan::kCorridor_m, top = BuildingPlan::kStorey_m;
  flight.Box({0, y, on_ground ? 0 : top - kThick_m}, {width, staircase.depth_m, top}, wood);
  if (!on_ground) flight.Box({0, 0, -kThick_m}, {width, BuildingPlan::kCorridor_m, 0}, wood);
}

void AddWallThings(const RoomPlan& staircase, const Item& flight) {
  constexpr double kApart_m = 1.5, kRail_m = 0.95, kFromWall_m = 0.07;
  Random* random = staircase.random;
  const double begin = BuildingPlan::kCorridor_m, end = staircase.depth_m - begin;
  const Texture metal = Plain(Color::Constant(0.3f));
  for (const double x : {0.0, staircase.width_m}) {
    const double inward = x == 0 ? 1 : -1;
    const double rail_x = x + inward * kFromWall_m;
    flight.Rod({rail_x, begin, kRail_m}, {rail_x, end, BuildingPlan::kStorey_m + kRail_m}, 0.025,
               metal);
    for (double y = begin + random->Uniform(0.3, 0.9); y < end - 0.3;
         y += kApart_m * random->Uniform(0.8, 1.2)) {
      const double floor = (y - begin) / (end - begin) * BuildingPlan::kStorey_m;
      // Frame on the wall. Its y axis points into the staircase.
      const Item at = flight.At({x, y, floor}, -inward * M_PI / 2);
      const double height = random->Uniform(0.4, 0.8), width = random->Uniform(0.4, 0.8);
      AddPoster(at.At({0, 0, random->Uniform(1.2, 1.4)}), width, height, random);
      at.Target({0, 0, random->Uniform(0.3, 1.3)});
      at.Target({random->Uniform(-0.5, 0.5), 0.5, 0});
    }
  }
}

void AddLandingThings(const RoomPlan& staircase, const Item& landing, double wall_y) {
  const double inward = wall_y == 0 ? 1 : -1;
  const Item wall = landing.At({staircase.width_m / 2, wall_y, 0}, inward > 0 ? 0 : M_PI);
  AddPoster(wall.At({0, 0, 1.1}), 0.9, 0.7, staircase.random);
  AddPlant(wall.At({-0.65, 0.3, 0}), staircase.random);
  AddCrates(wall.At({0.55, 0, 0}), staircase.random);
  wall.Target({0, 0, 1});
}

void AddLamp(const RoomPlan& staircase, const Vector3d& at) {
  const Item lamp = staircase.Frame().At(at);
  lamp.Add(MakeSphere(0.1), {0, 0, 0}, Plain(Color::Constant(0.8f)), 1.f);
  staircase.scene->lights.push_back(
      {lamp.InWorld({staircase.width_m / 2 - at.x(), 0, -0.2}), 0.7f, false, staircase.Lit()});
}

}  // namespace

void AddFlight(const RoomPlan& staircase, int floor) {
  const double z = floor * BuildingPlan::kStorey_m;
  const Item flight = staircase.Frame().At({0, 0, z});
  AddSteps(staircase, flight, floor == 0);
  AddWallThings(staircase, flight);
  AddLandingThings(staircase, flight, 0);
  AddLandingThings(staircase, flight.At({0, 0, BuildingPlan::kStorey_m}), staircase.depth_m);
  constexpr int kLamps = 3;
  for (int i = 0; i < kLamps; ++i) {
    const double share = (i + 0.5) / kLamps;
    AddLamp(staircase, {0.1, share * staircase.depth_m, z + share * BuildingPlan::kStorey_m + 2.2});
  }
}

}  // namespace surfit
