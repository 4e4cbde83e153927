// Makes a triangle mesh of a map.

#include <cstdio>
#include <filesystem>

#include "common/tool_main.h"
#include "mesh/poisson_mesh.h"
#include "surfit/core/error.h"

namespace surfit::tools {
namespace {

struct Options {
  std::string map, output;
  MeshOptions mesh;

  void Visit(OptionVisitor& v) {
    v.Add(map, "map", "the map, a PLY or PCD file with points and normals", Required(), AsFlag());
    v.Add(output, "output", "the mesh to write, .ply or .obj", Required(), AsFlag());
    v.AddPart(mesh, "mesh", "how fine it is, and how far it reaches");
  }
};

int Run(const Options& options) {
  const std::string ending = std::filesystem::path(options.output).extension();
  if (ending != ".ply" && ending != ".obj")
    throw InputError(Concat("--output is ", options.output, ", must end in .ply or .obj"));
  PointCloud cloud = ReadPointCloud(options.map);
  const std::size_t removed = RemoveNonFinite(&cloud);
  const MeshSummary summary = WritePoissonMesh(cloud, options.mesh, options.output);
  std::printf("%s: %zu points, %zu not finite; %zu vertices, %zu triangles, %zu trimmed\n",
              options.output.c_str(), cloud.points.size(), removed, summary.vertices,
              summary.triangles, summary.triangles_trimmed);
  return kDone;
}

}  // namespace
}  // namespace surfit::tools

int main(int argc, char** argv) {
  return surfit::tools::ToolMain(argc, argv,
                                 "makes a triangle mesh with colours of a map (screened Poisson "
                                 "reconstruction), cut off where the map has no points",
                                 surfit::tools::Run);
}
