#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>

#include "geometry/kd_tree.h"
#include "surfit/evaluation/map_error.h"
#include "surfit/io/point_cloud.h"
#include "testing/matchers.h"
#include "testing/run_program.h"
#include "tools/slam_tool.h"

namespace surfit::testing {
namespace {

// Triangles at the end of a binary PLY file: a byte 3 and three 32-bit indices per triangle.
std::vector<std::array<std::uint32_t, 3>> TrianglesOf(const std::string& path) {
  const std::string file = ReadBytes(path);
  const std::string key = "element face ";
  const std::size_t count = std::stoul(file.substr(file.find(key) + key.size(), 20));
  std::vector<std::array<std::uint32_t, 3>> triangles(count);
  for (std::size_t i = 0; i < count; ++i)
    std::memcpy(&triangles[i], &file[file.size() - 13 * (count - i) + 1], 12);
  return triangles;
}

// Vertices and centres of the triangles.
std::vector<Eigen::Vector3f> SamplesOf(const std::string& path) {
  const std::vector<Eigen::Vector3f> vertices = ReadPly(path).points;
  std::vector<Eigen::Vector3f> samples = vertices;
  for (const auto& t : TrianglesOf(path))
    samples.push_back((vertices.at(t[0]) + vertices.at(t[1]) + vertices.at(t[2])) / 3);
  return samples;
}

// Ratio of the mesh area whose triangle centres are farther than `distance_m` from all points.
double ShareFartherThan(double distance_m, const std::string& path,
                        const std::vector<Eigen::Vector3f>& points) {
  const std::vector<Eigen::Vector3f> vertices = ReadPly(path).points;
  const KdTree tree(points);
  double area = 0, far_area = 0;
  for (const auto& t : TrianglesOf(path)) {
    const Eigen::Vector3f &a = vertices[t[0]], &b = vertices[t[1]], &c = vertices[t[2]];
    const double twice_its_area = (b - a).cross(c - a).norm();
    area += twice_its_area;
    const float squared_m = static_cast<float>(distance_m * distance_m);
    if (tree.Nearest((a + b + c) / 3, squared_m).rank == KdTree::kNone) far_area += twice_its_area;
  }
  return far_area / area;
}

// Half sphere of radius 0.5 m about the origin, z > 0, with outward normals.
PointCloud HalfSphere() {
  PointCloud cloud;
  const int count = 20000;
  for (int i = 0; i < count; ++i) {  // a spiral with constant steps in z
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
    Succeeded(RunProgram(program, flags));
  };
  run("surfit_simulate", {"--output=" + (folder / "room"), "--frames=40", "--downsample=2"});
  run("surfit_slam", {"--sequence=" + (folder / "room"), "--output=" + (folder / "out"),
                      "--poses=groundtruth", "--initial_pose=groundtruth", "--nopictures"});
  const auto mesh = [&](const char* map, const char* name, std::vector<std::string> flags) {
    flags.insert(flags.end(), {"--map=" + (folder / map), "--output=" + (folder / name)});
    run("surfit_mesh", flags);
  };
  mesh("out/map.ply", "mesh.ply", {});
  PointCloud surface = ReadPly(folder / "room/surface.ply");  // visible surface
  const MapError error =
      ComputeMapError(SamplesOf(folder / "mesh.ply"), surface.points, surface.normals, {0.02});
  std::printf("mesh to exact surface: mean %.4f m, max %.4f m; complete %.3f\n",
              error.accuracy_m.mean, error.accuracy_m.max, error.completeness);
  EXPECT_LE(error.accuracy_m.mean, 0.005);
  EXPECT_GT(error.completeness, 0.9);

  // The mesh has no triangles in unobserved space. Points are exact discs with a radius of 10 mm,
  // so each triangle is within one cell (20 mm) along the normal, and two radii sideways.
  const double reach_m = std::hypot(0.02, 2 * 0.01);
  surface.radii_m.assign(surface.points.size(), 0.01f);
  WritePly(surface, folder / "exact.ply");
  mesh("exact.ply", "trimmed.ply", {"--cell_m=0.02"});
  EXPECT_EQ(ShareFartherThan(reach_m, folder / "trimmed.ply", surface.points), 0);
}

TEST(MeshTool, EndsAtTheBorderOfThePoints) {
  const TempFolder folder;
  WritePly(HalfSphere(), folder / "half.ply");
  for (const char* name : {"a.ply", "b.ply"}) {
    const ProgramResult result = Succeeded(
        RunProgram("surfit_mesh",
                   {"--map=" + (folder / "half.ply"), "--output=" + (folder / name),
                    "--cell_m=0.02", std::string("--threads=") + (name[0] == 'a' ? "1" : "2")}));
    EXPECT_THAT(result.out, Names(20000, 0, 1));
  }
  EXPECT_TRUE(ReadBytes(folder / "a.ply") == ReadBytes(folder / "b.ply"));
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

// The volume of the closed half sphere is 2 / 3 pi r^3.
TEST(MeshTool, ClosesTheHalfSphere) {
  const TempFolder folder;
  WritePly(HalfSphere(), folder / "half.ply");
  const ProgramResult result = Succeeded(
      RunProgram("surfit_mesh", {"--map=" + (folder / "half.ply"), "--output=" + (folder / "a.ply"),
                                 "--cell_m=0.02", "--watertight"}));
  EXPECT_THAT(result.out, Names("watertight", 1));
  const std::vector<Eigen::Vector3f> vertices = ReadPly(folder / "a.ply").points;
  double volume = 0;
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> sides;
  for (const auto& t : TrianglesOf(folder / "a.ply")) {
    volume += vertices[t[0]].dot(vertices[t[1]].cross(vertices[t[2]])) / 6;
    for (int k = 0; k < 3; ++k) ++sides[{t[k], t[(k + 1) % 3]}];
  }
  for (const auto& [side, count] : sides) {
    ASSERT_EQ(count, 1);
    ASSERT_EQ(sides.count({side.second, side.first}), 1u);
  }
  // The mesh extends at most one cell and two radii below z = 0.
  EXPECT_NEAR(volume, 2. / 3 * M_PI * 0.125, 0.05 * 0.26);
}

TEST(MeshTool, WritesObj) {
  const TempFolder folder;
  WritePly(HalfSphere(), folder / "half.ply");
  Succeeded(RunProgram("surfit_mesh", {"--map=" + (folder / "half.ply"), "--cell_m=0.05",
                                       "--output=" + (folder / "mesh.obj")}));
  std::istringstream file(ReadBytes(folder / "mesh.obj"));
  std::string line, word;
  double x = 0, y = 0, z = 0, red = 0;
  while (std::getline(file, line) && line.substr(0, 2) != "v ") {
  }
  ASSERT_TRUE(std::istringstream(line) >> word >> x >> y >> z >> red) << line;
  EXPECT_NEAR(std::hypot(x, y, z), 0.5, 0.05);
  EXPECT_NEAR(red, 200 / 255., 0.01);
}

class RunMeshTool : public SlamTool {
 protected:
  ProgramResult Mesh(const std::string& run, const std::string& name,
                     std::vector<std::string> flags = {}) const {
    flags.insert(flags.begin(), {"--run=" + run, "--output=" + Output(name)});
    return RunProgram("surfit_mesh", flags);
  }
};

TEST_F(RunMeshTool, HasATextureFromTheFramesOfTheRun) {
  Succeeded(Slam(Room(), Output(), {"--hold_out=5"}));
  const ProgramResult result = Succeeded(Mesh(Output(), "a.obj", {"--threads=1"}));
  EXPECT_THAT(result.out, Names(20));  // all frames except held-out frames
  Succeeded(Mesh(Output(), "b.obj", {"--threads=2"}));
  EXPECT_EQ(ReadBytes(Output("a.jpg")), ReadBytes(Output("b.jpg")));
  EXPECT_EQ(Lines(Output("a.obj")).size(), Lines(Output("b.obj")).size());
  EXPECT_EQ(Lines(Output("a.obj"))[0], "mtllib a.mtl");
  Succeeded(Mesh(Output(), "c.glb"));
  EXPECT_THAT(ReadBytes(Output("c.glb")), Names("image/jpeg"));
  // Meshes without texture.
  Succeeded(Mesh(Output(), "d.obj", {"--max_texture_px=0"}));
  EXPECT_FALSE(std::filesystem::exists(Output("d.jpg")));
  Succeeded(Mesh(Output(), "e.ply"));
  EXPECT_FALSE(std::filesystem::exists(Output("e.jpg")));
}

TEST_F(RunMeshTool, RejectsBadRunsAndTextures) {
  ExpectRefused(Mesh(Output("none"), "a.obj"), "none/summary.json");
  Succeeded(Slam(Room(), Output(), {"--last=3"}));
  // The mesh is complete before the error, so stderr may contain progress lines.
  const ProgramResult small = Mesh(Output(), "a.obj", {"--max_texture_px=20"});
  EXPECT_EQ(small.exit_code, 1);
  EXPECT_THAT(small.err, HasError("max_texture_px", 20));
  ExpectRefused(Mesh(Output(), "a.obj", {"--max_texture_px=-1"}), "max_texture_px", -1);
  ExpectRefused(Mesh(Output(), "a.obj", {"--sequence=" + Output("none")}), "none");
  std::filesystem::remove(Output() + "/poses.json");
  ExpectRefused(Mesh(Output(), "a.obj"), "poses.json");
  std::filesystem::remove(Output() + "/map.ply");
  ExpectRefused(Mesh(Output(), "a.ply"), "map.ply");
}

TEST(MeshTool, RejectsBadInput) {
  const TempFolder folder;
  PointCloud cloud = HalfSphere();
  WritePly(cloud, folder / "half.ply");
  cloud.normals.clear();
  WritePly(cloud, folder / "points.ply");
  const auto expect = [&](const std::string& map, std::vector<std::string> flags,
                          const auto&... names) {
    flags.insert(flags.begin(), "--output=" + (folder / "mesh.ply"));
    flags.push_back("--map=" + (folder / map));
    ExpectRefused(RunProgram("surfit_mesh", flags), names...);
  };
  expect("half.ply", {"--output=a.stl"}, "a.stl", ".ply", ".obj", ".glb");
  expect("half.ply", {"--cell_m=0"}, "cell_m", 0);
  expect("half.ply", {"--cell_m=1e-9"}, "cell_m");
  // A piece of 6 cm is smaller than min_component_m.
  PointCloud tiny = HalfSphere();
  for (Eigen::Vector3f& point : tiny.points) point *= 0.06f;
  WritePly(tiny, folder / "tiny.ply");
  expect("tiny.ply", {}, "cell_m", "trim_distance_m", "min_component_m");
  expect("half.ply", {"--cell_m=-1"}, "cell_m", -1);
  expect("points.ply", {}, "map");
  ExpectRefused(RunProgram("surfit_mesh", {"--output=" + (folder / "mesh.ply")}), "--map");
}

}  // namespace
}  // namespace surfit::testing
