#include <algorithm>
#include <cmath>
#include <iterator>
#include <tuple>
#include <vector>

#include "simulation/room.h"

namespace surfit {
namespace {

using Eigen::Vector3d;

void AddWall(const RoomPlan& room, int i, const Texture& paint) {
  constexpr double kThick_m = RoomPlan::kThick_m;
  const Item wall = room.WallFrame(i);
  const double length = room.WallLength(i);
  const Texture board = Plain(Color::Constant(0.55f));
  const auto piece = [&](double from, double to, double bottom, double top) {
    if (top > bottom) wall.Box({from, -kThick_m, bottom}, {to, 0, top}, paint);
  };
  const auto skirting = [&](double from, double to) {
    wall.Box({from, 0, 0}, {to, 0.015, 0.08}, board);
  };
  const std::vector<Doorway> doorways = room.DoorwaysIn(i);
  double end = -kThick_m;
  double skirting_end = 0;
  for (std::size_t k = 0; k < doorways.size();) {
    const double at = doorways[k].at_m;
    const double from = at - Doorway::kWidth_m / 2, to = from + Doorway::kWidth_m;
    piece(end, from, 0, room.height_m);
    end = to;
    if (doorways[k].bottom_m == 0) {
      skirting(skirting_end, from);
      skirting_end = to;
    }
    double bottom = 0;
    for (; k < doorways.size() && doorways[k].at_m == at; ++k) {
      piece(from, to, bottom, doorways[k].bottom_m);
      bottom = doorways[k].bottom_m + Doorway::kHeight_m;
    }
    piece(from, to, bottom, room.height_m);
  }
  piece(end, length + kThick_m, 0, room.height_m);
  skirting(skirting_end, length);
}

}  // namespace

Eigen::AlignedBox3d RoomPlan::SpaceInWorld() const {
  Eigen::AlignedBox3d space(Vector3d::Zero(), Vector3d(width_m, depth_m, height_m));
  space.transform(Eigen::Isometry3d(WorldFromRoom().Matrix()));
  return space;
}

Eigen::AlignedBox3d RoomPlan::Lit() const {
  if (!lights_only_itself) return {};
  const Eigen::AlignedBox3d space = SpaceInWorld();
  return {space.min().array() - kThick_m, space.max().array() + kThick_m};
}

Item RoomPlan::WallFrame(int i) const {
  const Vector3d corners[] = {{0, 0, 0}, {width_m, 0, 0}, {width_m, depth_m, 0}, {0, depth_m, 0}};
  return Frame().At(corners[i], i * M_PI / 2);
}

std::vector<Doorway> RoomPlan::DoorwaysIn(int wall) const {
  std::vector<Doorway> in_wall;
  std::copy_if(doorways.begin(), doorways.end(), std::back_inserter(in_wall),
               [&](const Doorway& doorway) { return doorway.wall == wall; });
  std::sort(in_wall.begin(), in_wall.end(), [](const Doorway& a, const Doorway& b) {
    return std::tie(a.at_m, a.bottom_m) < std::tie(b.at_m, b.bottom_m);
  });
  return in_wall;
}

void RoomPlan::OpenAt(const Vector3d& point_in_world) {
  const Vector3d point = WorldFromRoom().Inverse() * point_in_world;
  const double to_wall[] = {point.y(), width_m - point.x(), depth_m - point.y(), point.x()};
  const double along[] = {point.x(), point.y(), width_m - point.x(), depth_m - point.y()};
  const auto wall = std::min_element(std::begin(to_wall), std::end(to_wall)) - to_wall;
  constexpr double kGrid_m = 1e-6;  // m; rounding step, so that stacked doorways have equal at_m
  doorways.push_back({static_cast<int>(wall), kGrid_m * std::round(along[wall] / kGrid_m),
                      kGrid_m * std::round(point.z() / kGrid_m)});
}

void AddShell(const RoomPlan& room) {
  constexpr double kThick_m = RoomPlan::kThick_m;
  Random& random = *room.random;
  const Item frame = room.Frame();
  const auto shade = static_cast<float>(random.Uniform(0.6, 1.1));
  const std::uint64_t seed = random.Index(1 << 30);
  frame.Box(
      {-kThick_m, -kThick_m, -kThick_m}, {room.width_m + kThick_m, room.depth_m + kThick_m, 0},
      Boards(shade * Color(0.45f, 0.3f, 0.18f), shade * Color(0.3f, 0.18f, 0.1f), 0.14, 1.2, seed));
  frame.Box({-kThick_m, -kThick_m, room.height_m},
            {room.width_m + kThick_m, room.depth_m + kThick_m, room.height_m + kThick_m},
            Plain(Color::Constant(0.78f)));
  const Color base(0.68f, 0.65f, 0.6f);
  for (int i = 0; i < 4; ++i) {
    const Color paint = 0.8f * base + 0.2f * RandomPaint(&random);
    AddWall(room, i, Mottled(paint, 0.5, 0.08f, seed + i));
  }
}

}  // namespace surfit
