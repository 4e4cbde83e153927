

#include "surfit/io/point_cloud.h"
#include "testing/matchers.h"
#include "testing/recordings.h"
#include "testing/sequence_writer.h"

namespace surfit::testing {
namespace {

std::string Reversed(std::string bytes) {
  std::reverse(bytes.begin(), bytes.end());
  return bytes;
}

TEST(Ply, ReadsBigEndianAndUpperCaseNames) {
  const TempFolder folder;
  const PointCloud cloud = ReadPointCloud(folder.Write(
      "a.ply",
      "ply\nformat binary_big_endian 1.0\nelement VERTEX 1\nproperty float X\nproperty "
      "double Y\nproperty short Z\nend_header\n" +
          Reversed(LittleEndian(1.5f)) + Reversed(LittleEndian(2.5)) +
          Reversed(LittleEndian(std::int16_t{-3}))));
  ASSERT_EQ(cloud.points.size(), 1u);
  EXPECT_EQ(cloud.points[0], Eigen::Vector3f(1.5f, 2.5f, -3));
}

TEST(Pcd, SkipsFieldsOfEightBytes) {
  const TempFolder folder;
  const PointCloud cloud = ReadPointCloud(folder.Write(
      "a.pcd",
      "VERSION 0.7\nFIELDS t x y z s\nSIZE 8 4 4 4 8\nTYPE U F F F I\nWIDTH 1\nHEIGHT 1\n"
      "POINTS 1\nDATA binary\n" +
          LittleEndian(std::uint64_t{7}, 1.f, 2.f, 3.f, std::int64_t{-9})));
  ASSERT_EQ(cloud.points.size(), 1u);
  EXPECT_EQ(cloud.points[0], Eigen::Vector3f(1, 2, 3));
}

TEST(ReadPointCloud, KeepsThePrecisionOfCoordinatesFarFromTheOrigin) {
  const TempFolder folder;
  const auto write = [&](double x) {
    return folder.Write("a.ply",
                        "ply\nformat binary_little_endian 1.0\nelement vertex 2\nproperty double "
                        "x\nproperty double y\nproperty double z\nelement face 5\nend_header\n" +
                            LittleEndian(x, 0., 0., x + 0.001, 0., 0.));
  };
  std::optional<Eigen::Vector3d> origin;
  PointCloud far = ReadPointCloud(write(5e6 + 3), &origin);
  EXPECT_EQ(*origin, Eigen::Vector3d(5e6 + 3, 0, 0));
  EXPECT_EQ(far.points[0].x(), 0);
  EXPECT_NEAR(far.points[1].x(), 0.001, 1e-8);
  EXPECT_THAT(ReadTriangles(folder / "a.ply"), IsEmpty());  // faces without a list
  far.origin = *origin;
  WritePly(far, folder / "b.ply");
  EXPECT_EQ(ReadPointCloud(folder / "b.ply", &origin).points, far.points);
  origin.reset();
  EXPECT_EQ(ReadPointCloud(write(3), &origin).points[0], Eigen::Vector3f(3, 0, 0));
  EXPECT_EQ(*origin, Eigen::Vector3d(0, 0, 0));
}

constexpr char kVertices[] =
    "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n";

TEST(ReadTriangles, SplitsFacesOfBinaryAndAsciiFilesIntoFans) {
  const std::vector<Eigen::Vector3i> expected = {{2, 1, 0}, {0, 1, 2}, {0, 2, 3}};
  const TempFolder folder;
  const std::string ascii = folder.Write(
      "a.ply", Concat("ply\nformat ascii 1.0\n", kVertices,
                      "element face 3\nproperty uchar quality\nproperty list uchar int "
                      "vertex_index\nend_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n9 3 2 1 0\n9 2 0 1\n"
                      "9 4 0 1 2 3\n"));
  EXPECT_EQ(ReadTriangles(ascii), expected);
  const auto byte = [](int value) { return static_cast<std::uint8_t>(value); };
  const std::string binary = folder.Write(
      "b.ply", Concat("ply\nformat binary_little_endian 1.0\n", kVertices,
                      "element face 2\nproperty list uchar int vertex_indices\nend_header\n",
                      LittleEndian(0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 1.f, 1.f, 0.f, 0.f, 1.f, 0.f),
                      LittleEndian(byte(3), 2, 1, 0, byte(4), 0, 1, 2, 3)));
  EXPECT_EQ(ReadTriangles(binary), expected);
}

TEST(ReadTriangles, RejectsIndexBeyondTheVertices) {
  const TempFolder folder;
  const std::string path = folder.Write(
      "a.ply", Concat("ply\nformat ascii 1.0\n", kVertices,
                      "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
                      "0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 4\n"));
  EXPECT_THAT([&] { ReadTriangles(path); }, ThrowsNaming<InputError>("a.ply", "face 0", 4, 3));
}

}  // namespace
}  // namespace surfit::testing
