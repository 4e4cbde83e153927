#include <algorithm>
#include <cmath>

#include "simulation/item.h"

namespace surfit {

using Eigen::Vector3d;

void AddCup(const Item& item, Random* random) {
  const Texture glaze = Plain(RandomPaint(random));
  const double height = random->Uniform(0.08, 0.11), radius = random->Uniform(0.035, 0.045);
  const Item turned = item.At(Vector3d::Zero(), random->Uniform(0, 2 * M_PI));
  turned.Cone(Vector3d::Zero(), 0.85 * radius, radius, height, glaze);
  const Eigen::Quaterniond upright(Eigen::AngleAxisd(M_PI / 2, Vector3d::UnitX()));
  turned.Add(MakeTorus(0.3 * height, 0.006),
             Rigid3d(upright, Vector3d(0.95 * radius, 0, 0.5 * height)), glaze);
}

void AddPileOfBooks(const Item& item, Random* random) {
  const int books = 2 + random->Index(4);
  double z = 0;
  for (int i = 0; i < books; ++i) {
    const double thickness = random->Uniform(0.015, 0.045);
    const double width = random->Uniform(0.14, 0.2), depth = random->Uniform(0.2, 0.26);
    const Item turned = item.At({0, 0, z}, random->Uniform(-0.4, 0.4));
    const double band = random->Uniform(0.05, 0.12);
    const Color gap = RandomPaint(random), stripe = RandomPaint(random);
    turned.Box({-width / 2, -depth / 2, 0}, {width / 2, depth / 2, thickness},
               Stripes(stripe, gap, band, 1));
    z += thickness;
  }
}

void AddBowlOfFruit(const Item& item, Random* random) {
  const Texture glaze = Plain(RandomPaint(random));
  item.Cone(Vector3d::Zero(), 0.06, 0.13, 0.06, glaze);
  item.Add(MakeTorus(0.128, 0.008), {0, 0, 0.06}, glaze);
  const Color fruits[] = {{0.6f, 0.08f, 0.05f}, {0.7f, 0.4f, 0.05f}, {0.4f, 0.5f, 0.08f}};
  for (int i = 0; i < 4; ++i) {
    const double azimuth = 2 * M_PI * i / 4 + random->Uniform(0, 0.5);
    const double radius = random->Uniform(0.032, 0.042);
    const std::uint64_t seed = random->Index(1 << 30);
    item.Add(MakeSphere(radius),
             {0.06 * std::cos(azimuth), 0.06 * std::sin(azimuth), 0.06 + 0.8 * radius},
             Mottled(fruits[random->Index(3)], 0.02, 0.6f, seed));
  }
}

void AddVase(const Item& item, Random* random) {
  const std::uint64_t seed = random->Index(1 << 30);
  const Texture glaze = Mottled(RandomPaint(random), 0.04, 0.8f, seed);
  const double radius = random->Uniform(0.05, 0.07);
  item.Cone(Vector3d::Zero(), 0.7 * radius, 0.7 * radius, 0.01, glaze);
  item.Add(MakeSphere(radius), {0, 0, 0.95 * radius}, glaze);
  item.Cone({0, 0, 1.7 * radius}, 0.5 * radius, 0.35 * radius, 0.06, glaze);
  item.Add(MakeTorus(0.4 * radius, 0.006), {0, 0, 1.7 * radius + 0.06}, glaze);
}

void AddRing(const Item& item, Random* random) {
  const Color second = RandomPaint(random), first = RandomPaint(random);
  const Texture paint = Checks(first, second, 0.04);
  const double tube = random->Uniform(0.02, 0.035);
  item.Add(MakeTorus(0.08, tube), {0, 0, tube}, paint);
}

void AddMonitor(const Item& item, Random* random) {
  const Texture black = Plain(Color::Constant(0.06f));
  const double width = random->Uniform(0.55, 0.75), height = 0.58 * width;
  item.Box({-0.12, -0.09, 0}, {0.12, 0.09, 0.012}, black);
  item.Rod({0, -0.02, 0.012}, {0, -0.02, 0.2}, 0.02, black);
  item.Box({-width / 2, -0.02, 0.1}, {width / 2, 0.02, 0.1 + height}, black);
  item.Add(MakeBox({width - 0.03, 0.004, height - 0.03}), {0, 0.021, 0.1 + height / 2},
           Poster(width - 0.03, height - 0.03, random->Index(1 << 30)), 0.5f);
}

void AddRowOfBooks(const Item& item, double width_m, double depth_m, double height_m,
                   Random* random) {
  double x = 0;
  while (true) {
    const double thickness = random->Uniform(0.015, 0.055);
    if (x + thickness > width_m) return;
    const double height = random->Uniform(0.65, 1) * height_m;
    const double depth = random->Uniform(0.75, 1) * depth_m;
    const double band = random->Uniform(0.04, 0.1);
    const Color gap = RandomPaint(random), stripe = RandomPaint(random);
    item.Box({x, 0, 0}, {x + thickness - 0.001, depth, height}, Stripes(stripe, gap, band, 2));
    x += thickness;
  }
}

void AddClutter(const Item& item, double width_m, double depth_m, Random* random) {
  using Adder = void (*)(const Item&, Random*);
  constexpr Adder kThings[] = {&AddCup, &AddPileOfBooks, &AddBowlOfFruit,
                               &AddCup, &AddRing,        &AddVase};
  // Each grid cell has at most one item, so items do not intersect. 30 % of the cells are empty.
  const int columns = std::max(1, static_cast<int>(width_m / 0.33));
  const int rows = std::max(1, static_cast<int>(depth_m / 0.33));
  const double column = width_m / columns, row = depth_m / rows;
  for (int i = 0; i < columns * rows; ++i) {
    if (random->Uniform() < 0.3) continue;
    const double x = (i % columns + 0.5) * column - width_m / 2 + random->Uniform(-0.02, 0.02);
    const double y = (i / columns + 0.5) * row - depth_m / 2 + random->Uniform(-0.02, 0.02);
    kThings[random->Index(6)](item.At({x, y, 0}), random);
  }
}

using Eigen::Vector3d;

void AddPoster(const Item& item, double width_m, double height_m, Random* random) {
  constexpr double kThickness_m = 0.015;
  item.Add(MakeBox({width_m, kThickness_m, height_m}), {0, kThickness_m / 2, height_m / 2},
           Poster(width_m, height_m, random->Index(1 << 30)));
}

void AddDoor(const Item& item, Random* random) {
  const Texture paint =
      Plain(random->Index(2) == 0 ? Color(0.62f, 0.6f, 0.56f) : RandomPaint(random));
  const Texture frame = RandomWood(2, random), metal = Plain(Color::Constant(0.45f));
  item.Box({-0.42, 0, 0}, {0.42, 0.03, 2.02}, paint);
  for (const double x : {-0.49, 0.42}) item.Box({x, 0, 0}, {x + 0.07, 0.05, 2.09}, frame);
  item.Box({-0.42, 0, 2.02}, {0.42, 0.05, 2.09}, frame);
  for (const double z : {0.25, 1.15}) {  // panels
    item.Box({-0.3, 0.03, z}, {0.3, 0.04, z + 0.7}, paint);
  }
  item.Rod({0.36, 0.03, 1.02}, {0.36, 0.08, 1.02}, 0.009, metal);
  item.Rod({0.37, 0.08, 1.02}, {0.25, 0.08, 1.02}, 0.009, metal);
}

void AddCurtain(const Item& item, double width_m, double height_m, Random* random) {
  const std::uint64_t seed = random->Index(1 << 30);
  const Texture cloth = Mottled(RandomPaint(random), 0.05, 0.25f, seed);
  const int folds = static_cast<int>(width_m / 0.075);
  for (int i = 0; i < folds; ++i) {
    const double x = (i + 0.5) * width_m / folds - width_m / 2;
    const double y = i % 2 == 0 ? 0.09 : 0.05;
    item.Rod({x, y, 0.03}, {x, y, height_m}, random->Uniform(0.042, 0.05), cloth);
  }
  item.Rod({-width_m / 2 - 0.1, 0.08, height_m + 0.02}, {width_m / 2 + 0.1, 0.08, height_m + 0.02},
           0.015, Plain(Color::Constant(0.3f)));
}

void AddWallShelf(const Item& item, double width_m, Random* random) {
  constexpr double kDepth_m = 0.2;
  item.Box({-width_m / 2, 0, -0.025}, {width_m / 2, kDepth_m, 0}, RandomWood(0, random));
  AddRowOfBooks(item.At({-width_m / 2, 0.01, 0}), 0.45 * width_m, 0.16, 0.24, random);
  AddVase(item.At({0.15 * width_m, 0.1, 0}), random);
  AddCup(item.At({0.35 * width_m, 0.1, 0}), random);
}

void AddClock(const Item& item, Random* random) {
  const Eigen::Quaterniond facing(Eigen::AngleAxisd(-M_PI / 2, Vector3d::UnitX()));
  item.Add(MakeFrustum(0.15, 0.15, 0.02), Rigid3d(facing, Vector3d(0, 0.01, 0.15)),
           Plain(Color::Constant(0.75f)));
  item.Add(MakeTorus(0.15, 0.014), Rigid3d(facing, Vector3d(0, 0.02, 0.15)),
           Plain(RandomPaint(random)));
  for (const double length : {0.08, 0.12}) {
    const double angle = random->Uniform(0, 2 * M_PI);
    item.Rod({0, 0.026, 0.15}, {length * std::cos(angle), 0.026, 0.15 + length * std::sin(angle)},
             0.004, Plain(Color::Constant(0.05f)));
  }
}

}  // namespace surfit
