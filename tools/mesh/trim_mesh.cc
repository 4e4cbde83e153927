#include "mesh/trim_mesh.h"

#include <open3d/geometry/KDTreeFlann.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

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

}  // namespace

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

}  // namespace surfit::tools
