#include "simulation/building.h"

#include <utility>

#include "simulation/random.h"
#include "simulation/room.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"

namespace surfit {
namespace {

using Eigen::Vector3d;
using Row = BuildingPlan::Row;

constexpr int kRows = 4;

// Random streams of one seed are independent. The structure has one stream. Furniture has one
// stream per two rooms, and pictures have one stream per room.
constexpr int kMaxRooms = 2000;
enum Stream : std::uint64_t { kStructure = 1, kFurniture = 1000, kPictures = 2000 };
static_assert(kFurniture + kMaxRooms / 2 <= kPictures, "streams must not overlap");

bool HasDoorwayInTheSouth(Row row) { return row == Row::kInnerSouth || row == Row::kOuterNorth; }

BuildingPlan::Place PlaceOf(int floor, int column, Row row) {
  constexpr double kDepth_m = BuildingPlan::kRoomDepth_m, kGap_m = BuildingPlan::kGap_m,
                   kCorridor_m = BuildingPlan::kCorridor_m, kWidth_m = BuildingPlan::kRoomWidth_m;
  const double south[] = {-kGap_m - kDepth_m, kCorridor_m + kGap_m,
                          kCorridor_m + 2 * kGap_m + kDepth_m, BuildingPlan::Depth() + kGap_m};
  BuildingPlan::Place place = {floor, column, row, {}, {}};
  const Vector3d corner(column * (kWidth_m + kGap_m), south[static_cast<int>(row)],
                        floor * BuildingPlan::kStorey_m);
  const bool is_turned = !HasDoorwayInTheSouth(row);
  place.world_from_room = {
      Eigen::Quaterniond(Eigen::AngleAxisd(is_turned ? M_PI : 0, Vector3d::UnitZ())),
      is_turned ? Vector3d(corner + Vector3d(kWidth_m, kDepth_m, 0)) : corner};
  place.doorway = place.world_from_room * Vector3d(kWidth_m / 2, -kGap_m / 2, 0);
  return place;
}

struct Site {
  const BuildingPlan& plan;
  Scene* scene;
  std::uint64_t seed;

  RoomPlan Cell(double west, double south, int floor, double width_m, double depth_m) const {
    RoomPlan cell{scene, nullptr, width_m, depth_m};
    cell.corner_in_world = {west, south, floor * BuildingPlan::kStorey_m};
    cell.lights_only_itself = true;
    return cell;
  }
};

// Calls `furnish`, and adds a SceneCell with the gaze targets that `furnish` created.
template <typename Furnish>
void AddCell(const RoomPlan& cell, Furnish furnish) {
  Scene& scene = *cell.scene;
  SceneCell added;
  added.space = cell.SpaceInWorld();
  const std::size_t before = scene.targets.size();
  furnish(cell);
  for (std::size_t i = before; i < scene.targets.size(); ++i) {
    added.targets.push_back(static_cast<int>(i));
  }
  scene.cells.push_back(std::move(added));
}

// Furnishes a room. Rooms 2 k and 2 k + 1 have equal furniture and different pictures.
void AddRoom(const Site& site, int index) {
  const BuildingPlan::Place& place = site.plan.rooms[index];
  Random furniture(site.seed, kFurniture + index / 2), pictures(site.seed, kPictures + index);
  RoomPlan room{site.scene, &furniture, BuildingPlan::kRoomWidth_m, BuildingPlan::kRoomDepth_m};
  room.corner_in_world = place.world_from_room.translation;
  room.turn_rad = HasDoorwayInTheSouth(place.row) ? 0 : M_PI;
  room.pictures = &pictures;
  room.lights_only_itself = true;
  room.OpenAt(place.doorway);
  AddCell(room, &AddFurnishedRoom);
}

void AddCorridors(const Site& site, int floor, Random* random) {
  constexpr double kCorridor_m = BuildingPlan::kCorridor_m, kGap_m = BuildingPlan::kGap_m;
  const BuildingPlan& plan = site.plan;
  const double z = floor * BuildingPlan::kStorey_m;
  for (const bool is_north : {false, true}) {
    const double south = is_north ? BuildingPlan::Depth() - kCorridor_m : 0;
    RoomPlan along = site.Cell(0, south, floor, plan.Length(), kCorridor_m);
    along.random = random;
    const double aisle = south + kCorridor_m / 2;
    along.OpenAt({-kGap_m / 2, aisle, z});
    along.OpenAt({plan.Length() + kGap_m / 2, aisle, z});
    for (const BuildingPlan::Place& room : plan.rooms) {
      const bool is_off_north = room.row == Row::kInnerNorth || room.row == Row::kOuterNorth;
      if (room.floor == floor && is_off_north == is_north) along.OpenAt(room.doorway);
    }
    AddCell(along, &AddFurnishedCorridor);
  }
  for (const bool is_east : {false, true}) {
    const double west = is_east ? plan.Length() + kGap_m : -kGap_m - kCorridor_m;
    RoomPlan across = site.Cell(west, 0, floor, kCorridor_m, BuildingPlan::Depth());
    across.random = random;
    const double inner = is_east ? west - kGap_m / 2 : west + kCorridor_m + kGap_m / 2;
    const double outer = is_east ? west + kCorridor_m + kGap_m / 2 : west - kGap_m / 2;
    const double south = BuildingPlan::SouthAisle(), north = BuildingPlan::NorthAisle();
    across.OpenAt({inner, south, z});
    across.OpenAt({inner, north, z});
    if (floor + 1 < plan.floors) across.OpenAt({outer, south, z});
    if (floor > 0) across.OpenAt({outer, north, z});
    AddCell(across, &AddFurnishedCorridor);
  }
}

void AddStaircase(const Site& site, bool is_east, Random* random) {
  constexpr double kWidth_m = BuildingPlan::kStaircase_m, kGap_m = BuildingPlan::kGap_m;
  const BuildingPlan& plan = site.plan;
  const double aisle = plan.StaircaseAisle(is_east);
  const double corridor_side = aisle + (is_east ? -1 : 1) * (kWidth_m + kGap_m) / 2;
  RoomPlan staircase = site.Cell(aisle - kWidth_m / 2, 0, 0, kWidth_m, BuildingPlan::Depth());
  staircase.height_m = (plan.floors - 1) * BuildingPlan::kStorey_m + RoomPlan::kHeight_m;
  staircase.random = random;
  for (int floor = 0; floor + 1 < plan.floors; ++floor) {
    const double z = floor * BuildingPlan::kStorey_m;
    staircase.OpenAt({corridor_side, BuildingPlan::SouthAisle(), z});
    staircase.OpenAt({corridor_side, BuildingPlan::NorthAisle(), z + BuildingPlan::kStorey_m});
  }
  AddCell(staircase, [&](const RoomPlan& cell) {
    AddShell(cell);
    for (int floor = 0; floor + 1 < plan.floors; ++floor) AddFlight(cell, floor);
  });
}

}  // namespace

void BuildingOptions::Visit(OptionVisitor& v) {
  v.Add(floors, "floors", "number of floors of the scene building", Between(1, 100));
  v.Add(rooms, "rooms", "total number of rooms of the scene building, a multiple of floors",
        Between(1, kMaxRooms));
  v.Check([this] {
    if (rooms % floors == 0) return;
    throw InputError("rooms is ", rooms, ", must be a multiple of floors (", floors, ")");
  });
}

BuildingPlan::BuildingPlan(const BuildingOptions& options) {
  Validate(options);
  floors = options.floors;
  const int on_floor = options.rooms / floors;
  columns = (on_floor + kRows - 1) / kRows;
  for (int i = 0; i < options.rooms; ++i) {
    const int in_floor = i % on_floor;
    rooms.push_back(
        PlaceOf(i / on_floor, in_floor % columns, static_cast<Row>(in_floor / columns)));
  }
}

double BuildingPlan::StaircaseAisle(bool east) const {
  const double west_aisle = -2 * kGap_m - kCorridor_m - kStaircase_m / 2;
  return east ? Length() - west_aisle : west_aisle;
}

Scene MakeBuilding(std::uint64_t seed, const BuildingOptions& options) {
  const BuildingPlan plan(options);
  Scene scene;
  const Site site = {plan, &scene, seed};
  for (int i = 0; i < static_cast<int>(plan.rooms.size()); ++i) AddRoom(site, i);
  Random structure(seed, kStructure);
  for (int floor = 0; floor < plan.floors; ++floor) AddCorridors(site, floor, &structure);
  if (plan.floors > 1) {
    for (const bool is_east : {false, true}) AddStaircase(site, is_east, &structure);
  }
  scene.route = BuildingRoute(plan);
  for (const Vector3d& corner : scene.route) scene.camera_space.extend(corner);
  return scene;
}

}  // namespace surfit
