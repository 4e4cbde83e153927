#include <gmock/gmock.h>

#include <cmath>

#include "surfit/core/error.h"
#include "surfit/io/point_cloud.h"
#include "testing/matchers.h"
#include "testing/recordings.h"
#include "testing/temp_folder.h"

namespace surfit::testing {
namespace {

using V = Eigen::Vector3f;

std::string Header(const std::string& fields, const std::string& sizes, const std::string& types,
                   int count, const std::string& data) {
  return "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS " + fields + "\nSIZE " +
         sizes + "\nTYPE " + types + "\nWIDTH " + std::to_string(count) +
         "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + std::to_string(count) + "\nDATA " + data +
         "\n";
}
std::string XyzHeader(int count, const std::string& data) {
  return Header("x y z", "4 4 4", "F F F", count, data);
}

PointCloud Read(const std::string& bytes) {
  const TempFolder folder;
  return ReadPointCloud(folder.Write("a.pcd", bytes));
}

// Compressed size, uncompressed size and data of a binary_compressed body.
std::string Compressed(std::uint32_t size, const std::string& lzf) {
  return LittleEndian(static_cast<std::uint32_t>(lzf.size()), size) + lzf;
}

TEST(Pcd, ReadsAscii) {
  // 5.9235689e-39 is the float with the bits 0x00408080.
  const PointCloud cloud = Read(
      Header("x y z rgb normal_x normal_y normal_z", "4 4 4 4 4 4 4", "F F F F F F F", 2, "ascii") +
      "1 -2.5 3e-2 5.9235689e-39 0 0 1\nnan nan nan 0 0 -1 0\n");
  ASSERT_EQ(cloud.points.size(), 2u);
  EXPECT_EQ(cloud.points[0], V(1, -2.5f, 3e-2f));
  EXPECT_TRUE(std::isnan(cloud.points[1].x()));
  EXPECT_THAT(cloud.normals, ElementsAre(V(0, 0, 1), V(0, -1, 0)));
  EXPECT_THAT(cloud.colors, ElementsAre(Rgb8{0x40, 0x80, 0x80}, Rgb8{0, 0, 0}));
}

// The bits 0xffffa001 are a NaN. The colour must keep them.
TEST(Pcd, ReadsBinaryOfMixedTypes) {
  const PointCloud cloud =
      Read(Header("z _ rgb y x label", "8 1 4 4 2 4", "F U F F I U", 2, "binary") +
           LittleEndian(3., '?', 0xffffa001u, 2.f, std::int16_t{-1}, 7u) +
           LittleEndian(6., '?', 0x00010203u, 5.f, std::int16_t{4}, 8u));
  EXPECT_THAT(cloud.points, ElementsAre(V(-1, 2, 3), V(4, 5, 6)));
  EXPECT_THAT(cloud.colors, ElementsAre(Rgb8{255, 160, 1}, Rgb8{1, 2, 3}));
  EXPECT_THAT(cloud.normals, IsEmpty());
}

TEST(Pcd, SkipsFieldsOfSeveralValues) {
  std::string header = Header("f x y z", "4 4 4 4", "F F F F", 1, "binary");
  header.replace(header.find("WIDTH"), 0, "COUNT 3 1 1 1\n");
  const PointCloud cloud = Read(header + LittleEndian(9.f, 9.f, 9.f, 1.f, 2.f, 3.f));
  EXPECT_THAT(cloud.points, ElementsAre(V(1, 2, 3)));
}

TEST(Pcd, CountsOrganizedCloudsByWidthAndHeight) {
  std::string text = XyzHeader(6, "ascii") + "1 1 1\n2 2 2\n3 3 3\n4 4 4\n5 5 5\n6 6 6";
  text.replace(text.find("WIDTH 6\nHEIGHT 1"), 16, "WIDTH 3\nHEIGHT 2");
  EXPECT_EQ(Read(text).points.size(), 6u);
  text.erase(text.find("POINTS 6\n"), 9);
  EXPECT_EQ(Read(text).points.size(), 6u);
}

TEST(Pcd, ReadsCompressedLiterals) {
  // Fields are stored one after another: x of both points, then y, then z. A control byte c < 32 is
  // followed by c + 1 literal bytes.
  const std::string columns = LittleEndian(1.f, 4.f, 2.f, 5.f, 3.f, 6.f);
  const PointCloud cloud = Read(XyzHeader(2, "binary_compressed") +
                                Compressed(24, std::string(1, 23) + columns) + "rest");
  EXPECT_THAT(cloud.points, ElementsAre(V(1, 2, 3), V(4, 5, 6)));
}

TEST(Pcd, ReadsCompressedMatches) {
  // 300 equal floats: 4 literal bytes, then 1196 bytes copied with distance 4. The matches have 4 x
  // 264 = 7 + 255 + 2 bytes and 140 = 7 + 131 + 2 bytes. A long match is 111 (3 bits), the upper 5
  // bits of distance - 1, length - 9, and the lower 8 bits of distance - 1.
  std::string lzf = std::string(1, 3) + LittleEndian(1.5f);
  for (const int rest : {255, 255, 255, 255, 131}) {
    lzf += {static_cast<char>(7 << 5), static_cast<char>(rest), 3};
  }
  const PointCloud cloud = Read(XyzHeader(100, "binary_compressed") + Compressed(1200, lzf));
  EXPECT_EQ(cloud.points, std::vector<V>(100, V(1.5f, 1.5f, 1.5f)));
}

TEST(Pcd, ReadsShortMatchesAtLongDistance) {
  // 300 bytes: x of 25 points is literal. y repeats x in matches of 4 bytes (length 2 + 2) with
  // distance 100, and z in matches with distance 200.
  std::string lzf;
  for (int i = 0; i < 25; ++i) lzf += std::string(1, 3) + LittleEndian(static_cast<float>(i));
  for (const int distance : {100, 200}) {
    for (int i = 0; i < 25; ++i) {
      lzf += {static_cast<char>(2 << 5 | (distance - 1) >> 8), static_cast<char>(distance - 1)};
    }
  }
  const PointCloud cloud = Read(XyzHeader(25, "binary_compressed") + Compressed(300, lzf));
  ASSERT_EQ(cloud.points.size(), 25u);
  for (int i = 0; i < 25; ++i) EXPECT_EQ(cloud.points[i], V::Constant(static_cast<float>(i)));
}

class MalformedPcd : public ::testing::TestWithParam<MalformedFile> {};

TEST_P(MalformedPcd, IsRejectedByFileAndValue) {
  const TempFolder folder;
  const std::string path = folder.Write("bad.pcd", GetParam().content);
  EXPECT_THAT([&] { ReadPointCloud(path); },
              ThrowsMessage<InputError>(AllOf(Names(path), NamesMatcher(GetParam().names))));
}

std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

const std::string kOneAscii = XyzHeader(1, "ascii") + "1 2 3\n";
const std::string kPacked = XyzHeader(1, "binary_compressed");

const std::vector<MalformedFile> kMalformedPcdFiles = {
    {"Empty", "", {"DATA"}},
    {"Text", "Once upon a time\n", {"PLY"}},
    {"NoFields", Replaced(kOneAscii, "FIELDS x y z\n", ""), {"FIELDS"}},
    {"NoZ", Replaced(kOneAscii, "x y z", "x y w"), {"FIELDS", "x", "y", "z"}},
    {"FewSizes", Replaced(kOneAscii, "4 4 4", "4 4"), {"SIZE", "2", "3"}},
    {"OddSize", Replaced(kOneAscii, "4 4 4", "4 4 3"), {"F", "3"}},
    {"OddType", Replaced(kOneAscii, "F F F", "F F Q"), {"Q", "4"}},
    {"OddData", Replaced(kOneAscii, "DATA ascii", "DATA zip"), {"DATA", "zip"}},
    {"OddCount", Replaced(kOneAscii, "WIDTH 1", "WIDTH one"), {"one"}},
    {"OtherCount", Replaced(kOneAscii, "POINTS 1", "POINTS 2"), {"POINTS", "2"}},
    {"ManyValues",
     Replaced(kOneAscii, "WIDTH", "COUNT 1 1 99999999\nWIDTH"),
     {"COUNT", "99999999"}},
    {"HugeProduct",
     Replaced(Replaced(kOneAscii, "WIDTH 1", "WIDTH 9000000000000000000"), "HEIGHT 1", "HEIGHT 2"),
     {"WIDTH", "HEIGHT"}},
    {"Huge",
     Replaced(Replaced(kOneAscii, "WIDTH 1", "WIDTH 9000000000000000000"), "POINTS 1",
              "POINTS 9000000000000000000"),
     {"9000000000000000000"}},
    {"ShortAscii", XyzHeader(1, "ascii") + "1.25 2.25\n", {"0"}},
    {"ShortBinary", XyzHeader(2, "binary") + LittleEndian(1.f, 2.f, 3.f), {"2"}},
    {"PackedNothing", kPacked, {}},
    {"PackedShort", kPacked + LittleEndian(100u, 12u) + "abc", {}},
    {"PackedOtherSize", kPacked + Compressed(13, "abc"), {"13"}},
    {"PackedHuge", XyzHeader(300000000, "binary_compressed") + Compressed(3600000000u, "abc"), {}},
    {"LiteralsEndEarly",
     kPacked + Compressed(12,
                          "\x0b"
                          "abc"),
     {}},
    {"LiteralsTooMany", kPacked + Compressed(12, std::string(1, 12) + std::string(13, 'a')), {}},
    {"MatchBeforeTheStart", kPacked + Compressed(12, std::string("\0a\x20\x05", 4)), {}},
    {"MatchEndsEarly", kPacked + Compressed(12, std::string("\0a\x20", 3)), {}},
    {"MatchTooLong", kPacked + Compressed(12, std::string("\0a\xe0\xff\0", 5)), {}},
    {"TooLittle", kPacked + Compressed(12, std::string("\0a", 2)), {}},
};

INSTANTIATE_TEST_SUITE_P(Files, MalformedPcd, ::testing::ValuesIn(kMalformedPcdFiles),
                         [](const auto& test) { return test.param.name; });

TEST(ReadPointCloud, DetectsPlyByItsFirstLine) {
  const TempFolder folder;
  WritePly({{{1, 2, 3}}, {}, {}}, folder / "a.pcd");
  EXPECT_THAT(ReadPointCloud(folder / "a.pcd").points, ElementsAre(V(1, 2, 3)));
  EXPECT_THAT([] { ReadPointCloud("/no/such.ply"); }, ThrowsNaming<InputError>("/no/such.ply"));
}

TEST(RemoveNonFinite, KeepsNormalsAndColoursWithTheirPoints) {
  const float inf = std::numeric_limits<float>::infinity(), nan = std::nanf("");
  PointCloud cloud = {{{nan, 0, 0}, {1, 1, 1}, {0, inf, 0}, {2, 2, 2}, {0, 0, nan}},
                      {{0, 0, 1}, {1, 0, 0}, {0, 0, 1}, {0, 1, 0}, {0, 0, 1}},
                      {{1, 1, 1}, {2, 2, 2}, {3, 3, 3}, {4, 4, 4}, {5, 5, 5}}};
  EXPECT_EQ(RemoveNonFinite(&cloud), 3u);
  EXPECT_THAT(cloud.points, ElementsAre(V(1, 1, 1), V(2, 2, 2)));
  EXPECT_THAT(cloud.normals, ElementsAre(V(1, 0, 0), V(0, 1, 0)));
  EXPECT_THAT(cloud.colors, ElementsAre(Rgb8{2, 2, 2}, Rgb8{4, 4, 4}));
  cloud = {{{nan, 0, 0}}, {}, {}};
  EXPECT_EQ(RemoveNonFinite(&cloud), 1u);
  EXPECT_THAT(cloud.points, IsEmpty());
}

TEST(WritePcd, RoundTripsClouds) {
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

// Coordinates of a survey, and a difference below the precision of a float at 4500 km.
TEST(WritePcd, AddsTheOrigin) {
  const TempFolder folder;
  PointCloud cloud = {{{1, -2.5f, 0.125f}, {4, 5, 6.015625f}}, {}, {{1, 2, 3}, {4, 5, 6}}};
  cloud.origin = {500000, 4500000, 120};
  WritePcd(cloud, folder / "a.pcd");
  const PointCloud read = ReadPointCloudAboutOrigin(folder / "a.pcd");
  ASSERT_EQ(read.points.size(), 2u);
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(read.origin + read.points[i].cast<double>(),
              cloud.origin + cloud.points[i].cast<double>());
  }
  EXPECT_EQ(read.colors, cloud.colors);
}

TEST(WritePcd, RejectsAttributesOfAnotherSize) {
  const TempFolder folder;
  PointCloud cloud = {{{1, 2, 3}, {4, 5, 6}}, {}, {}};
  cloud.radii_m = {0.01f};
  const auto expect_refused = [&](const char* attribute, int size) {
    ExpectInputError([&] { WritePcd(cloud, folder / "a.pcd"); },
                     Names("a.pcd", 2, size, attribute));
    ExpectInputError([&] { WritePly(cloud, folder / "a.ply"); }, Names(2, size));
    ExpectInputError([&] { RemoveNonFinite(&cloud); }, Names(2, size));
  };
  expect_refused("radii_m", 1);
  cloud.radii_m.clear();
  cloud.confidences = {1, 2, 3};
  expect_refused("confidences", 3);
}

TEST(WritePcd, WritesTheHeaderOfTheFormat) {
  const TempFolder folder;
  WritePcd({{{1, 2, 3}}, {{0, 0, 1}}, {{1, 2, 3}}}, folder / "a.pcd");
  const std::string expected =
      "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\n"
      "FIELDS x y z normal_x normal_y normal_z rgb\nSIZE 4 4 4 4 4 4 4\nTYPE F F F F F F F\n"
      "COUNT 1 1 1 1 1 1 1\nWIDTH 1\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 1\nDATA binary\n";
  const std::string file = ReadBytes(folder / "a.pcd");
  EXPECT_EQ(file.substr(0, expected.size()), expected);
  EXPECT_EQ(file.size(), expected.size() + 7 * 4);
  ExpectInputError([] { WritePcd({}, "/nowhere/a.pcd"); }, Names("/nowhere/a.pcd"));
}

}  // namespace
}  // namespace surfit::testing
