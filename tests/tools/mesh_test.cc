#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>

#include "surfit/evaluation/map_error.h"
#include "surfit/io/point_cloud.h"
#include "testing/run_program.h"

namespace surfit {
namespace {

using ::testing::HasSubstr;
using testing::ProgramResult;
using testing::RunProgram;
using testing::TempFolder;

// The triangles at the end of a binary PLY file: a byte 3 and three 32-bit indices each.
std::vector<std::array<std::uint32_t, 3>> TrianglesOf(const std::string& path) {
  const std::string file = testing::ReadBytes(path);
  const std::string key = "element face ";
  const std::size_t count = std::stoul(file.substr(file.find(key) + key.size(), 20));
  std::vector<std::array<std::uint32_t, 3>> triangles(count);
  for (std::size_t i = 0; i < count; ++i)
    std::memcpy(&triangles[i], &file[file.size() - 13 * (count - i) + 1], 12);
  return triangles;
}

// Corners and centres of the triangles.
std::vector<Eigen::Vector3f> SamplesOf(const std::string& path) {
  const std::vector<Eigen::Vector3f> vertices = ReadPly(path).points;
  std::vector<Eigen::Vector3f> samples = vertices;
  for (const auto& t : TrianglesOf(path))
    samples.push_back((vertices.at(t[0]) + vertices.at(t[1]) + vertices.at(t[2])) / 3);
  return samples;
}

// Half a sphere of radius 0.5 m about the origin, z > 0, seen from outside.
PointCloud HalfSphere() {
  PointCloud cloud;
  const int count = 20000;
  for (int i = 0; i < count; ++i) {  // a spiral of even steps in z
    const float z = (static_cast<float>(i) + 0.5f) / count, r = std::sqrt(1 - z * z);
    const float angle = 2.3999632f * static_cast<float>(i);
    cloud.normals.push_back({r * std::cos(angle), r * std::sin(angle), z});
    cloud.points.push_back(0.5f * cloud.normals.back());
    cloud.colors.push_back({200, 100, 50});
  }
  return cloud;
}

TEST(MeshTool, MeshesTheSimulatedRoom) {
  const TempFolder folder;
  const auto run = [](const char* program, const std::vector<std::string>& flags) {
    const ProgramResult result = RunProgram(program, flags);
    ASSERT_EQ(result.exit_code, 0) << program << ": " << result.err;
  };
  run("surfit_simulate", {"--output=" + (folder / "room"), "--frames=40", "--downsample=2"});
  run("surfit_slam", {"--sequence=" + (folder / "room"), "--output=" + (folder / "out"),
                      "--poses=groundtruth", "--initial_pose=groundtruth", "--nopictures"});
  run("surfit_mesh", {"--map=" + (folder / "out/map.ply"), "--output=" + (folder / "mesh.ply")});
  const PointCloud surface = ReadPly(folder / "room/surface.ply");
  const MapError error =
      ComputeMapError(SamplesOf(folder / "mesh.ply"), surface.points, surface.normals, {0.02});
  std::printf("mesh to exact surface: mean %.4f m, max %.4f m; complete %.3f\n",
              error.accuracy_m.mean, error.accuracy_m.max, error.completeness);
  EXPECT_LE(error.accuracy_m.mean, 0.005);
  // Nothing where nothing was seen: not beyond the trimming distance, the noise of the surfels
  // themselves (a few centimetres at the room's far end) and the samples' grid.
  const MapError surfels = ComputeMapError(ReadPly(folder / "out/map.ply").points, surface.points,
                                           surface.normals, {0.02});
  EXPECT_LE(error.accuracy_m.max, 0.02 + surfels.accuracy_m.max);
  EXPECT_GT(error.completeness, 0.9);
}

// A Poisson surface is closed: without trimming it would go on below z = 0.
TEST(MeshTool, EndsWhereThePointsDo) {
  const TempFolder folder;
  WritePly(HalfSphere(), folder / "half.ply");
  for (const char* name : {"a.ply", "b.ply"}) {
    const ProgramResult result = RunProgram(
        "surfit_mesh",
        {"--map=" + (folder / "half.ply"), "--output=" + (folder / name), "--cell_m=0.02"});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    EXPECT_THAT(result.out, HasSubstr("20000 points, 0 not finite"));
  }
  EXPECT_TRUE(testing::ReadBytes(folder / "a.ply") == testing::ReadBytes(folder / "b.ply"));
  const auto samples = SamplesOf(folder / "a.ply");
  ASSERT_GT(samples.size(), 1000u);
  for (const Eigen::Vector3f& sample : samples) {
    EXPECT_NEAR(sample.norm(), 0.5f, 0.02f);  // one cell
    EXPECT_GT(sample.z(), -0.02f);
  }
  const Rgb8 color = ReadPly(folder / "a.ply").colors.at(0);
  EXPECT_NEAR(color.r, 200, 2);
  EXPECT_NEAR(color.b, 50, 2);
}

TEST(MeshTool, WritesObj) {
  const TempFolder folder;
  WritePly(HalfSphere(), folder / "half.ply");
  const ProgramResult result = RunProgram(
      "surfit_mesh",
      {"--map=" + (folder / "half.ply"), "--cell_m=0.05", "--output=" + (folder / "mesh.obj")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  std::istringstream file(testing::ReadBytes(folder / "mesh.obj"));
  std::string line, word;
  double x = 0, y = 0, z = 0, red = 0;
  while (std::getline(file, line) && line.substr(0, 2) != "v ") {
  }
  ASSERT_TRUE(std::istringstream(line) >> word >> x >> y >> z >> red) << line;
  EXPECT_NEAR(std::hypot(x, y, z), 0.5, 0.05);
  EXPECT_NEAR(red, 200 / 255., 0.01);
}

TEST(MeshTool, RefusesBadInput) {
  const TempFolder folder;
  PointCloud cloud = HalfSphere();
  WritePly(cloud, folder / "half.ply");
  cloud.normals.clear();
  WritePly(cloud, folder / "points.ply");
  const auto expect = [&](const std::string& map, std::vector<std::string> flags,
                          const char* message) {
    flags.insert(flags.begin(), "--output=" + (folder / "mesh.ply"));
    flags.push_back("--map=" + (folder / map));
    const ProgramResult result = RunProgram("surfit_mesh", flags);
    EXPECT_EQ(result.exit_code, 1);
    EXPECT_THAT(result.err, HasSubstr(message));
  };
  expect("half.ply", {"--output=a.stl"}, "--output is a.stl, must end in .ply or .obj");
  expect("half.ply", {"--cell_m=0"}, "cell_m is 0, must be positive");
  expect("half.ply", {"--cell_m=0.0001"}, "cell_m is 0.0001, must be at least");
  expect("half.ply", {"--cell_m=5"}, "the map is smaller than one cell");
  expect("half.ply", {"--trim_distance_m=-1"}, "trim_distance_m is -1, must be positive");
  expect("points.ply", {}, "the map has no points with normals");
}

}  // namespace
}  // namespace surfit
