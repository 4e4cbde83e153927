#include <cmath>

#include "simulation/room.h"

namespace surfit {
namespace {

using Eigen::Vector3d;

void AddWall(const RoomPlan& room, int i, const Texture& paint) {
  constexpr double kThick_m = RoomPlan::kThick_m, kHeight_m = RoomPlan::kHeight_m;
  const Item wall = room.WallFrame(i);
  const double length = room.WallLength(i);
  const Texture board = Plain(Color::Constant(0.55f));
  const auto piece = [&](double from, double to, double bottom) {
    wall.Box({from, -kThick_m, bottom}, {to, 0, kHeight_m}, paint);
  };
  const auto skirting = [&](double from, double to) {
    wall.Box({from, 0, 0}, {to, 0.015, 0.08}, board);
  };
  const std::optional<Doorway> doorway = room.DoorwayIn(i);
  if (!doorway) {
    piece(-kThick_m, length + kThick_m, 0);
    return skirting(0, length);
  }
  const double from = doorway->at_m - Doorway::kWidth_m / 2, to = from + Doorway::kWidth_m;
  piece(-kThick_m, from, 0);
  piece(to, length + kThick_m, 0);
  piece(from, to, Doorway::kHeight_m);
  skirting(0, from);
  skirting(to, length);
}

}  // namespace

Item RoomPlan::WallFrame(int i) const {
  const Vector3d corners[] = {{0, 0, 0}, {width_m, 0, 0}, {width_m, depth_m, 0}, {0, depth_m, 0}};
  return Frame().At(corners[i], i * M_PI / 2);
}

std::optional<Doorway> RoomPlan::DoorwayIn(int wall) const {
  for (const Doorway& doorway : doorways) {
    if (doorway.wall == wall) return doorway;
  }
  return std::nullopt;
}

void AddShell(const RoomPlan& room) {
  constexpr double kThick_m = RoomPlan::kThick_m, kHeight_m = RoomPlan::kHeight_m;
  Random& random = *room.random;
  const Item frame = room.Frame();
  const auto shade = static_cast<float>(random.Uniform(0.6, 1.1));
  const std::uint64_t seed = random.Index(1 << 30);
  frame.Box(
      {-kThick_m, -kThick_m, -kThick_m}, {room.width_m + kThick_m, room.depth_m + kThick_m, 0},
      Boards(shade * Color(0.45f, 0.3f, 0.18f), shade * Color(0.3f, 0.18f, 0.1f), 0.14, 1.2, seed));
  frame.Box({-kThick_m, -kThick_m, kHeight_m},
            {room.width_m + kThick_m, room.depth_m + kThick_m, kHeight_m + kThick_m},
            Plain(Color::Constant(0.78f)));
  const Color base(0.68f, 0.65f, 0.6f);
  for (int i = 0; i < 4; ++i) {
    const Color paint = 0.8f * base + 0.2f * RandomPaint(&random);
    AddWall(room, i, Mottled(paint, 0.5, 0.08f, seed + i));
  }
}

}  // namespace surfit
