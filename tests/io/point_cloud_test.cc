#include "surfit/io/point_cloud.h"

#include <gmock/gmock.h>

#include <cmath>
#include <cstring>

#include "surfit/core/error.h"
#include "testing/matchers.h"
#include "testing/recordings.h"
#include "testing/temp_folder.h"

namespace surfit::testing {
namespace {

using V = Eigen::Vector3f;

constexpr char kBinary[] = "ply\nformat binary_little_endian 1.0\n";
constexpr char kAscii[] = "ply\nformat ascii 1.0\n";
constexpr char kXyz[] = "property float x\nproperty float y\nproperty float z\n";

TEST(Ply, RoundTripsClouds) {
  const TempFolder dir;
  const std::string path = dir / "a.ply";
  PointCloud cloud;
  cloud.points = {{1.f, -2.f, 1e-30f}, {4.f, 5.f, 6.f}};
  WritePly(cloud, path);
  EXPECT_EQ(ReadPly(path).points, cloud.points);
  EXPECT_THAT(ReadPly(path).normals, IsEmpty());
  EXPECT_THAT(ReadPly(path).colors, IsEmpty());
  EXPECT_THAT(ReadPly(path).radii_m, IsEmpty());
  cloud.normals = {{0, 0, 1}, {0, -1, 0}};
  cloud.colors = {{1, 2, 255}, {0, 10, 13}};
  cloud.radii_m = {0.5f, 0.25f};
  WritePly(cloud, path);
  EXPECT_EQ(ReadPly(path).points, cloud.points);
  EXPECT_EQ(ReadPly(path).normals, cloud.normals);
  EXPECT_EQ(ReadPly(path).colors, cloud.colors);
  EXPECT_EQ(ReadPly(path).radii_m, cloud.radii_m);
}

TEST(Ply, WritesTheBytesOfTheFormat) {
  const TempFolder dir;
  PointCloud cloud;
  cloud.points = {{1, 2, 3}};
  cloud.colors = {{7, 8, 9}};
  WritePly(cloud, dir / "a.ply");
  EXPECT_EQ(ReadBytes(dir / "a.ply"),
            std::string(kBinary) + "element vertex 1\n" + kXyz +
                "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n" +
                LittleEndian(1.f, 2.f, 3.f, std::uint8_t{7}, std::uint8_t{8}, std::uint8_t{9}));
}

TEST(Ply, ReadsAnEmptyCloud) {
  const TempFolder dir;
  WritePly(PointCloud(), dir / "a.ply");
  EXPECT_THAT(ReadPly(dir / "a.ply").points, IsEmpty());
}

TEST(Ply, ReadsAscii) {
  const TempFolder dir;
  const std::string path =
      dir.Write("a.ply", std::string(kAscii) +
                             "comment by hand\r\nobj_info x\nelement vertex 2\n"
                             "property uchar red\nproperty uchar green\nproperty uchar blue\n" +
                             kXyz + "end_header\n255 0 7 1 -2.5 3e-2\r\n1 2 3\t4 nan 6");
  const PointCloud cloud = ReadPly(path);
  EXPECT_THAT(cloud.colors, ElementsAre(Rgb8{255, 0, 7}, Rgb8{1, 2, 3}));
  ASSERT_EQ(cloud.points.size(), 2u);
  EXPECT_EQ(cloud.points[0], V(1.f, -2.5f, 3e-2f));
  EXPECT_TRUE(std::isnan(cloud.points[1].y()));
}

TEST(Ply, ReadsEveryScalarTypeByBothNames) {
  const TempFolder dir;
  const std::string path = dir.Write(
      "a.ply", std::string(kBinary) +
                   "element vertex 1\nproperty char a\nproperty uint8 b\n"
                   "property double z\nproperty uint16 c\nproperty short y\n"
                   "property uint d\nproperty int32 x\nproperty float32 e\nend_header\n" +
                   LittleEndian(std::int8_t{1}, std::uint8_t{2}, 0.5, std::uint16_t{3},
                                std::int16_t{-300}, std::uint32_t{4}, std::int32_t{-5}, 6.f));
  EXPECT_THAT(ReadPly(path).points, ElementsAre(V(-5.f, -300.f, 0.5f)));
}

TEST(Ply, IgnoresColorsOfOtherTypes) {
  const TempFolder dir;
  const std::string path = dir.Write(
      "a.ply", std::string(kAscii) + "element vertex 1\n" + kXyz +
                   "property float red\nproperty float green\nproperty float blue\nend_header\n"
                   "1 2 3 0.1 0.2 0.3\n");
  EXPECT_THAT(ReadPly(path).colors, IsEmpty());
}

TEST(Ply, SkipsOtherElementsAndLists) {
  const TempFolder dir;
  const std::string header = std::string("element face 2\nproperty list uchar int vertices\n") +
                             "property float area\nelement vertex 2\n" +
                             "property list ushort double history\n" + kXyz +
                             "element edge 1\nproperty int from\nend_header\n";
  const std::string ascii = dir.Write("a.ply", kAscii + header +
                                                   "3 0 1 2 0.5\n0 0.25\n"
                                                   "2 8 9 1 2 3\n0 4 5 6\n7\n");
  EXPECT_THAT(ReadPly(ascii).points, ElementsAre(V(1, 2, 3), V(4, 5, 6)));
  const std::string binary =
      dir.Write("b.ply", kBinary + header + LittleEndian(std::uint8_t{3}, 0, 1, 2, 0.5f) +
                             LittleEndian(std::uint8_t{0}, 0.25f) +
                             LittleEndian(std::uint16_t{2}, 8.0, 9.0, 1.f, 2.f, 3.f) +
                             LittleEndian(std::uint16_t{0}, 4.f, 5.f, 6.f) + LittleEndian(7));
  EXPECT_THAT(ReadPly(binary).points, ElementsAre(V(1, 2, 3), V(4, 5, 6)));
}

class MalformedPly : public ::testing::TestWithParam<MalformedFile> {};

TEST_P(MalformedPly, IsRejectedByFileLineAndValue) {
  const TempFolder dir;
  const std::string path = dir.Write("bad.ply", GetParam().content);
  EXPECT_THAT([&] { ReadPly(path); },
              ThrowsMessage<InputError>(AllOf(Names(path), NamesMatcher(GetParam().names))));
}

std::string Header(const std::string& format, const std::string& rest) {
  return "ply\nformat " + format + "\n" + rest + "end_header\n";
}
std::string Vertices(const std::string& format, const std::string& count) {
  return Header(format, "element vertex " + count + "\n" + kXyz);
}
constexpr char kB[] = "binary_little_endian 1.0", kA[] = "ascii 1.0";
const std::string kRow = LittleEndian(1.f, 2.f, 3.f);

const std::vector<MalformedFile> kMalformedPlyHeader = {
    {"Empty", "", {"PLY"}},
    {"Png", "\x89PNG\r\n", {"PLY"}},
    {"Plyx", "plyx\n", {"PLY"}},
    {"OnlyMagic", "ply\n", {"end_header"}},
    {"NoEnd", "ply\nformat ascii 1.0\nelement vertex 1", {"end_header"}},
    {"NoFormat", "ply\nelement vertex 0\n" + std::string(kXyz) + "end_header\n", {"format"}},
    {"MiddleEndian", Vertices("binary_middle_endian 1.0", "0"), {"bad.ply:2"}},
    {"Version2", Vertices("ascii 2.0", "0"), {"bad.ply:2"}},
    {"NoVertex", Header(kA, ""), {"vertex"}},
    {"NoX", Header(kA, "element vertex 0\nproperty float y\nproperty float z\n"), {"x", "y", "z"}},
    {"XIsAList",
     Header(kA,
            "element vertex 0\nproperty list int float x\nproperty float y\n"
            "property float z\n"),
     {"x", "y", "z"}},
    {"NegativeCount", Vertices(kB, "-1"), {"bad.ply:3", "-1"}},
    {"FractionalCount", Vertices(kB, "1.5"), {"bad.ply:3", "1.5"}},
    {"OverflowingCount",
     Vertices(kB, "99999999999999999999"),
     {"bad.ply:3", "99999999999999999999"}},
    {"ElementWithoutCount", Header(kA, "element vertex\n"), {"bad.ply:3", "element"}},
    {"PropertyFirst", Header(kA, "property float x\n"), {"bad.ply:3", "property"}},
    {"UnknownType", Header(kA, "element vertex 1\nproperty real x\n"), {"bad.ply:4", "real"}},
    {"ShortList", Header(kA, "element vertex 1\nproperty list int x\n"), {"bad.ply:4"}},
    {"UnknownWord", Header(kA, "vertices 3\n"), {"bad.ply:3", "vertices"}},
};

INSTANTIATE_TEST_SUITE_P(Header, MalformedPly, ::testing::ValuesIn(kMalformedPlyHeader),
                         [](const auto& test) { return test.param.name; });

const std::vector<MalformedFile> kMalformedPlyBody = {
    {"NoBody", Vertices(kB, "1"), {"vertex", "1"}},
    {"Truncated", Vertices(kB, "2") + kRow + kRow.substr(0, 11), {"vertex", "2"}},
    // 2^63 - 1 rows: the size in bytes overflows.
    {"HugeCount", Vertices(kB, "9223372036854775807") + kRow, {"vertex", "9223372036854775807"}},
    {"HugeCountAscii",
     Vertices(kA, "9223372036854775807") + "1 2 3\n",
     {"vertex", "9223372036854775807"}},
    {"HugeOtherElement",
     Header(kB,
            "element face 9000000000000000000\nproperty list uchar int i\n"
            "element vertex 1\n" +
                std::string(kXyz)) +
         kRow,
     {"face", "9000000000000000000"}},
    {"HugeList",
     Header(kB,
            "element face 1\nproperty list uint double i\nelement vertex 1\n" + std::string(kXyz)) +
         LittleEndian(0xffffffffu) + kRow,
     {"face", "0"}},
    {"NegativeList",
     Header(kB,
            "element face 1\nproperty list int double i\nelement vertex 1\n" + std::string(kXyz)) +
         LittleEndian(-1) + kRow,
     {"face", "0", "i", "-1"}},
    {"FractionalList",
     Header(kA,
            "element face 1\nproperty list float int i\nelement vertex 1\n" + std::string(kXyz)) +
         "1.5 1\n1 2 3\n",
     {"face", "0", "i", "1.5"}},
    {"TruncatedAfterList",
     Header(kB,
            "element face 1\nproperty list uchar uchar i\nelement vertex 1\n" + std::string(kXyz)) +
         LittleEndian(std::uint8_t{5}) + std::string(5, 'x') + kRow.substr(1),
     {"vertex"}},
    {"AsciiTruncated", Vertices(kA, "2") + "1.25 2.25 3.25\n4 5", {"1"}},
    {"AsciiShortRow", Vertices(kA, "2") + "1 2\n3 4 5 6\n", {"0"}},
    {"AsciiLongRow", Vertices(kA, "2") + "1 2 3 4\n5 6\n", {"0"}},
    {"AsciiWord", Vertices(kA, "1") + "1 two 3\n", {"0"}},
    {"AsciiSuffix", Vertices(kA, "1") + "1 2m 3\n", {"0"}},
};

INSTANTIATE_TEST_SUITE_P(Body, MalformedPly, ::testing::ValuesIn(kMalformedPlyBody),
                         [](const auto& test) { return test.param.name; });

TEST(Ply, RejectsUnreadableFile) {
  EXPECT_THAT([] { ReadPly("/no/such.ply"); }, ThrowsNaming<InputError>("/no/such.ply"));
}

Surfel TestSurfel() {
  Surfel s;
  s.position_in_world = {1.f, 2.f, 3.f};
  s.normal_in_world = {0.f, 0.6f, -0.8f};
  s.color = {10, 20, 30};
  s.radius_m = 0.004f;
  s.confidence = 12.5f;
  s.first_seen = 7;
  s.last_seen = 900;
  s.from_stereo = true;
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
      "property int first_seen\nproperty int last_seen\nproperty uchar from_stereo\nend_header\n";
  const std::string bytes = ReadBytes(dir / "map.ply");
  ASSERT_EQ(bytes.size(), header.size() + 6 * 4 + 3 + 2 * 4 + 2 * 4 + 1);
  EXPECT_EQ(bytes.substr(0, header.size()), header);
  float own[2];
  std::memcpy(own, &bytes[header.size() + 27], 8);
  EXPECT_EQ(own[0], map[0].radius_m);
  EXPECT_NEAR(own[0], 0.004, 0.004 / 2048);
  EXPECT_EQ(own[1], 12.5f);
  std::int32_t seen[2];
  std::memcpy(seen, &bytes[header.size() + 35], 8);
  EXPECT_EQ(seen[0], 7);
  EXPECT_EQ(seen[1], 900);
  EXPECT_EQ(bytes.back(), 1);
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
    EXPECT_EQ(cloud.normals[i], map[map.Ids()[i]].normal_in_world);
    EXPECT_LT((cloud.normals[i] - Eigen::Vector3f(0.f, 0.6f, -0.8f)).norm(), 1.0 / 32767);
    EXPECT_EQ(cloud.colors[i], (Rgb8{static_cast<std::uint8_t>(100 + i), 20, 30}));
  }
}

TEST(WriteSurfelPly, WritesAnEmptyMap) {
  const TempFolder dir;
  WriteSurfelPly(SurfelMap(), dir / "map.ply");
  EXPECT_TRUE(ReadPly(dir / "map.ply").points.empty());
}

TEST(ReadSurfelPly, RoundTripsMaps) {
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
  EXPECT_TRUE(surfels[0].from_stereo);
}

TEST(ReadSurfelPly, ReadsMapsOfVersion01) {
  const TempFolder dir;
  SurfelMap map;
  map.Append(TestSurfel());
  WriteSurfelPly(map, dir / "map.ply");
  std::string bytes = ReadBytes(dir / "map.ply");
  const std::string property = "property uchar from_stereo\n";
  bytes.erase(bytes.find(property), property.size());
  bytes.pop_back();
  WriteBytes(dir / "old.ply", bytes);
  const std::vector<Surfel> surfels = ReadSurfelPly(dir / "old.ply");
  ASSERT_EQ(surfels.size(), 1u);
  EXPECT_EQ(surfels[0].last_seen, 900);
  EXPECT_FALSE(surfels[0].from_stereo);
}

TEST(ReadSurfelPly, RejectsACloudThatIsNoMap) {
  const TempFolder dir;
  WritePly({{Eigen::Vector3f(1, 2, 3)}, {}, {}}, dir / "cloud.ply");
  ExpectInputError([&] { ReadSurfelPly(dir / "cloud.ply"); }, Names("cloud.ply", "vertex", "nx"));
}

}  // namespace
}  // namespace surfit::testing
