#include "surfit/simulation/scenes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "simulation/random.h"
#include "surfit/simulation/render.h"
#include "testing/expect_input_error.h"

namespace surfit {
namespace {

using Eigen::Vector3d;

// How far a ray from the middle of the camera's space goes, above the furniture.
double Free(const Scene& room, const Vector3d& direction) {
  Vector3d start = room.camera_space.center();
  start.z() = 2.0;
  const auto hit = room.Intersect(start, direction);
  return hit ? hit->t : 1e9;
}

TEST(Room, MeasuresFourToEightMetres) {
  for (int seed = 1; seed <= 20; ++seed) {
    const Scene room = MakeScene("room", seed);
    for (const Vector3d& axis : {Vector3d::UnitX().eval(), Vector3d::UnitY().eval()}) {
      // The walls; curtains, a bookshelf or the lamp may stand before them.
      const double length = Free(room, axis) + Free(room, -axis);
      EXPECT_GT(length, 4 - 0.4);
      EXPECT_LT(length, 8);
    }
  }
}

TEST(Room, HoldsFlatAndCurvedAndThinThings) {
  const Scene room = MakeScene("room", 1);
  EXPECT_GT(room.objects().size(), 150u);
  int thin = 0;
  std::set<int> curved;
  Random random(5);
  for (int i = 0; i < 20000; ++i) {
    const Vector3d direction(random.Normal(), random.Normal(), random.Normal());
    const auto hit = room.Intersect(room.camera_space.center(), direction);
    ASSERT_TRUE(hit) << "the room is closed";
    if (hit->face == Shape::kCurved) curved.insert(hit->object);
    // Thin: the surface is less than 3 cm from where the ray leaves the solid.
    const Vector3d point = room.camera_space.center() + hit->t * direction;
    const Vector3d behind = point - 0.03 * hit->normal_in_world;
    if (room.Distance(behind) > 0) ++thin;
  }
  EXPECT_GE(curved.size(), 10u);
  EXPECT_GE(thin, 50);
}

TEST(Room, DiffersFromSeedToSeedAndNotFromRunToRun) {
  const Scene a = MakeScene("room", 1), again = MakeScene("room", 1), b = MakeScene("room", 2);
  Random random(6);
  int same = 0;
  for (int i = 0; i < 1000; ++i) {
    const Vector3d direction(random.Normal(), random.Normal(), 0.1 * random.Normal());
    const Vector3d eye(2.4, 2.4, 1.4);
    const auto hit_a = a.Intersect(eye, direction), hit_b = b.Intersect(eye, direction);
    EXPECT_EQ(hit_a->t, again.Intersect(eye, direction)->t);
    if (std::abs(hit_a->t - hit_b->t) < 0.01 * hit_a->t) ++same;
  }
  EXPECT_LT(same, 500);  // half of the rays meet the two walls that stand at x = 0 and at y = 0
}

// A wall between furniture hardly changes its brightness within a hand's breadth.
TEST(Room, HasWallsOfLittleTexture) {
  const Scene room = MakeScene("room", 1);
  Random random(7);
  int walls = 0, plain = 0;
  for (int i = 0; i < 3000; ++i) {
    const Vector3d eye = room.camera_space.center();
    const Vector3d direction(random.Normal(), random.Normal(), 0.3 * random.Normal());
    const auto hit = room.Intersect(eye, direction);
    const Vector3d point = eye + hit->t * direction;
    const bool is_wall = std::abs(hit->normal_in_world.z()) < 0.1 &&
                         room.objects()[hit->object].shape->BoundingRadius() > 2;
    if (!is_wall) continue;
    ++walls;
    const Vector3d beside = point + 0.1 * hit->normal_in_world.cross(Vector3d::UnitZ());
    const float here = room.Reflectance(*hit, point).sum();
    if (std::abs(room.Reflectance(*hit, beside).sum() - here) < 0.03f * here) ++plain;
  }
  EXPECT_GT(walls, 300);
  EXPECT_GT(plain, 0.95 * walls);
}

TEST(Scene, DistanceIsTheLeastOfAllObjects) {
  const Scene room = MakeScene("room", 3);
  Random random(8);
  for (int i = 0; i < 300; ++i) {
    const Vector3d point(random.Uniform(0, 5), random.Uniform(0, 4.6), random.Uniform(0, 2.5));
    double least = 1e9;
    for (const SceneObject& object : room.objects()) {
      const double distance = object.shape->Distance(object.world_from_object.Inverse() * point);
      least = std::min(least, distance);
    }
    // Inside intersecting solids both are negative, but bounded differently.
    if (least > 0) {
      EXPECT_NEAR(room.Distance(point), least, 1e-12);
    }
    EXPECT_EQ(room.Distance(point) < 0, least < 0);
  }
}

TEST(Scenes, AnUnknownNameListsTheKnown) {
  testing::ExpectInputError(
      [] { MakeScene("kitchen"); },
      ::testing::StrEq("scene is 'kitchen', must be one of corridor, room, sphere, three_planes, "
                       "three_rooms, wall"));
}

}  // namespace
}  // namespace surfit
