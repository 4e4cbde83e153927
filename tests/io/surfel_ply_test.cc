#include "surfit/io/surfel_ply.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>

#include "surfit/io/point_cloud.h"
#include "testing/expect_input_error.h"
#include "testing/temp_folder.h"

namespace surfit {
namespace {

using testing::ExpectInputError;
using testing::ReadBytes;
using testing::TempFolder;

Surfel TestSurfel() {
  Surfel s;
  s.position_in_world = {1.f, 2.f, 3.f};
  s.normal_in_world = {0.f, 0.6f, -0.8f};
  s.color = {10, 20, 30};
  s.radius_m = 0.004f;
  s.confidence = 12.5f;
  s.first_seen = 7;
  s.last_seen = 900;
  return s;
}

TEST(WriteSurfelPly, WritesTheDocumentedProperties) {
  const TempFolder dir;
  SurfelMap map;
  map.Append(TestSurfel());
  WriteSurfelPly(map, dir / "map.ply");
  const std::string header =
      "ply\nformat binary_little_endian 1.0\nelement vertex 1\n"
      "property float x\nproperty float y\nproperty float z\n"
      "property float nx\nproperty float ny\nproperty float nz\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\n"
      "property float radius\nproperty float confidence\n"
      "property int first_seen\nproperty int last_seen\nend_header\n";
  const std::string bytes = ReadBytes(dir / "map.ply");
  ASSERT_EQ(bytes.size(), header.size() + 6 * 4 + 3 + 2 * 4 + 2 * 4);
  EXPECT_EQ(bytes.substr(0, header.size()), header);
  float own[2];
  std::memcpy(own, &bytes[header.size() + 27], 8);
  EXPECT_EQ(own[0], 0.004f);
  EXPECT_EQ(own[1], 12.5f);
  std::int32_t seen[2];
  std::memcpy(seen, &bytes[header.size() + 35], 8);
  EXPECT_EQ(seen[0], 7);
  EXPECT_EQ(seen[1], 900);
}

TEST(WriteSurfelPly, IsReadAsAPointCloud) {
  const TempFolder dir;
  SurfelMap map;
  for (int i = 0; i < 3; ++i) {
    Surfel s = TestSurfel();
    s.position_in_world.x() = static_cast<float>(i);
    s.color.r = static_cast<std::uint8_t>(100 + i);
    map.Append(s);
  }
  WriteSurfelPly(map, dir / "map.ply");
  const PointCloud cloud = ReadPly(dir / "map.ply");
  ASSERT_EQ(cloud.points.size(), 3u);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(cloud.points[i], Eigen::Vector3f(i, 2, 3));
    EXPECT_EQ(cloud.normals[i], Eigen::Vector3f(0.f, 0.6f, -0.8f));
    EXPECT_EQ(cloud.colors[i], (Rgb8{static_cast<std::uint8_t>(100 + i), 20, 30}));
  }
}

TEST(WriteSurfelPly, WritesAnEmptyMap) {
  const TempFolder dir;
  WriteSurfelPly(SurfelMap(), dir / "map.ply");
  EXPECT_TRUE(ReadPly(dir / "map.ply").points.empty());
}

TEST(ReadSurfelPly, ReadsWhatWasWritten) {
  const TempFolder dir;
  SurfelMap map;
  map.Append(TestSurfel());
  WriteSurfelPly(map, dir / "map.ply");
  const std::vector<Surfel> surfels = ReadSurfelPly(dir / "map.ply");
  ASSERT_EQ(surfels.size(), 1u);
  const Surfel expected = map[map.Ids()[0]];
  EXPECT_EQ(surfels[0].position_in_world, expected.position_in_world);
  EXPECT_EQ(surfels[0].normal_in_world, expected.normal_in_world);
  EXPECT_EQ(surfels[0].color, expected.color);
  EXPECT_EQ(surfels[0].radius_m, expected.radius_m);
  EXPECT_EQ(surfels[0].confidence, expected.confidence);
  EXPECT_EQ(surfels[0].first_seen, 7);
  EXPECT_EQ(surfels[0].last_seen, 900);
}

TEST(ReadSurfelPly, RefusesACloudThatIsNoMap) {
  const TempFolder dir;
  WritePly({{Eigen::Vector3f(1, 2, 3)}, {}, {}}, dir / "cloud.ply");
  ExpectInputError([&] { ReadSurfelPly(dir / "cloud.ply"); },
                   ::testing::HasSubstr("'vertex' has no property nx"));
}

}  // namespace
}  // namespace surfit
