#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "surfit/io/point_cloud.h"
#include "testing/expect_input_error.h"
#include "testing/temp_folder.h"

namespace surfit {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::TempFolder;

TEST(WritePcd, CloudsComeBackAsTheyWere) {
  const TempFolder folder;
  PointCloud cloud = {
      {{1, -2.5f, 3e-7f}, {4, 5, 6}}, {{0, 0, 1}, {0, -1, 0}}, {{200, 160, 1}, {255, 127, 255}}};
  WritePcd(cloud, folder / "all.pcd");
  PointCloud read = ReadPointCloud(folder / "all.pcd");
  EXPECT_EQ(read.points, cloud.points);
  EXPECT_EQ(read.normals, cloud.normals);
  EXPECT_EQ(read.colors, cloud.colors);
  cloud.normals.clear();
  cloud.colors.clear();
  WritePcd(cloud, folder / "points.pcd");
  read = ReadPointCloud(folder / "points.pcd");
  EXPECT_EQ(read.points, cloud.points);
  EXPECT_THAT(read.normals, IsEmpty());
  EXPECT_THAT(read.colors, IsEmpty());
}

TEST(WritePcd, WritesTheHeaderOfTheFormat) {
  const TempFolder folder;
  WritePcd({{{1, 2, 3}}, {{0, 0, 1}}, {{1, 2, 3}}}, folder / "a.pcd");
  const std::string expected =
      "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\n"
      "FIELDS x y z normal_x normal_y normal_z rgb\nSIZE 4 4 4 4 4 4 4\nTYPE F F F F F F F\n"
      "COUNT 1 1 1 1 1 1 1\nWIDTH 1\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 1\nDATA binary\n";
  const std::string file = testing::ReadBytes(folder / "a.pcd");
  EXPECT_EQ(file.substr(0, expected.size()), expected);
  EXPECT_EQ(file.size(), expected.size() + 7 * 4);
  testing::ExpectInputError([] { WritePcd({}, "/nowhere/a.pcd"); }, HasSubstr("/nowhere/a.pcd"));
}

}  // namespace
}  // namespace surfit
