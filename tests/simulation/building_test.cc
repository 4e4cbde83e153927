#include "simulation/building.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "simulation/hand_held_motion.h"
#include "simulation/random.h"
#include "simulation/room.h"
#include "surfit/core/options.h"
#include "surfit/simulation/camera_path.h"
#include "surfit/simulation/render.h"
#include "testing/matchers.h"

namespace surfit::testing {
namespace {

using Eigen::Vector3d;

constexpr BuildingOptions kSmall = {2, 6};

const Scene& SmallBuilding() {
  static const Scene scene = MakeScene("building", 1, kSmall);
  return scene;
}

Vector3d RandomDirection(Random* random) {
  const double x = random->Normal(), y = random->Normal(), z = random->Normal();
  return {x, y, z};
}

TEST(BuildingPlan, DistributesDisjointRoomsOverFloors) {
  const BuildingPlan plan({3, 15});
  ASSERT_EQ(plan.rooms.size(), 15u);
  EXPECT_EQ(plan.columns, 2);
  std::vector<Eigen::AlignedBox3d> spaces;
  for (const BuildingPlan::Place& place : plan.rooms) {
    RoomPlan room{nullptr, nullptr, BuildingPlan::kRoomWidth_m, BuildingPlan::kRoomDepth_m};
    room.corner_in_world = place.world_from_room.translation;
    room.turn_rad = place.world_from_room.rotation.w() == 1 ? 0 : M_PI;
    spaces.push_back(room.SpaceInWorld());
    EXPECT_NEAR(spaces.back().volume(), 5.2 * 4.8 * 2.5, 1e-9);
    EXPECT_NEAR(spaces.back().min().z(), 2.9 * place.floor, 1e-9);
    EXPECT_NEAR(spaces.back().exteriorDistance(place.doorway), 0.2, 1e-9);
  }
  for (std::size_t i = 0; i < spaces.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      EXPECT_GE(spaces[i].exteriorDistance(spaces[k]), 0.4 - 1e-9) << i << " " << k;
    }
  }
}

TEST(BuildingPlan, RejectsUnequalNumberOfRoomsPerFloor) {
  ExpectInputError([] { MakeScene("building", 1, {2, 7}); }, Names("rooms", 7, 2));
  ExpectInputError([] { MakeScene("building", 1, {0, 7}); }, Names("floors", 0));
}

// No ray from the route leaves the building or starts inside a solid.
TEST(Building, IsClosed) {
  Random random(2);
  for (const BuildingOptions& options : {kSmall, BuildingOptions{1, 1}, BuildingOptions{3, 3}}) {
    const Scene scene = MakeScene("building", 1, options);
    const BuildingPlan plan(options);
    const Eigen::AlignedBox3d outside(
        Vector3d(-6, -6, -1),
        Vector3d(plan.Length() + 6, BuildingPlan::Depth() + 6, plan.floors * 2.9 + 0.5));
    for (std::size_t i = 0; i < scene.route.size(); i += 3) {
      for (int k = 0; k < 20; ++k) {
        const Vector3d direction = RandomDirection(&random);
        const auto hit = scene.Intersect(scene.route[i], direction);
        ASSERT_TRUE(hit) << scene.route[i].transpose() << " towards " << direction.transpose();
        ASSERT_TRUE(outside.contains(scene.route[i] + hit->t * direction));
      }
    }
  }
}

// The camera deviates from the route by 0.1 m across, 0.1 m along and 0.15 m vertically, plus
// tremble.
TEST(Building, RouteKeepsDistanceToObjects) {
  for (const int seed : {1, 2, 3}) {
    const Scene scene = MakeScene("building", seed, {3, 12});
    const Loop way(scene.route);
    double least_m = 1;
    for (std::size_t i = 0; i < scene.route.size(); ++i) {
      for (const double share : {0.0, 0.25, 0.5, 0.75}) {
        least_m = std::min(least_m, scene.Distance(way.At(static_cast<double>(i) + share)));
      }
    }
    EXPECT_GT(least_m, 0.45);
  }
}

TEST(Building, RouteVisitsEveryRoomAndBothStaircases) {
  const BuildingOptions options = {3, 12};
  const BuildingPlan plan(options);
  const std::vector<Vector3d> route = BuildingRoute(plan);
  for (const BuildingPlan::Place& room : plan.rooms) {
    const Vector3d middle =
        room.world_from_room * Vector3d(BuildingPlan::kRoomWidth_m / 2, 0.9, 1.4);
    const Vector3d far = room.world_from_room * Vector3d(BuildingPlan::kRoomWidth_m / 2, 3, 1.4);
    for (const Vector3d& place : {middle, far}) {
      double nearest = 1e9;
      for (const Vector3d& corner : route) nearest = std::min(nearest, (corner - place).norm());
      EXPECT_LT(nearest, 0.6) << room.floor << " " << room.column;
    }
  }
  // The route passes the middle of both staircases between all floors.
  std::set<std::pair<bool, int>> climbed;
  for (const Vector3d& corner : route) {
    const double storeys = (corner.z() - 1.4) / BuildingPlan::kStorey_m;
    for (const bool is_east : {false, true}) {
      if (std::abs(corner.x() - plan.StaircaseAisle(is_east)) > 0.1) continue;
      if (std::abs(storeys - std::floor(storeys) - 0.5) < 0.1) {
        climbed.insert({is_east, static_cast<int>(std::floor(storeys))});
      }
    }
  }
  EXPECT_THAT(climbed, ElementsAre(std::pair(false, 0), std::pair(false, 1), std::pair(true, 0),
                                   std::pair(true, 1)));
  for (std::size_t i = 0; i < route.size(); ++i) {
    EXPECT_LT((route[(i + 1) % route.size()] - route[i]).norm(), 1.6) << i;
  }
}

// Similarity of two rooms, seen from the same points in the room frame.
struct Likeness {
  double same_shape = 0, same_color = 0;  // ratios of rays
};

Likeness Compare(const Scene& scene, const BuildingPlan::Place& a, const BuildingPlan::Place& b) {
  constexpr int kRays = 2000;
  Random random(3);
  Likeness likeness;
  for (int i = 0; i < kRays; ++i) {
    const Vector3d eye(random.Uniform(1.2, 4), random.Uniform(1.2, 3.6), 1.4);
    const Vector3d direction = RandomDirection(&random);
    const auto of = [&](const BuildingPlan::Place& room) {
      return scene.Intersect(room.world_from_room * eye, room.world_from_room.rotation * direction);
    };
    const auto color = [&](const BuildingPlan::Place& room, const SceneHit& hit) {
      return scene.Reflectance(hit, room.world_from_room * (eye + hit.t * direction));
    };
    const auto hit_a = of(a), hit_b = of(b);
    if (std::abs(hit_a->t - hit_b->t) > 1e-6 * hit_a->t) continue;
    likeness.same_shape += 1.0 / kRays;
    if ((color(a, *hit_a) - color(b, *hit_b)).norm() < 1e-3f) likeness.same_color += 1.0 / kRays;
  }
  return likeness;
}

TEST(Building, PairedRoomsDifferInPicturesAndOneObject) {
  const BuildingPlan plan(kSmall);
  for (std::size_t i = 0; i < plan.rooms.size(); i += 2) {
    const Likeness pair = Compare(SmallBuilding(), plan.rooms[i], plan.rooms[i + 1]);
    EXPECT_GT(pair.same_shape, 0.97) << i;
    EXPECT_LT(pair.same_shape, 1) << i << ": the rooms have the same geometry";
    EXPECT_GT(pair.same_color, 0.85) << i;
    EXPECT_LT(pair.same_color, pair.same_shape - 0.01) << i << ": the rooms have the same pictures";
    const Likeness others =
        Compare(SmallBuilding(), plan.rooms[i], plan.rooms[(i + 2) % plan.rooms.size()]);
    EXPECT_LT(others.same_shape, 0.8) << i;  // only floor, ceiling and walls are equal
  }
}

// Walls block light: a room is lit by its own lamp only.
TEST(Building, LampsLightTheirRoomOnly) {
  const BuildingPlan plan(kSmall);
  for (const BuildingPlan::Place& room : plan.rooms) {
    const Vector3d middle = room.world_from_room * Vector3d(2.6, 2.4, 1);
    int lit = 0;
    for (const PointLight& light : SmallBuilding().lights)
      lit += light.lit.contains(middle) ? 1 : 0;
    EXPECT_EQ(lit, 1);
  }
}

TEST(Building, TargetsAreInTheirCell) {
  const Scene& scene = SmallBuilding();
  std::size_t targets = 0;
  for (const SceneCell& cell : scene.cells) {
    EXPECT_GE(cell.targets.size(), 4u);
    targets += cell.targets.size();
    for (const int target : cell.targets) {
      EXPECT_LT(cell.space.exteriorDistance(scene.targets[target]), 0.01);
    }
  }
  EXPECT_EQ(targets, scene.targets.size());
}

TEST(Building, DependsOnSeedOnly) {
  const Scene again = MakeScene("building", 1, kSmall), other = MakeScene("building", 2, kSmall);
  ASSERT_EQ(again.objects().size(), SmallBuilding().objects().size());
  EXPECT_NE(other.objects().size(), again.objects().size());
  const Trajectory a = MakePath(SmallBuilding(), 250, 1), b = MakePath(again, 250, 1);
  for (std::size_t i = 0; i < a.size(); ++i) {
    ASSERT_EQ(a[i].world_from_camera.Matrix(), b[i].world_from_camera.Matrix());
  }
  PinholeCamera camera = {80, 60, 525.0 / 8, 525.0 / 8, 39.5, 29.5, {}};
  const Rendering image = Render(SmallBuilding(), camera, a[100].world_from_camera);
  EXPECT_TRUE(image.color == Render(again, camera, a[100].world_from_camera).color);
}

TEST(Building, PathKeepsDistanceAndStepBounds) {
  PathOptions options;
  options.min_step_m = 0.03;
  options.max_step_m = 0.05;
  const Trajectory path = MakePath(SmallBuilding(), 600, 4, options);
  for (std::size_t i = 1; i < path.size(); ++i) {
    const double step =
        (path[i].world_from_camera.translation - path[i - 1].world_from_camera.translation).norm();
    ASSERT_GE(step, 0.03);
    ASSERT_LE(step, 0.05);
    if (i % 5 == 0) {
      ASSERT_GT(SmallBuilding().Distance(path[i].world_from_camera.translation), 0.3) << i;
    }
  }
}

}  // namespace
}  // namespace surfit::testing
