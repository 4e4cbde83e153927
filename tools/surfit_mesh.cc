// Makes a triangle mesh of a map.

#include <gflags/gflags.h>

#include <cstdio>
#include <filesystem>

#include "common/tool_main.h"
#include "mesh/poisson_mesh.h"
#include "surfit/core/error.h"

namespace {

const surfit::tools::MeshOptions kMesh;

}  // namespace

DEFINE_string(map, "", "the map, a PLY or PCD file with points and normals");
DEFINE_string(output, "", "the mesh to write, .ply or .obj");
DEFINE_double(cell_m, kMesh.cell_m, "size of the finest cells; triangles are about as large");
DEFINE_double(trim_distance_m, kMesh.trim_distance_m,
              "nothing farther than this from all points of the map is kept");
DEFINE_double(
    support_radii, kMesh.support_radii,
    "nothing beyond so many radii sideways of all surfels, or cell_m off their planes, is "
    "kept; maps without radii are trimmed by distance alone");

namespace surfit::tools {
namespace {

int Run() {
  RequireFlag("map", FLAGS_map);
  RequireFlag("output", FLAGS_output);
  const std::string ending = std::filesystem::path(FLAGS_output).extension();
  if (ending != ".ply" && ending != ".obj")
    throw InputError(Concat("--output is ", FLAGS_output, ", must end in .ply or .obj"));
  PointCloud cloud = ReadPointCloud(FLAGS_map);
  const std::size_t removed = RemoveNonFinite(&cloud);
  const MeshSummary summary = WritePoissonMesh(
      cloud, {FLAGS_cell_m, FLAGS_trim_distance_m, FLAGS_support_radii}, FLAGS_output);
  std::printf("%s: %zu points, %zu not finite; %zu vertices, %zu triangles, %zu trimmed\n",
              FLAGS_output.c_str(), cloud.points.size(), removed, summary.vertices,
              summary.triangles, summary.triangles_trimmed);
  return kDone;
}

}  // namespace
}  // namespace surfit::tools

int main(int argc, char** argv) {
  return surfit::tools::ToolMain(argc, argv,
                                 "makes a triangle mesh with colours of a map (screened Poisson "
                                 "reconstruction), cut off where "
                                 "the map has no points",
                                 surfit::tools::Run);
}
