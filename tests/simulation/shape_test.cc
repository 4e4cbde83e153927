#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "simulation/random.h"
#include "surfit/simulation/scene.h"

namespace surfit::testing {
namespace {

using Eigen::Vector3d;

const std::map<std::string, ShapePtr>& Shapes() {
  static const std::map<std::string, ShapePtr> shapes = {
      {"half_space", MakeHalfSpace()},      {"box", MakeBox({0.8, 0.5, 1.2})},
      {"sphere", MakeSphere(0.7)},          {"rounded_box", MakeRoundedBox({0.8, 0.5, 1.2}, 0.1)},
      {"capsule", MakeCapsule(0.2, 0.9)},   {"cylinder", MakeFrustum(0.4, 0.4, 1.0)},
      {"cone", MakeFrustum(0.6, 0.2, 0.9)}, {"wide_cone", MakeFrustum(0.1, 0.8, 0.3)},
      {"torus", MakeTorus(0.6, 0.15)}};
  return shapes;
}

class ShapeTest : public ::testing::TestWithParam<std::string> {
 protected:
  const Shape& shape() const { return *Shapes().at(GetParam()); }
  Vector3d RandomPoint(double size) {
    const double x = random_.Uniform(-size, size), y = random_.Uniform(-size, size);
    return {x, y, random_.Uniform(-size, size)};
  }
  Random random_{11};
};

// Membership by the definition of each solid, without its distance function.
bool Contains(const std::string& name, const Vector3d& p) {
  const double r = std::hypot(p.x(), p.y());
  const auto in_box = [&](double x, double y, double z) {
    return std::abs(p.x()) <= x && std::abs(p.y()) <= y && std::abs(p.z()) <= z;
  };
  const auto in_cone = [&](double bottom, double top, double height) {
    const double share = p.z() / height + 0.5;
    return share >= 0 && share <= 1 && r <= bottom + share * (top - bottom);
  };
  if (name == "half_space") return p.z() <= 0;
  if (name == "box") return in_box(0.4, 0.25, 0.6);
  if (name == "sphere") return p.norm() <= 0.7;
  if (name == "rounded_box") {
    return (p - p.cwiseMax(-Vector3d(0.3, 0.15, 0.5)).cwiseMin(Vector3d(0.3, 0.15, 0.5))).norm() <=
           0.1;
  }
  if (name == "capsule") {
    return std::hypot(r, std::max(0.0, std::abs(p.z()) - 0.45)) <= 0.2;
  }
  if (name == "cylinder") return in_cone(0.4, 0.4, 1.0);
  if (name == "cone") return in_cone(0.6, 0.2, 0.9);
  if (name == "wide_cone") return in_cone(0.1, 0.8, 0.3);
  return (r - 0.6) * (r - 0.6) + p.z() * p.z() <= 0.15 * 0.15;  // torus
}

TEST_P(ShapeTest, IntersectAgreesWithRayMarching) {
  constexpr double kStep = 1e-3;
  int hits = 0;
  for (int i = 0; i < 400; ++i) {
    const Vector3d origin = 2 * RandomPoint(1);
    if (Contains(GetParam(), origin)) continue;
    const Vector3d direction = (RandomPoint(0.5) - origin) * random_.Uniform(0.1, 3);
    const double speed = direction.norm();
    const auto hit = shape().Intersect(origin, direction);
    double marched = 0;
    while (marched < 8 && !Contains(GetParam(), origin + marched / speed * direction)) {
      marched += kStep;
    }
    if (marched < 8) {
      ASSERT_TRUE(hit.has_value()) << i;
      // Ray marching finds the entry at its next step. It can miss a chord shorter than a step, and
      // then finds a later entry.
      EXPECT_LE(hit->t * speed, marched + 1e-9);
      if (hit->t * speed < marched - kStep) {
        const Vector3d grazing = origin + (hit->t + kStep / speed) * direction;
        EXPECT_LT(std::abs(shape().Distance(grazing)), kStep);
      }
      ++hits;
    } else if (hit && hit->t * speed < 8) {
      // Ray marching misses a hit only if the ray is inside for less than a step.
      EXPECT_GT(shape().Distance(origin + (hit->t + kStep / speed) * direction), -kStep);
    }
  }
  EXPECT_GT(hits, 100);
}

TEST_P(ShapeTest, HitsAreOnSurfaceAndFaceRay) {
  for (int i = 0; i < 1000; ++i) {
    const Vector3d origin = 2 * RandomPoint(1), direction = RandomPoint(0.7) - origin;
    const auto hit = shape().Intersect(origin, direction);
    if (!hit) continue;
    EXPECT_GT(hit->t, 0);
    EXPECT_LT(hit->normal.dot(direction), 0);
    EXPECT_NEAR(hit->normal.norm(), 1, 1e-12);
    // Iterated shapes stop at 1e-10. Formulas have a few rounding errors of values near 4.
    EXPECT_NEAR(shape().Distance(origin + hit->t * direction), 0, 2e-10);
  }
}

TEST_P(ShapeTest, NormalIsGradientOfDistance) {
  constexpr double kH = 1e-6;
  for (int i = 0; i < 1000; ++i) {
    const Vector3d origin = 2 * RandomPoint(1), direction = RandomPoint(0.7) - origin;
    const auto hit = shape().Intersect(origin, direction);
    if (!hit) continue;
    const Vector3d point = origin + hit->t * direction;
    Vector3d gradient;
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3d step = kH * Vector3d::Unit(axis);
      gradient[axis] = (shape().Distance(point + step) - shape().Distance(point - step)) / (2 * kH);
    }
    // Central differences have the error h^2 / r^2 / 6 with radii r >= 0.1, and rounding 1e-16 * 4
    // / h. Points within h of an edge have no gradient: the length of the difference is not 1.
    if (std::abs(gradient.norm() - 1) > 1e-6) continue;
    EXPECT_LT((gradient - hit->normal).norm(), 1e-6) << point.transpose();
  }
}

TEST_P(ShapeTest, DistanceAgreesWithNearestSurfaceSample) {
  std::vector<Vector3d> surface;
  while (surface.size() < 20000) {
    const Vector3d origin = 2.5 * RandomPoint(1), direction = RandomPoint(1.2) - origin;
    const auto hit = shape().Intersect(origin, direction);
    if (hit) surface.push_back(origin + hit->t * direction);
  }
  for (int i = 0; i < 100; ++i) {
    const Vector3d point = RandomPoint(1);
    double nearest = 1e9;
    for (const Vector3d& p : surface) nearest = std::min(nearest, (p - point).norm());
    const double distance = shape().Distance(point);
    EXPECT_EQ(distance < 0, Contains(GetParam(), point));
    // No sample is nearer than the surface. With 20000 random samples on at most 10 m^2, every disc
    // of 20 m^2 * ln(20000) / 20000 = 1e-2 m^2 (radius 6 cm) contains a sample, except with
    // probability 1/20000 each. The half space is infinite and sampled within 2.5 m only.
    EXPECT_LE(std::abs(distance), nearest + 2e-10);
    EXPECT_GE(std::abs(distance), nearest - (GetParam() == "half_space" ? 0.2 : 0.06));
  }
}

TEST_P(ShapeTest, IsInsideBoundingSphereAndBox) {
  const double radius = shape().BoundingRadius();
  const Vector3d half = shape().HalfExtents();
  for (int i = 0; i < 10000; ++i) {
    const Vector3d point = RandomPoint(1.2);
    if (Contains(GetParam(), point)) {
      EXPECT_LE(point.norm(), radius);
      EXPECT_TRUE((point.cwiseAbs().array() <= half.array()).all()) << point.transpose();
    }
  }
}

TEST_P(ShapeTest, HasNoHitFromInside) {
  for (int i = 0; i < 1000; ++i) {
    const Vector3d point = RandomPoint(0.8);
    if (shape().Distance(point) < 0) {
      EXPECT_FALSE(shape().Intersect(point, RandomPoint(1)).has_value());
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, ShapeTest,
                         ::testing::Values("half_space", "box", "sphere", "rounded_box", "capsule",
                                           "cylinder", "cone", "wide_cone", "torus"),
                         [](const auto& instance) { return instance.param; });

TEST(Shape, NumbersItsFaces) {
  EXPECT_EQ(MakeBox({1, 1, 1})->Intersect({3, 0, 0}, {-1, 0, 0})->face, 1);
  EXPECT_EQ(MakeBox({1, 1, 1})->Intersect({0, -3, 0}, {0, 1, 0})->face, 2);
  const ShapePtr cylinder = MakeFrustum(0.5, 0.5, 1);
  EXPECT_EQ(cylinder->Intersect({0, 0, 3}, {0, 0, -1})->face, 1);
  EXPECT_EQ(cylinder->Intersect({3, 0, 0}, {-1, 0, 0})->face, Shape::kCurved);
}

TEST(Shape, AgreesWithKnownHits) {
  EXPECT_DOUBLE_EQ(MakeSphere(0.5)->Intersect({0, 0, -2}, {0, 0, 1})->t, 1.5);
  EXPECT_DOUBLE_EQ(MakeBox({1, 2, 3})->Intersect({0, 0, -2}, {0, 0, 2})->t, 0.25);
  EXPECT_NEAR(MakeTorus(1, 0.25)->Intersect({1, 0, 2}, {0, 0, -1})->t, 1.75, 2e-10);
  EXPECT_FALSE(
      MakeTorus(1, 0.25)->Intersect({0, 0, 2}, {0, 0, -1}).has_value());  // through the hole
  // Cone of slope 1 with radius 1 at z = 0. The ray hits it at half height.
  EXPECT_DOUBLE_EQ(MakeFrustum(1.5, 0.5, 1)->Intersect({3, 0, 0}, {-1, 0, 0})->t, 2);
}

}  // namespace
}  // namespace surfit::testing
