#include "simulation/room.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace surfit {
namespace {

using Eigen::Vector3d;

template <typename Container>
void Shuffle(Container* items, Random* random) {
  for (std::size_t i = items->size(); i > 1; --i) {
    std::swap((*items)[i - 1], (*items)[random->Index(static_cast<int>(i))]);
  }
}

void AddCeilingLamp(const RoomPlan& room) {
  const double y = room.depth_m / 2 + room.random->Uniform(-0.4, 0.4),
               x = room.width_m / 2 + room.random->Uniform(-0.4, 0.4);
  const Vector3d above(x, y, RoomPlan::kHeight_m);
  const Item lamp = room.Frame().At(above);
  lamp.Rod({0, 0, -0.22}, {0, 0, 0}, 0.008, Plain(Color::Constant(0.2f)));
  lamp.Add(MakeSphere(0.12), {0, 0, -0.3}, Plain(Color::Constant(0.8f)), 1.f);
  room.scene->lights.push_back(
      {room.Frame().InWorld(above - Vector3d(0, 0, 0.45)), 1.15f, true, room.Lit()});
}

void LineWall(const RoomPlan& room, int wall, std::vector<WallItem> stretches) {
  constexpr double kCorner_m = 0.8;
  Line(room, wall, kCorner_m, room.WallLength(wall) - kCorner_m, std::move(stretches));
}

void AddReadingWall(const RoomPlan& room, int wall) {
  Random* random = room.random;
  const double width = random->Uniform(1.2, 1.8);
  LineWall(room, wall,
           {{width, [=](const Item& at) { AddBookshelf(at, width, random); }},
            {0.3,
             [=](const Item& at) {
               AddClock(at.At({0, 0, 1.5}), random);
             }},
            PosterItem(room)});
}

void AddSofaWall(const RoomPlan& room, int wall) {
  Random* random = room.random;
  const double width = random->Uniform(1.5, 2.1);
  const auto sofa_and_poster = [=](const Item& at) {
    AddSofa(at, width, random);
    AddPoster(at.At({random->Uniform(-0.3, 0.3), 0, 1.2}), 0.8, 0.6, room.Pictures());
  };
  LineWall(room, wall, {{width, sofa_and_poster}, PosterItem(room)});
}

void AddCabinetWall(const RoomPlan& room, int wall) {
  Random* random = room.random;
  const double width = random->Uniform(1.2, 1.7), curtain = random->Uniform(0.6, 0.9);
  LineWall(room, wall,
           {{width, [=](const Item& at) { AddCabinet(at, width, random); }},
            {curtain, [=](const Item& at) {
               AddCurtain(at, curtain, RoomPlan::kHeight_m - 0.15, random);
               at.Target({0, 0.1, 0.9});
             }}});
}

void AddBareWall(const RoomPlan& room, int wall) {
  Random* random = room.random;
  const auto shelf = [=](const Item& at) { AddWallShelf(at.At({0, 0, 1.45}), 0.8, random); };
  const auto crate = [=](const Item& at) { AddCrates(at, random); };
  LineWall(room, wall,
           {{1.0, [=](const Item& at) { AddDoor(at, random); }}, {0.8, shelf}, {0.6, crate}});
  const double length = room.WallLength(wall);
  double share = 0.2;
  while (share < 0.85) {
    room.WallFrame(wall).Target({share * length, 0, random->Uniform(0.3, 1.2)});
    share += 0.05;
  }
}

void AddPostersBesideDoorway(const RoomPlan& room, int wall, const Doorway& doorway) {
  for (const double side : {-1, 1}) {
    const double edge = doorway.at_m + side * Doorway::kWidth_m / 2;
    const double corner = side < 0 ? 0 : room.WallLength(wall);
    const double width = std::min(0.6, 0.5 * std::abs(corner - edge));
    const Item at = room.WallFrame(wall).At({(edge + corner) / 2, 0, 0});
    AddPoster(at.At({0, 0, 1.1}), width, room.random->Uniform(0.5, 0.9), room.Pictures());
    at.Target({0, 0, 0.9});
  }
}

void AddWalls(const RoomPlan& room) {
  std::array<void (*)(const RoomPlan&, int), 4> walls = {&AddReadingWall, &AddSofaWall,
                                                         &AddCabinetWall, &AddBareWall};
  Shuffle(&walls, room.random);
  for (int i = 0; i < 4; ++i) {
    const std::vector<Doorway> doorways = room.DoorwaysIn(i);
    doorways.empty() ? walls[i](room, i) : AddPostersBesideDoorway(room, i, doorways[0]);
  }
}

void AddBall(const Item& item, Random* random) {
  const double radius = random->Uniform(0.11, 0.2);
  const Color second = RandomPaint(random), first = RandomPaint(random);
  item.Add(MakeSphere(radius), {0, 0, radius}, Checks(first, second, 0.9 * radius));
  item.Target({0, 0, radius});
}

void AddBin(const Item& item, Random* random) {
  item.Cone(Vector3d::Zero(), 0.11, 0.15, 0.34, Plain(RandomPaint(random)));
  item.Target({0, 0, 0.2});
}

void AddCorners(const RoomPlan& room) {
  std::array<void (*)(const Item&, Random*), 4> things = {&AddPlant, &AddFloorLamp, &AddBall,
                                                          &AddBin};
  Shuffle(&things, room.random);
  for (int i = 0; i < 4; ++i) things[i](room.WallFrame(i).At({0.38, 0.38, 0}), room.random);
}

void AddMiddle(const RoomPlan& room) {
  Random* random = room.random;
  const double across = room.depth_m / 2 + random->Uniform(-0.3, 0.3),
               along = room.width_m / 2 + random->Uniform(-0.5, 0.5);
  const Item place = room.Frame().At({along, across, 0}, random->Uniform(0, M_PI));
  place.Box({-1.1, -0.8, 0}, {1.1, 0.8, 0.01}, Rug(2.2, 1.6, room.Pictures()->Index(1 << 30)));
  const double width = random->Uniform(1.1, 1.5), depth = random->Uniform(0.7, 0.9);
  AddTable(place, width, depth, random);
  for (const double side : {-1, 1}) {
    const double x = random->Uniform(-0.25, 0.25),
                 y = side * (depth / 2 + random->Uniform(0.1, 0.3));
    AddChair(place.At({x, y, 0}, (side > 0 ? M_PI : 0) + random->Uniform(-0.4, 0.4)), random);
  }
  const double turn = M_PI / 2 + random->Uniform(-0.4, 0.4);
  AddChair(place.At({width / 2 + 0.3, random->Uniform(-0.1, 0.1), 0}, turn), random);
}

// Adds a random item beside the doorway. This item distinguishes rooms with equal furniture.
void AddKeepsake(const RoomPlan& room) {
  constexpr std::array<void (*)(const Item&, Random*), 3> kThings = {&AddBall, &AddBin, &AddRing};
  const Item at = room.WallFrame(0).At({room.pictures->Uniform(0.9, 1.4), 0.4, 0});
  kThings[room.pictures->Index(3)](at, room.pictures);
}

}  // namespace

void Line(const RoomPlan& room, int wall, double from_m, double to_m,
          std::vector<WallItem> stretches) {
  Shuffle(&stretches, room.random);
  double free = to_m - from_m;
  for (const WallItem& stretch : stretches) free -= stretch.width_m;
  double x = from_m;
  for (const WallItem& stretch : stretches) {
    const double gap = std::max(0.0, room.random->Uniform(0, free));
    free -= gap;
    constexpr double kPlainWall_m = 0.5;
    if (gap > kPlainWall_m) {
      room.WallFrame(wall).Target({x + gap / 2, 0, room.random->Uniform(0.3, 1.1)});
    }
    x += gap;
    stretch.add(room.WallFrame(wall).At({x + stretch.width_m / 2, 0, 0}));
    x += stretch.width_m;
  }
}

WallItem PosterItem(const RoomPlan& room) {
  const double width = room.random->Uniform(0.4, 0.7), height = room.random->Uniform(0.5, 0.9);
  return {width, [=](const Item& at) {
            AddPoster(at.At({0, 0, 1.1}), width, height, room.Pictures());
            at.Target({0, 0, 0.9});
          }};
}

void AddFurnishedRoom(const RoomPlan& room) {
  AddShell(room);
  AddCeilingLamp(room);
  AddWalls(room);
  AddCorners(room);
  AddMiddle(room);
  if (room.pictures != nullptr) AddKeepsake(room);
}

Scene MakeRoom(std::uint64_t seed) {
  Scene scene;
  Random random(seed);
  const RoomPlan room{&scene, &random, random.Uniform(5, 6.5), random.Uniform(4.6, 5.6)};
  AddFurnishedRoom(room);
  constexpr double kFromWall_m = 1.0, kLow_m = 1.2, kHigh_m = 1.6;
  scene.camera_space = Eigen::AlignedBox3d(
      Vector3d(kFromWall_m, kFromWall_m, kLow_m),
      Vector3d(room.width_m - kFromWall_m, room.depth_m - kFromWall_m, kHigh_m));
  return scene;
}

}  // namespace surfit
