#include <cmath>

#include "simulation/item.h"

namespace surfit {

using Eigen::Vector3d;

void AddBookshelf(const Item& item, double width_m, Random* random) {
  constexpr double kDepth_m = 0.3, kBoard_m = 0.02;
  const int shelves = 4 + random->Index(2);
  const double pitch = random->Uniform(0.33, 0.38), height = shelves * pitch + kBoard_m;
  const Texture wood = RandomWood(2, random), boards = RandomWood(0, random);
  const double half = width_m / 2;
  item.Box({-half, 0, 0}, {half, kBoard_m, height}, wood);
  for (const double side : {-1, 1}) {
    item.Box({side * half - kBoard_m / 2, 0, 0}, {side * half + kBoard_m / 2, kDepth_m, height},
             wood);
  }
  for (int i = 0; i <= shelves; ++i) {
    const double z = i * pitch;
    item.Box({-half, kBoard_m, z}, {half, kDepth_m, z + kBoard_m}, boards);
    if (i == shelves) break;
    const Item on_board = item.At({-half + 0.03, kBoard_m, z + kBoard_m});
    const double books = random->Uniform(0.35, 1) * (width_m - 0.06);
    AddRowOfBooks(on_board, books, 0.2, pitch - 0.06, random);
    if (books < width_m - 0.35) AddVase(item.At({half - 0.15, 0.16, z + kBoard_m}), random);
  }
  item.Target({0, kDepth_m, height / 2});
  item.Target({-half, kDepth_m, 0.3 * height});
  item.Target({half, kDepth_m, 0.7 * height});
}

void AddSofa(const Item& item, double width_m, Random* random) {
  const std::uint64_t seed = random->Index(1 << 30);
  const Texture cloth = Mottled(RandomPaint(random), 0.03, 0.5f, seed);
  const double half = width_m / 2, arm = 0.18;
  item.RoundedBox({-half, 0.05, 0.08}, {half, 0.85, 0.28}, 0.05, cloth);
  item.RoundedBox({-half, 0.02, 0.08}, {half, 0.24, 0.82}, 0.09, cloth);
  for (const double x : {-half, half - arm}) {
    item.RoundedBox({x, 0.05, 0.08}, {x + arm, 0.87, 0.6}, 0.08, cloth);
  }
  const int seats = width_m > 1.7 ? 3 : 2;
  const double seat = (width_m - 2 * arm) / seats;
  for (int i = 0; i < seats; ++i) {
    const double x = -half + arm + i * seat;
    item.RoundedBox({x, 0.2, 0.27}, {x + seat, 0.86, 0.44}, 0.06, cloth);
  }
  for (const double side : {-1, 1}) {
    const Color gap = RandomPaint(random), stripe = RandomPaint(random);
    const Texture pillow = Stripes(stripe, gap, 0.05, 0);
    const Eigen::Quaterniond lean(Eigen::AngleAxisd(random->Uniform(0.2, 0.4), Vector3d::UnitX()) *
                                  Eigen::AngleAxisd(side * 0.2, Vector3d::UnitY()));
    item.Add(MakeRoundedBox({0.4, 0.14, 0.38}, 0.06),
             Rigid3d(lean, Vector3d(side * (half - arm - 0.25), 0.36, 0.63)), pillow);
  }
  item.Target({0, 0.5, 0.45});
  item.Target({-half, 0.6, 0.5});
  item.Target({half, 0.6, 0.5});
}

void AddCabinet(const Item& item, double width_m, Random* random) {
  const double half = width_m / 2, height = random->Uniform(0.6, 0.85), depth = 0.42;
  const Texture body = RandomWood(0, random), knob = Plain(Color::Constant(0.4f));
  item.Box({-half, 0, 0.08}, {half, depth, height}, body);
  for (const double x : {-half + 0.05, half - 0.05}) {
    for (const double y : {0.05, depth - 0.05}) item.Rod({x, y, 0}, {x, y, 0.08}, 0.018, body);
  }
  const int columns = 2 + random->Index(2), rows = 1 + random->Index(3);
  const double door = width_m / columns, drawer = (height - 0.08) / rows;
  const Texture front = random->Index(2) == 0 ? Plain(RandomPaint(random)) : RandomWood(0, random);
  for (int i = 0; i < columns; ++i) {
    for (int j = 0; j < rows; ++j) {
      const double x = -half + i * door, z = 0.08 + j * drawer;
      item.Box({x + 0.012, depth, z + 0.012}, {x + door - 0.012, depth + 0.018, z + drawer - 0.012},
               front);
      item.Add(MakeSphere(0.016), {x + door / 2, depth + 0.03, z + drawer / 2}, knob);
    }
  }
  AddMonitor(item.At({random->Uniform(-0.2, 0.2), 0.15, height}), random);
  AddCup(item.At({-half + 0.15, 0.3, height}), random);
  AddBowlOfFruit(item.At({half - 0.2, 0.25, height}), random);
  item.Target({0, depth, height + 0.1});
  item.Target({-half, depth, 0.3});
  item.Target({half, depth, height});
}

void AddTable(const Item& item, double width_m, double depth_m, Random* random) {
  constexpr double kHeight_m = 0.72, kBoard_m = 0.03;
  const Texture wood = RandomWood(0, random), legs = RandomWood(2, random);
  const double x = width_m / 2, y = depth_m / 2;
  item.Box({-x, -y, kHeight_m - kBoard_m}, {x, y, kHeight_m}, wood);
  for (const double sx : {-1, 1}) {
    for (const double sy : {-1, 1}) {
      const Vector3d foot(sx * (x - 0.05), sy * (y - 0.05), 0);
      item.Rod(foot, foot + Vector3d(0, 0, kHeight_m - kBoard_m), 0.02, legs);
    }
    item.Box({sx * (x - 0.05) - 0.01, -y + 0.05, kHeight_m - 0.1},
             {sx * (x - 0.05) + 0.01, y - 0.05, kHeight_m - kBoard_m}, legs);
  }
  AddClutter(item.At({0, 0, kHeight_m}), width_m, depth_m, random);
  item.Target({0, 0, kHeight_m});
  item.Target({-x, y, kHeight_m});
  item.Target({x, -y, 0.4});
}

void AddChair(const Item& item, Random* random) {
  constexpr double kSeat_m = 0.44, kHalf_m = 0.2, kBack_m = 0.86, kLeg_m = 0.013;
  const Texture wood = RandomWood(2, random), seat = Plain(RandomPaint(random));
  item.RoundedBox({-kHalf_m - 0.01, -kHalf_m, kSeat_m - 0.03}, {kHalf_m + 0.01, kHalf_m, kSeat_m},
                  0.012, seat);
  for (const double x : {-kHalf_m + 0.02, kHalf_m - 0.02}) {
    item.Rod({x, kHalf_m - 0.02, 0}, {x, kHalf_m - 0.02, kSeat_m - 0.02}, kLeg_m, wood);
    item.Rod({x, -kHalf_m + 0.02, 0}, {x, -kHalf_m - 0.04, kBack_m}, kLeg_m, wood);
  }
  for (const double z : {0.58, 0.7, 0.82}) {
    const double y = -kHalf_m + 0.02 - 0.06 * z / kBack_m;
    item.Box({-kHalf_m + 0.02, y - 0.006, z - 0.025}, {kHalf_m - 0.02, y + 0.006, z + 0.025}, wood);
  }
  item.Target({0, 0, kSeat_m});
}

void AddCrates(const Item& item, Random* random) {
  double height = 0;
  for (double size = random->Uniform(0.38, 0.48); size > 0.2; size *= random->Uniform(0.6, 0.8)) {
    const double low = height + 0.002, turn = random->Uniform(-0.5, 0.5);
    height += 0.7 * size;
    item.At({0, 0.36, 0}, turn)
        .Box({-size / 2, -size / 2, low}, {size / 2, size / 2, height}, RandomWood(0, random));
  }
  item.Target({0, 0.36, 0.3});
}

void AddFloorLamp(const Item& item, Random* random) {
  const Texture metal = Plain(Color::Constant(0.22f)), shade = Plain({0.75f, 0.65f, 0.45f});
  const double height = random->Uniform(1.4, 1.65);
  item.Cone(Vector3d::Zero(), 0.15, 0.13, 0.025, metal);
  item.Rod({0, 0, 0.025}, {0, 0, height - 0.1}, 0.011, metal);
  item.Cone({0, 0, height - 0.14}, 0.2, 0.12, 0.28, shade, 0.5f);
  item.Target({0, 0, height - 0.3});
}

void AddPlant(const Item& item, Random* random) {
  const Texture pot = Plain(RandomPaint(random)), earth = Plain({0.1f, 0.07f, 0.05f});
  const std::uint64_t seed = random->Index(1 << 30);
  const Texture green = Mottled({0.12f, 0.3f, 0.08f}, 0.05, 0.9f, seed);
  item.Cone(Vector3d::Zero(), 0.12, 0.17, 0.32, pot);
  item.Add(MakeTorus(0.165, 0.014), {0, 0, 0.32}, pot);
  item.Cone({0, 0, 0.32}, 0.15, 0.15, 0.006, earth);
  const int stems = 7 + random->Index(4);
  for (int i = 0; i < stems; ++i) {
    const double azimuth = 2 * M_PI * i / stems + random->Uniform(-0.3, 0.3);
    const Vector3d outward(std::cos(azimuth), std::sin(azimuth), 0);
    const double height = random->Uniform(0.25, 0.8), reach = random->Uniform(0.05, 0.22);
    const Vector3d root = 0.05 * outward + Vector3d(0, 0, 0.31);
    const Vector3d tip = reach * outward + Vector3d(0, 0, 0.31 + height);
    item.Rod(root, tip, 0.006, green);
    for (const double share : {0.6, 0.8, 1.0}) {
      const Vector3d tilt = (Vector3d(0, 0, 1) + random->Uniform(0.4, 1.2) * outward).normalized();
      const Vector3d center = root + share * (tip - root) + 0.05 * outward;
      const double radius = random->Uniform(0.05, 0.09);
      item.Add(MakeFrustum(radius, radius, 0.004), Rigid3d(TurnZInto(tilt), center), green);
    }
  }
  item.Target({0, 0, 0.6});
}

}  // namespace surfit
