#include <cmath>

#include "simulation/item.h"

namespace surfit {

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
  // Folds are half cylinders side by side, each second one further back.
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
