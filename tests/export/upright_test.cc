#include <gmock/gmock.h>

#include "export/room_surfels.h"
#include "output/pictures/pictures.h"
#include "testing/matchers.h"

namespace surfit::testing {
namespace {

// 5 mm noise at 30,000 points: the planes of a room are level within much less than 0.5 degrees.
TEST(Upright, FindsGravityFloorAndWallsOfATiltedRoom) {
  for (int seed = 1; seed <= 5; ++seed) {
    std::mt19937_64 rng(seed);
    std::vector<Surfel> surfels = RoomSurfels(0.005, &rng);
    Trajectory cameras = RoomCameras();
    std::normal_distribution<double> number;
    const Rigid3d world_from_room(QuaternionExp<double>({number(rng), number(rng), number(rng)}),
                                  {number(rng), number(rng), number(rng)});
    Move(world_from_room, &surfels, &cameras);
    const UprightResult result = FindUpright(surfels, cameras);
    ASSERT_TRUE(result.world) << result.reason;
    const Rigid3d upright_from_room = result.world->upright_from_world * world_from_room;
    const Eigen::Vector3d up = upright_from_room.rotation * Eigen::Vector3d::UnitZ();
    EXPECT_LT(std::acos(std::min(1., up.z())), 0.5 * kRadPerDeg);
    // Heights of the corners of the floor.
    EXPECT_NEAR((upright_from_room * Eigen::Vector3d(2, 1.5, 0)).z(), 0, 0.01);
    const Eigen::Vector3d x = upright_from_room.rotation * Eigen::Vector3d::UnitX();
    EXPECT_LT(std::min(std::abs(x.x()), std::abs(x.y())), std::sin(0.5 * kRadPerDeg));
    EXPECT_TRUE(result.world->walls_give_axes);
    EXPECT_LT(result.world->sigma_rad, 0.5 * kRadPerDeg);
    // The area is that of occupied cubes. Cubes whose corners the floor crosses may have no surfel.
    EXPECT_NEAR(result.world->floor_area_m2, 12, 4);
  }
}

TEST(Upright, IsUnknownWithoutHorizontalPlanes) {
  std::mt19937_64 rng(1);
  std::vector<Surfel> surfels;
  AddRectangle({0, 0, 0}, {0, 3, 0}, {0, 0, 2.5}, 0.005, &rng, &surfels);
  const UprightResult result = FindUpright(surfels, RoomCameras());
  EXPECT_FALSE(result.world);
  EXPECT_THAT(result.reason, Names("horizontal"));
}

TEST(Upright, IsUnknownWithoutACommonUpwardDirection) {
  std::mt19937_64 rng(1);
  Trajectory cameras = RoomCameras();
  for (std::size_t i = 0; i < cameras.size(); i += 2) {
    cameras[i].world_from_camera.rotation =
        cameras[i].world_from_camera.rotation * Eigen::Quaterniond(0, 0, 0, 1);
  }
  const UprightResult result = FindUpright(RoomSurfels(0.005, &rng), cameras);
  EXPECT_FALSE(result.world);
  EXPECT_THAT(result.reason, Names("upward"));
}

}  // namespace
}  // namespace surfit::testing
