#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "simulation/item.h"
#include "simulation/random.h"
#include "surfit/simulation/camera_path.h"
#include "surfit/simulation/render.h"
#include "surfit/simulation/scene.h"
#include "testing/matchers.h"

namespace surfit::testing {
namespace {

using Eigen::Vector3d;

TEST(TurnZInto, RotatesZToDirectionByShortestRotation) {
  for (const Vector3d& direction :
       {Vector3d(0, 0, 2), Vector3d(0.3, -0.4, 1.2), Vector3d(5, 0, 0), Vector3d(0, -1e-3, -1),
        Vector3d(0.1, 0.2, -3), Vector3d(0, 0, -0.5)}) {
    const Eigen::Quaterniond turn = TurnZInto(direction);
    EXPECT_NEAR(turn.norm(), 1, 1e-15);
    // 1 + cos has an error of up to 1e-16 at 5e-7, the value close to a half turn.
    EXPECT_THAT(turn * Vector3d::UnitZ(), VectorNear(direction.normalized(), 1e-9));
    EXPECT_EQ(turn.z(), 0) << "the rotation has a z component";
    EXPECT_GE(turn.w(), 0);
  }
}

// Free distance from the centre of the camera space along a ray above the furniture.
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
      // Distance between walls. Curtains, a bookshelf or the lamp can be in front of a wall.
      const double length = Free(room, axis) + Free(room, -axis);
      EXPECT_GT(length, 4 - 0.4);
      EXPECT_LT(length, 8);
    }
  }
}

TEST(Room, ContainsFlatCurvedAndThinObjects) {
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
    // Thin: the ray leaves the solid less than 3 cm behind the surface.
    const Vector3d point = room.camera_space.center() + hit->t * direction;
    const Vector3d behind = point - 0.03 * hit->normal_in_world;
    if (room.Distance(behind) > 0) ++thin;
  }
  EXPECT_GE(curved.size(), 10u);
  EXPECT_GE(thin, 50);
}

TEST(Room, DependsOnSeedOnly) {
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
  EXPECT_LT(same, 500);  // half of the rays hit the walls at x = 0 and y = 0, which are equal
}

// The brightness of a wall is almost constant within 10 cm.
TEST(Room, HasWallsWithLittleTexture) {
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

TEST(Scene, DistanceIsMinimumOverObjects) {
  const Scene room = MakeScene("room", 3);
  Random random(8);
  for (int i = 0; i < 300; ++i) {
    const Vector3d point(random.Uniform(0, 5), random.Uniform(0, 4.6), random.Uniform(0, 2.5));
    double least = 1e9;
    for (const SceneObject& object : room.objects()) {
      const double distance = object.shape->Distance(object.world_from_object.Inverse() * point);
      least = std::min(least, distance);
    }
    // Inside intersecting solids both distances are negative, but their bounds differ.
    if (least > 0) {
      EXPECT_NEAR(room.Distance(point), least, 1e-12);
    }
    EXPECT_EQ(room.Distance(point) < 0, least < 0);
  }
}

TEST(Scenes, RejectUnknownNameAndListKnownNames) {
  ExpectInputError([] { MakeScene("kitchen"); },
                   Names("scene", "kitchen", "building", "corridor", "room", "sphere",
                         "three_planes", "three_rooms", "wall"));
}

struct Step {
  double distance_m, angle_deg;
};

std::vector<Step> Steps(const Trajectory& path) {
  std::vector<Step> steps;
  for (std::size_t i = 1; i < path.size(); ++i) {
    const Rigid3d motion = path[i - 1].world_from_camera.Inverse() * path[i].world_from_camera;
    steps.push_back({motion.translation.norm(), RotationAngle(motion.rotation) / kRadPerDeg});
  }
  return steps;
}

constexpr int kFrames = 250;

// Paths in scenes of the same seed. Each path is computed once.
const Trajectory& Path(const std::string& scene, int seed) {
  static std::map<std::pair<std::string, int>, Trajectory> paths;
  Trajectory& path = paths[{scene, seed}];
  if (path.empty()) path = MakePath(MakeScene(scene, seed), kFrames, seed);
  return path;
}

class PathInScene : public ::testing::TestWithParam<std::string> {};

TEST_P(PathInScene, StepsAreWithinBounds) {
  for (const int seed : {1, 2}) {
    const Trajectory& path = Path(GetParam(), seed);
    ASSERT_EQ(path.size(), std::size_t{kFrames});
    for (const Step& step : Steps(path)) {
      ASSERT_GE(step.distance_m, 0.010);
      ASSERT_LE(step.distance_m, 0.020);
      ASSERT_GE(step.angle_deg, 0.5);
      ASSERT_LE(step.angle_deg, 1.5);
    }
  }
}

TEST_P(PathInScene, IsSmooth) {
  const Trajectory& path = Path(GetParam(), 1);
  for (std::size_t i = 2; i < path.size(); ++i) {
    const Rigid3d a = path[i - 2].world_from_camera, b = path[i - 1].world_from_camera,
                  c = path[i].world_from_camera;
    const Vector3d turn1 = QuaternionLog(Eigen::Quaterniond(b.rotation * a.rotation.conjugate()));
    const Vector3d turn2 = QuaternionLog(Eigen::Quaterniond(c.rotation * b.rotation.conjugate()));
    // The heading changes by at most 7 deg per frame, and the rotation by 7 deg times 1.5 deg.
    // Looking down, speed changes and hand tremble add to it.
    ASSERT_LT((turn2 - turn1).norm(), 0.5 * kRadPerDeg) << i;
  }
}

TEST_P(PathInScene, HasLevelHorizonAndUnitRotations) {
  for (const StampedPose& pose : Path(GetParam(), 1)) {
    const Eigen::Matrix3d rotation = pose.world_from_camera.rotation.toRotationMatrix();
    EXPECT_NEAR(pose.world_from_camera.rotation.norm(), 1, 1e-12);
    EXPECT_LT(std::abs(rotation(2, 0)),
              std::sin(0.5 * kRadPerDeg));  // the x axis is horizontal, except for tremble
    EXPECT_LT(rotation(2, 1), 0);           // the y axis points down
  }
}

INSTANTIATE_TEST_SUITE_P(All, PathInScene, ::testing::ValuesIn(SceneNames()),
                         [](const auto& instance) { return instance.param; });

TEST(CameraPath, KeepsDistanceToObjectsInRooms) {
  for (const int seed : {1, 2, 3, 4}) {
    const Scene room = MakeScene("room", seed);
    int near = 0;
    for (const StampedPose& pose : Path("room", seed)) {
      const double distance = room.Distance(pose.world_from_camera.translation);
      EXPECT_GT(distance, 0.3);
      if (distance < 0.4) ++near;
    }
    EXPECT_LE(near, 10);
  }
}

// The doorways are 1.2 m wide, and the camera deviates by up to 0.1 m.
TEST(CameraPath, VisitsThreeRoomsAndReturns) {
  const Scene scene = MakeScene("three_rooms", 1);
  const Trajectory path = MakePath(scene, 1500, 1);
  double least_distance = 1, farthest_x = 0;
  int doorways = 0;
  bool was_in_doorway = false;
  for (std::size_t i = 0; i < path.size(); i += 5) {
    const Vector3d eye = path[i].world_from_camera.translation;
    least_distance = std::min(least_distance, scene.Distance(eye));
    farthest_x = std::max(farthest_x, eye.x());
    // Only lintels are above the camera and lower than the lamps.
    const bool in_doorway = eye.z() + scene.Intersect(eye, Vector3d::UnitZ())->t < 2.11;
    if (in_doorway && !was_in_doorway) ++doorways;
    was_in_doorway = in_doorway;
  }
  EXPECT_GT(least_distance, 0.3);
  EXPECT_EQ(doorways, 4);
  EXPECT_GT(farthest_x, 2 * 5.4);  // rooms are at least 5 m long, with a distance of 0.4 m
  const Vector3d gap =
      path.back().world_from_camera.translation - path.front().world_from_camera.translation;
  EXPECT_LT(gap.norm(), 2);
}

// Ratio of frames with at least 80 % of the pixels between 0.4 and 4.5 m on one or two planes.
double PlanarRatio(const Scene& scene, const Trajectory& path) {
  PinholeCamera camera = {80,   60,   525.0 / 8, 525.0 / 8,
                          39.5, 29.5, {}};  // every eighth pixel of 640 x 480
  int planar = 0, frames = 0;
  for (std::size_t i = 0; i < path.size(); i += 4, ++frames) {
    const Rendering image = RenderGeometry(scene, camera, path[i].world_from_camera);
    std::map<std::int32_t, int> faces;
    int seen = 0;
    for (std::size_t k = 0; k < image.depth_m.size(); ++k) {
      if (image.depth_m[k] < 0.4f || image.depth_m[k] > 4.5f) continue;
      ++seen;
      if (Rendering::IsFlat(image.surface[k])) ++faces[image.surface[k]];
    }
    std::vector<int> sizes = {0, 0};
    for (const auto& [face, pixels] : faces) sizes.push_back(pixels);
    std::sort(sizes.rbegin(), sizes.rend());
    if (sizes[0] + sizes[1] >= 0.8 * seen) ++planar;
  }
  return static_cast<double>(planar) / frames;
}

TEST(CameraPath, PlanesDominateOneFifthOfFramesInRooms) {
  for (const int seed : {1, 2, 3, 4}) {
    EXPECT_GE(PlanarRatio(MakeScene("room", seed), Path("room", seed)), 0.2) << seed;
  }
}

TEST(CameraPath, PlanesDominateOneFifthOfFramesOfLongPath) {
  const Scene room = MakeScene("room", 1);
  EXPECT_GE(PlanarRatio(room, MakePath(room, 800, 1)), 0.2);
}

TEST(CameraPath, DependsOnSeed) {
  const Scene room = MakeScene("room", 1);
  const Trajectory a = MakePath(room, 50, 1), again = MakePath(MakeScene("room", 1), 50, 1),
                   b = MakePath(room, 50, 2);
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].world_from_camera.Matrix(), again[i].world_from_camera.Matrix());
  }
  EXPECT_GT((a[0].world_from_camera.translation - b[0].world_from_camera.translation).norm(), 0.01);
}

TEST(CameraPath, HasTimestampsOfFrameRate) {
  PathOptions options;
  options.frames_per_second = 20;
  const Trajectory path = MakePath(MakeScene("wall"), 5, 1, options);
  EXPECT_EQ(path[0].stamp_s, 0);
  EXPECT_DOUBLE_EQ(path[4].stamp_s, 0.2);
}

TEST(CameraPath, RejectsInvalidOptions) {
  const Scene wall = MakeScene("wall");
  ExpectInputError([&] { MakePath(wall, 0, 1); }, Names("frames", 0, 1));
  PathOptions options;
  options.max_turn_deg = 0.1;
  ExpectInputError([&] { MakePath(wall, 5, 1, options); }, Names("max_turn_deg", 0.1));
}

}  // namespace
}  // namespace surfit::testing
