#include "mesh/poisson_mesh.h"

#include <open3d/geometry/KDTreeFlann.h>
#include <open3d/geometry/PointCloud.h>
#include <open3d/geometry/TriangleMesh.h>
#include <open3d/io/TriangleMeshIO.h>
#include <open3d/utility/Logging.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "surfit/core/error.h"
#include "surfit/core/options.h"

namespace surfit::tools {
namespace {

namespace o3d = open3d::geometry;

// Which places the cloud's points support.
class Support {
 public:
  Support(const PointCloud& cloud, const MeshOptions& options) : cloud_(cloud), options_(options) {
    Eigen::MatrixXd columns(3, cloud.points.size());
    for (std::size_t i = 0; i < cloud.points.size(); ++i) {
      columns.col(static_cast<Eigen::Index>(i)) = cloud.points[i].cast<double>();
    }
    tree_.SetMatrixData(columns);
  }

  // The nearest point nearly always tells.
  bool Reaches(const Eigen::Vector3d& place) {
    tree_.SearchKNN(place, 1, indices_, squared_distances_);
    if (squared_distances_[0] > options_.trim_distance_m * options_.trim_distance_m) return false;
    if (IsSupportedBy(indices_[0], place)) return true;
    tree_.SearchRadius(place, options_.trim_distance_m, indices_, squared_distances_);
    return std::any_of(indices_.begin(), indices_.end(),
                       [&](int i) { return IsSupportedBy(i, place); });
  }

 private:
  // All indices are within trim_distance_m.
  bool IsSupportedBy(int i, const Eigen::Vector3d& place) const {
    if (cloud_.radii_m.empty()) return true;
    const Eigen::Vector3d offset = place - cloud_.points[i].cast<double>();
    const Eigen::Vector3d normal = cloud_.normals[i].cast<double>();
    const double height_m = normal.dot(offset);
    const double sideways_m = (offset - height_m * normal).norm();
    return std::abs(height_m) <= options_.cell_m &&
           sideways_m <= options_.support_radii * cloud_.radii_m[i];
  }

  const PointCloud& cloud_;
  const MeshOptions& options_;
  o3d::KDTreeFlann tree_;
  std::vector<int> indices_;
  std::vector<double> squared_distances_;
};

// A triangle's corners, middles of sides and centre: sides are hardly longer than a few cells, so
// that whatever reaches far beyond the points shows at one of these.
std::array<Eigen::Vector3d, 7> SamplesOf(const o3d::TriangleMesh& mesh, std::size_t triangle) {
  const Eigen::Vector3i& corners = mesh.triangles_[triangle];
  const Eigen::Vector3d& a = mesh.vertices_[corners[0]];
  const Eigen::Vector3d& b = mesh.vertices_[corners[1]];
  const Eigen::Vector3d& c = mesh.vertices_[corners[2]];
  return {(a + b + c) / 3, a, b, c, (a + b) / 2, (b + c) / 2, (c + a) / 2};
}

// Removes the triangles that no point of the cloud supports (MeshOptions), and the vertices that no
// triangle is left of; returns how many triangles. The cloud's points and normals must be finite.
std::size_t TrimMesh(const PointCloud& cloud, const MeshOptions& options, o3d::TriangleMesh* mesh) {
  Support support(cloud, options);
  std::vector<bool> is_unsupported(mesh->triangles_.size());
  for (std::size_t i = 0; i < is_unsupported.size(); ++i) {
    const auto samples = SamplesOf(*mesh, i);
    is_unsupported[i] = !std::all_of(samples.begin(), samples.end(),
                                     [&](const auto& sample) { return support.Reaches(sample); });
  }
  mesh->RemoveTrianglesByMask(is_unsupported);
  mesh->RemoveUnreferencedVertices();
  return static_cast<std::size_t>(std::count(is_unsupported.begin(), is_unsupported.end(), true));
}

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
