#include "mesh/poisson_mesh.h"

#include <open3d/geometry/PointCloud.h>
#include <open3d/geometry/TriangleMesh.h>
#include <open3d/io/TriangleMeshIO.h>
#include <open3d/utility/Logging.h>

#include <cmath>

#include "mesh/trim_mesh.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"

namespace surfit::tools {
namespace {

namespace o3d = open3d::geometry;

constexpr float kCubeScale = 1.1f;  // of the octree to the cloud's bounding cube

o3d::PointCloud ToOpen3d(const PointCloud& cloud) {
  o3d::PointCloud points;
  for (const auto& p : cloud.points) points.points_.push_back(p.cast<double>());
  for (const auto& n : cloud.normals) points.normals_.push_back(n.cast<double>());
  for (const Rgb8 c : cloud.colors) points.colors_.push_back(Eigen::Vector3d(c.r, c.g, c.b) / 255.);
  return points;
}

// The octree's depth at which its cells are at most cell_m wide.
int OctreeDepth(const o3d::PointCloud& points, double cell_m) {
  constexpr double kDeepest = 12;  // 4096 cells a side
  const double side_m = kCubeScale * (points.GetMaxBound() - points.GetMinBound()).maxCoeff();
  if (!(side_m > cell_m)) throw InputError("the map is smaller than one cell");
  const double depth = std::ceil(std::log2(side_m / cell_m));
  if (depth > kDeepest)
    throw InputError(Concat("cell_m is ", cell_m, ", must be at least ",
                            side_m / std::exp2(kDeepest), " for a map of this size"));
  return static_cast<int>(depth);
}

}  // namespace

void MeshOptions::Visit(OptionVisitor& v) {
  v.Add(cell_m, "cell_m", "size of the finest cells; triangles are about as large", Positive(),
        AsFlag());
  v.Add(trim_distance_m, "trim_distance_m",
        "nothing farther than this from all points of the map is kept", Positive(), AsFlag());
  v.Add(support_radii, "support_radii",
        "nothing beyond this many radii sideways of all surfels, or cell_m off their planes, is "
        "kept; maps without radii are trimmed by distance alone",
        Positive(), AsFlag());
}

MeshSummary WritePoissonMesh(const PointCloud& cloud, const MeshOptions& options,
                             const std::string& path) {
  constexpr int kThreads = 1;  // with more, sums depend on who is first
  Validate(options);
  if (cloud.normals.empty()) throw InputError("the map has no points with normals");
  open3d::utility::SetVerbosityLevel(open3d::utility::VerbosityLevel::Error);
  const o3d::PointCloud points = ToOpen3d(cloud);
  const int depth = OctreeDepth(points, options.cell_m);
  const auto [mesh, densities] = o3d::TriangleMesh::CreateFromPointCloudPoisson(
      points, static_cast<std::size_t>(depth), 0, kCubeScale, false, kThreads);
  MeshSummary summary;
  summary.triangles_trimmed = TrimMesh(cloud, options, mesh.get());
  summary.vertices = mesh->vertices_.size();
  summary.triangles = mesh->triangles_.size();
  if (mesh->triangles_.empty())
    throw InputError("the map supports no triangle: see trim_distance_m and support_radii");
  if (!open3d::io::WriteTriangleMesh(path, *mesh)) throw InputError("cannot write '" + path + "'");
  return summary;
}

}  // namespace surfit::tools
