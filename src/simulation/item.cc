#include "simulation/item.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace surfit {

using Eigen::Quaterniond;
using Eigen::Vector3d;

// Rotation by the angle a from the z axis to the direction d. cos a = z . d, and sin a * axis = z x
// d. Half-angle formulas: (1 + cos a, sin a * axis) = 2 cos(a/2) (cos(a/2), sin(a/2) * axis).
Eigen::Quaterniond TurnZInto(const Eigen::Vector3d& direction) {
  const Eigen::Vector3d d = direction.normalized();
  if (d.z() < -1 + 1e-12) return {0, 1, 0, 0};  // half a turn about the x axis
  return Eigen::Quaterniond(1 + d.z(), -d.y(), d.x(), 0).normalized();
}

Item Item::At(const Vector3d& position, double turn_rad) const {
  const Quaterniond turn(Eigen::AngleAxisd(turn_rad, Vector3d::UnitZ()));
  return Item(scene_, frame_ * Rigid3d(turn, position));
}

void Item::Add(ShapePtr shape, const Rigid3d& item_from_part, const Texture& texture,
               float glow) const {
  scene_->Add(std::move(shape), frame_ * item_from_part, texture, glow);
}

void Item::Add(ShapePtr shape, const Vector3d& center, const Texture& texture, float glow) const {
  Add(std::move(shape), Rigid3d(Quaterniond::Identity(), center), texture, glow);
}

void Item::Box(const Vector3d& low, const Vector3d& high, const Texture& texture) const {
  Add(MakeBox(high - low), (low + high) / 2, texture);
}

void Item::RoundedBox(const Vector3d& low, const Vector3d& high, double edge_radius,
                      const Texture& texture) const {
  Add(MakeRoundedBox(high - low, edge_radius), (low + high) / 2, texture);
}

void Item::Rod(const Vector3d& from, const Vector3d& to, double radius,
               const Texture& texture) const {
  const Vector3d along = to - from;
  Add(MakeFrustum(radius, radius, along.norm()), Rigid3d(TurnZInto(along), (from + to) / 2),
      texture);
}

void Item::Cone(const Vector3d& bottom, double bottom_radius, double top_radius, double height,
                const Texture& texture, float glow) const {
  Add(MakeFrustum(bottom_radius, top_radius, height), bottom + Vector3d(0, 0, height / 2), texture,
      glow);
}

Color RandomPaint(Random* random) {
  const double hue = random->Uniform(0, 2 * M_PI), strength = random->Uniform(0.05, 0.22);
  const double grey = random->Uniform(0.2, 0.45);
  const auto channel = [&](double phase) {
    return static_cast<float>(std::max(0.04, grey + strength * std::cos(hue - phase)));
  };
  return {channel(0), channel(2 * M_PI / 3), channel(4 * M_PI / 3)};
}

Texture RandomWood(int grain_axis, Random* random) {
  const auto shade = static_cast<float>(random->Uniform(0.5, 1.2));
  const std::uint64_t seed = random->Index(1 << 30);
  return Wood(shade * Color(0.5f, 0.33f, 0.19f), shade * Color(0.25f, 0.14f, 0.07f), grain_axis,
              seed);
}

}  // namespace surfit
