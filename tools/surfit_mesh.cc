// Makes a triangle mesh of a map.

#include <cstdio>
#include <filesystem>

#include "common/console.h"
#include "common/tool_main.h"
#include "surfit/core/error.h"
#include "surfit/core/parallel.h"
#include "surfit/mesh/mesh_surfels.h"

namespace surfit::tools {
namespace {

struct Options {
  std::string map, output;
  MeshOptions mesh;
  int threads = 2;

  void Visit(OptionVisitor& v) {
    v.Add(map, "map", "the map, a PLY or PCD file with points and normals", Required(), AsFlag());
    v.Add(output, "output", "the mesh to write, .ply, .obj or .glb", Required(), AsFlag());
    v.AddPart(mesh, "mesh", "how fine it is, and how far it reaches");
    v.Add(threads, "threads", "threads that compute at the same time", Between(1, 1024), AsFlag());
  }
};

// What was made, how large it is, and how near to the points.
void Print(const Options& options, const PointCloud& cloud, std::size_t not_finite,
           const TriangleMesh& mesh, const MeshSummary& summary) {
  std::printf("%s: %zu points, %zu not finite; %zu vertices, %zu triangles in %zu pieces, %.1f MB",
              options.output.c_str(), cloud.points.size(), not_finite, mesh.vertices.size(),
              mesh.triangles.size(), summary.pieces,
              1e-6 * static_cast<double>(std::filesystem::file_size(options.output)));
  if (summary.pieces_dropped > 0) {
    std::printf("; %zu pieces smaller than %g m left out, with %zu triangles",
                summary.pieces_dropped, options.mesh.min_piece_m, summary.triangles_dropped);
  }
  if (summary.triangles_found > mesh.triangles.size()) {
    std::printf("; of %zu triangles, which moved the surface by %.2f mm", summary.triangles_found,
                1e3 * summary.decimation_m);
  }
  std::printf(
      "; half of the points are within %.2f mm of the mesh, 90 %% within %.2f mm, %.1f %% "
      "beside none\n",
      1e3 * summary.median_distance_m, 1e3 * summary.p90_distance_m, 100 * (1 - summary.covered));
}

int Run(const Options& options) {
  RequireMeshEnding(options.output);
  const ThreadLimit limit(options.threads);
  ProgressLine progress;
  progress.Show("reading the map", false);
  PointCloud cloud = ReadPointCloud(options.map);
  const std::size_t not_finite = RemoveNonFinite(&cloud);
  MeshSummary summary;
  const auto show = [&](const std::string& stage, double share) {
    progress.Show(Concat(static_cast<int>(100 * share), " %  ", stage), false);
  };
  const TriangleMesh mesh = MeshSurfels(cloud, options.mesh, &summary, show);
  WriteMesh(mesh, options.output);
  progress.Show(Concat("done in ", static_cast<int>(progress.elapsed_s()), " s"), true);
  Print(options, cloud, not_finite, mesh, summary);
  return kDone;
}

}  // namespace
}  // namespace surfit::tools

int main(int argc, char** argv) {
  return surfit::tools::ToolMain(
      argc, argv,
      "makes a triangle mesh with colours of a map: the surface of its surfels, smoothed by their "
      "noise and confidence, with holes where nothing was seen",
      surfit::tools::Run);
}
