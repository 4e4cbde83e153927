#include "apps/solvers/cloud_file.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "surfit/core/error.h"

namespace surfit {
namespace {

void KeepFinitePoints(const std::string& what, PointCloud* cloud, RegisteredCloud* about) {
  about->not_finite = RemoveNonFinite(cloud);
  about->points = cloud->points.size();
  if (cloud->points.empty()) throw InputError(Concat(what, ": contains no finite points"));
  if (cloud->points.size() > std::size_t{1} << 30) {
    throw InputError(
        Concat(what, ": contains ", cloud->points.size(), " points, must be at most 2^30"));
  }
}

// Scales normals to unit length. Zero and non-finite normals become (0, 0, 0).
void Normalize(std::vector<Eigen::Vector3f>* normals) {
  for (Eigen::Vector3f& normal : *normals) {
    const float length = normal.norm();
    if (std::isfinite(length) && length > 0) {
      normal /= length;
    } else {
      normal.setZero();
    }
  }
}

PointSet MakePointSet(const CloudSensor& sensor, const CloudNormalOptions& normals,
                      double floor_sigma_m, PointCloud* cloud, RegisteredCloud* about) {
  PointSet set;
  set.points = cloud->points;
  set.sigma_m.assign(set.size(), static_cast<float>(floor_sigma_m));
  if (cloud->normals.empty()) {
    CloudNormals estimated = EstimateCloudNormals(cloud->points, sensor, normals);
    about->normal_radius_m = estimated.radius_m;
    cloud->normals = std::move(estimated.normals);
    for (std::size_t i = 0; i < set.size(); ++i) {
      set.sigma_m[i] = std::hypot(set.sigma_m[i], estimated.deviation_m[i]);
    }
  } else {
    Normalize(&cloud->normals);
  }
  set.normals = cloud->normals;
  about->without_normal = std::count_if(set.normals.begin(), set.normals.end(),
                                        [](const auto& normal) { return normal.isZero(0); });
  return set;
}

}  // namespace

PreparedCloud PrepareCloud(PointCloud cloud, const std::string& what, const CloudSensor& sensor,
                           const CloudNormalOptions& normals, double floor_sigma_m) {
  PreparedCloud prepared;
  prepared.cloud = std::move(cloud);
  KeepFinitePoints(what, &prepared.cloud, &prepared.about);
  prepared.points = MakePointSet(sensor, normals, floor_sigma_m, &prepared.cloud, &prepared.about);
  return prepared;
}

PreparedCloud ReadCloudFile(const std::string& path, const CloudSensor& sensor,
                            const CloudNormalOptions& normals, double floor_sigma_m) {
  return PrepareCloud(ReadPointCloud(path), path, sensor, normals, floor_sigma_m);
}

}  // namespace surfit
