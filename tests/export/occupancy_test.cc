#include "apps/export/occupancy.h"

#include <gmock/gmock.h>

#include <algorithm>

#include "export/room_surfels.h"
#include "testing/matchers.h"
#include "testing/temp_folder.h"

namespace surfit::testing {
namespace {

// Room of RoomSurfels(), seen from its centre.
UprightMap MapOfRoom() {
  std::mt19937_64 rng(1);
  UprightMap map;
  map.surfels = RoomSurfels(0.003, &rng);
  map.observers.assign(map.surfels.size(), {2, 0.5, 1.4});
  for (const StampedPose& pose : RoomCameras()) {
    map.path.push_back(pose.world_from_camera.translation);
  }
  return map;
}

CellState At(const OccupancyGrid& grid, double x, double y) {
  const Eigen::Vector2d cell = (Eigen::Vector2d(x, y) - grid.origin_m) / grid.cell_m;
  return grid.cells(static_cast<int>(cell.x()), static_cast<int>(cell.y()));
}

TEST(Occupancy, WallsAndTableAreOccupiedAndTheFloorIsFree) {
  const OccupancyGrid grid = MakeOccupancyGrid(MapOfRoom());
  EXPECT_EQ(At(grid, 3.99, 1.5), CellState::kOccupied);
  EXPECT_EQ(At(grid, 1, 0.01), CellState::kOccupied);
  EXPECT_EQ(At(grid, 2, 1.3), CellState::kOccupied);  // table
  EXPECT_EQ(At(grid, 0.5, 0.5), CellState::kFree);
  EXPECT_EQ(At(grid, 3.5, 2.5), CellState::kFree);
  EXPECT_EQ(At(grid, -0.2, 1), CellState::kUnknown);
  EXPECT_EQ(At(grid, 4.2, 1), CellState::kUnknown);
}

TEST(Occupancy, WallLinesAreThoseOfTheRoom) {
  const UprightMap map = MapOfRoom();
  const std::vector<WallLine> walls = FindWallLines(map, MakeOccupancyGrid(map));
  ASSERT_EQ(walls.size(), 4u);
  std::vector<double> lengths;
  for (const WallLine& wall : walls) {
    lengths.push_back((wall.end - wall.begin).norm());
    // Both ends are on one wall.
    const auto is_on = [&](int axis, double value) {
      return std::abs(wall.begin[axis] - value) < 0.01 && std::abs(wall.end[axis] - value) < 0.01;
    };
    EXPECT_TRUE(is_on(0, 0) || is_on(0, 4) || is_on(1, 0) || is_on(1, 3));
  }
  EXPECT_NEAR(lengths[0], 4, 0.1);
  EXPECT_NEAR(lengths[1], 4, 0.1);
  EXPECT_NEAR(lengths[2], 3, 0.1);
  EXPECT_NEAR(lengths[3], 3, 0.1);
}

// map_server: the first row of the image has the largest y, and the origin is the lower left
// corner.
TEST(Occupancy, WritesTheFilesOfTheMapServer) {
  const TempFolder folder;
  OccupancyGrid grid;
  grid.cells = Image<CellState>(2, 3, CellState::kUnknown);
  grid.cells(0, 0) = CellState::kOccupied;
  grid.cells(1, 2) = CellState::kFree;
  grid.origin_m = {-1.5, 0.25};
  WriteRosMap(grid, folder.path());
  const std::string unknown(1, '\xcd');
  EXPECT_EQ(ReadBytes(folder / "map.pgm"), "P5\n2 3\n255\n" + unknown + "\xfe" + unknown + unknown +
                                               std::string(1, '\0') + unknown);
  EXPECT_THAT(ReadBytes(folder / "map.yaml"),
              AllOf(HasSubstr("image: map.pgm\n"), HasSubstr("resolution: 0.05\n"),
                    HasSubstr("origin: [-1.5, 0.25, 0.0]\n"), HasSubstr("negate: 0\n")));
  WriteFloorPlan(grid, {{{-1.5, 0.25}, {-1.4, 0.25}}}, {}, folder / "plan.svg");
  EXPECT_THAT(
      ReadBytes(folder / "plan.svg"),
      AllOf(StartsWith("<svg "), HasSubstr("<line x1=\"0\" y1=\"15\" x2=\"10\" y2=\"15\"/>"),
            HasSubstr("1 m"), ::testing::EndsWith("</svg>\n")));
}

// The camera walks outside the grid.
TEST(FloorPlan, HasItsScaleBarBelowThePath) {
  OccupancyGrid grid;
  grid.cells = Image<CellState>(2, 3, CellState::kFree);
  const TempFolder folder;
  WriteFloorPlan(grid, {}, {{-1, 0.1, 1}, {0.05, -2, 1}}, folder / "plan.svg");
  EXPECT_THAT(ReadBytes(folder / "plan.svg"),
              AllOf(HasSubstr("viewBox=\"-100 0 110 275\""), HasSubstr("points=\"-100,5 5,215 \""),
                    HasSubstr("d=\"M-80 224v12m0-6h100m0-6v12\"")));
}

}  // namespace
}  // namespace surfit::testing
